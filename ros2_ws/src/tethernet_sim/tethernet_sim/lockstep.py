"""Who still owes an answer to a control tick: the barrier of lock-step, and the book of thrust commands. No ROS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from tethernet_core.mission import seconds_between
from tethernet_core.settings import ControlParameters
from tethernet_core.system import Unit

ZERO = (0.0, 0.0, 0.0)
LOOKS = 10
"""How often to look at a wait until it runs out; a standstill of the one who waits passes for one look."""


@dataclass
class Barrier:
    """The set of participants that have not answered the present tick; answers to other ticks are ignored."""

    participants: frozenset[str]
    """Everyone who answers each tick."""
    lost: set[str] = field(default_factory=set)
    """Participants that let a wait run out; not waited for until they answer again."""
    stamp_ns: int = -1
    """The present tick [ns]."""
    pending: set[str] = field(default_factory=set)
    """Participants that are waited for."""
    waited_s: float = 0.0
    """How long the tick has been waited for, as :meth:`look` counts it [s]."""
    _looked_s: float = 0.0

    def open(self, stamp_ns: int, now_s: float) -> None:
        """Begin a tick.

        Args:
            stamp_ns: its time [ns].
            now_s: the present time on a steady clock [s].
        """
        self.stamp_ns = stamp_ns
        self.waited_s, self._looked_s = 0.0, now_s
        self.pending = set(self.participants) - self.lost

    def answer(self, who: str, stamp_ns: int) -> bool:
        """Note an answer.

        Returns:
            True when it was the last one missing.
        """
        if stamp_ns != self.stamp_ns:
            return False
        self.lost.discard(who)
        if who not in self.pending:
            return False
        self.pending.remove(who)
        return not self.pending

    def look(self, now_s: float, interval_s: float) -> float:
        """Look at the wait. A wait that the one who looks slept through, as on a machine that stood still, is none.

        Args:
            now_s: the present time on the clock of :meth:`open` [s].
            interval_s: between two looks [s]; whatever is longer counts as one.

        Returns:
            How long it has lasted [s].
        """
        self.waited_s += min(now_s - self._looked_s, interval_s)
        self._looked_s = now_s
        return self.waited_s

    def give_up(self) -> list[str]:
        """The wait has run out: whoever is pending is lost now. Returns them."""
        missing = sorted(self.pending)
        self.lost.update(missing)
        self.pending = set()
        return missing


class CommandBuffer:
    """The thrust commands of one MU: what is checked, limited, held and zeroed, and how often."""

    def __init__(self, control: ControlParameters, unit: Unit):
        """Args:
        control: gives the watchdog's patience.
        unit: gives the thrust limit.
        """
        self._control = control
        self._limit_n = unit.thrust_limit_n
        self._thrust = ZERO
        self._stamp_ns: int | None = None
        self.late = 0
        """Ticks that had to go on with an older command."""
        self.clipped = 0
        """Commands beyond the thrust limit."""
        self.zeroed = 0
        """Ticks flown at zero because the command was too old."""

    def take(self, stamp_ns: int, thrust: Sequence[float], now_ns: int) -> bool:
        """Take a command.

        Args:
            stamp_ns: of the odometry it answers [ns].
            thrust: x y z [N].
            now_ns: the present tick [ns].

        Returns:
            True when it is used. It is not when it is not finite, of the future, or older than the one held.
        """
        if not all(math.isfinite(value) for value in thrust) or stamp_ns > now_ns:
            return False
        if self._stamp_ns is not None and stamp_ns < self._stamp_ns:
            return False
        limit = self._limit_n
        x, y, z = thrust
        if max(map(abs, thrust)) > limit:
            self.clipped += 1
            x, y, z = (min(max(value, -limit), limit) for value in thrust)
        self._thrust, self._stamp_ns = (x, y, z), stamp_ns
        return True

    def thrust(self, now_ns: int) -> tuple[float, float, float]:
        """The thrust for the period that begins at ``now_ns`` [N]; counts late and too old commands."""
        if self._stamp_ns == now_ns:
            return self._thrust
        self.late += 1
        allowed = self._control.watchdog_periods * self._control.control_period_s
        if self._stamp_ns is None or seconds_between(self._stamp_ns, now_ns) > allowed + 1e-9:
            self.zeroed += 1
            return ZERO
        return self._thrust
