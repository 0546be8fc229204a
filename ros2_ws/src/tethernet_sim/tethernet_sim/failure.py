"""What a failed MU's thrusters do."""

from __future__ import annotations

import numpy as np

from tethernet_core.settings import NANOSECOND_S, ControlParameters
from tethernet_sim.scenario import Failure


class MuFailure:
    """The failure of one scenario, or none."""

    def __init__(self, failure: Failure | None, control: ControlParameters):
        """Args:
        failure: what happens, None: nothing.
        control: gives the watchdog's patience.
        """
        self.mu = failure.mu - 1 if failure else -1
        """Index of the MU."""
        self._kind = failure.kind if failure else ""
        self._begin_ns = round(failure.time_s / NANOSECOND_S) if failure else None
        self._watchdog_ns = control.watchdog_periods * control.period_ns
        self._held: np.ndarray | None = None

    def begun(self, stamp_ns: int) -> bool:
        """True once the MU has failed."""
        return self._begin_ns is not None and stamp_ns >= self._begin_ns

    def mute(self, stamp_ns: int) -> bool:
        """True once the MU gives no odometry any more."""
        return self._kind == "no_odometry" and self.begun(stamp_ns)

    def silent(self, stamp_ns: int) -> bool:
        """True once everybody knows, because the MU's odometry is too old."""
        return self._kind == "no_odometry" and self.begun(stamp_ns - self._watchdog_ns)

    def fired(self, stamp_ns: int, commanded: np.ndarray) -> np.ndarray:
        """Thrust [N], (3,), at a control tick after the failure, of the thrust that is commanded.

        Without odometry the controller does not command: what it commanded last is held until the watchdog ends it.
        """
        if self._held is None:
            self._held = commanded.copy()
        if self._kind == "no_thrust" or self.silent(stamp_ns):
            return np.zeros(3)
        return self._held
