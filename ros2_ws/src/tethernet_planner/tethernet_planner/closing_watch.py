"""What the planner knows when the closing is planned, without ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from tethernet_core.mission import Point
from tethernet_core.rotation import Quaternion
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.step_guard import StampGuard
from tethernet_planner import closing

DebrisMotion = tuple[Point, Quaternion, Point, Point]
"""Position [m], attitude (quaternion x y z w, body to launch), velocity [m/s] and angular rate [rad/s] in the body
frame: what an Odometry message carries."""

_PATIENCE = 3
"""A controller counts as dead when it has missed so many of the statuses it owes."""


class ClosingWatch:
    """Keeps the newest of what was measured; works out a sight of it only when one is asked for."""

    def __init__(self, mu_count: int, rules: MissionParameters, control: ControlParameters):
        """Args:
        mu_count: 4 or 8.
        rules: of the mission.
        control: tells how often controllers report.
        """
        self.aiming_points: list[Point] | None = None
        """Where the MUs were sent [m]."""
        self.debris: Callable[[], DebrisMotion | None] = lambda: None
        """Tells the debris' newest motion."""
        self._mu_count, self._rules = mu_count, rules
        self._patience_ns = (_PATIENCE * control.status_every + control.watchdog_periods) * control.period_ns
        self._positions: Sequence[Point] = ()
        self._velocities: Sequence[Point] = ()
        self._silent: set[int] = set()
        self._stamp_ns = 0
        self._answered = {mu: StampGuard(control) for mu in range(1, mu_count + 1)}

    def saw_mus(
        self,
        stamp_ns: int,
        positions: Sequence[Point],
        velocities: Sequence[Point],
        silent: Iterable[int] = (),
    ) -> None:
        """Where the MUs are.

        Args:
            stamp_ns: time [ns].
            positions: of those that were ever heard of, (M, 3) [m], MU 1 first.
            velocities: likewise [m/s].
            silent: MUs (from 1) of whom nothing is heard.
        """
        self._stamp_ns = stamp_ns
        self._positions, self._velocities, self._silent = positions, velocities, set(silent)

    def saw_status(self, mu: int, stamp_ns: int) -> None:
        """Controller ``mu`` has answered the odometry of ``stamp_ns``; 0: none yet. One that cannot be is ignored."""
        if stamp_ns > 0 and mu in self._answered:
            self._answered[mu].take(stamp_ns)

    def dead(self) -> set[int]:
        """MUs whose controllers have answered before, but not for a while."""
        return {
            mu
            for mu, answered in self._answered.items()
            if answered.newest is not None and self._stamp_ns - answered.newest > self._patience_ns
        }

    def look(self) -> closing.ClosingSituation | None:
        """The sight, or None where too little is known or winches close the net."""
        positions = np.asarray(self._positions, float).reshape(-1, 3)
        velocities = np.asarray(self._velocities, float).reshape(-1, 3)
        motion = self.debris()
        if self._mu_count != 8 or len(positions) != 8 or len(velocities) != 8 or motion is None:
            return None
        if not all(np.isfinite(values).all() for values in (positions, velocities, *motion)):
            return None
        lost = self._silent | self.dead()
        if self.aiming_points is not None:
            beside = closing.off_course(positions, self.aiming_points, self._rules)
            lost |= {mu for mu, far in enumerate(beside, start=1) if far}
        return closing.closing_situation(positions, velocities, *motion, [mu in lost for mu in range(1, 9)])
