"""What the planner knows when the closing is planned, without ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from tethernet_core.mission import Point
from tethernet_core.rotation import Quaternion
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.step_guard import StampGuard
from tethernet_core.system import System
from tethernet_planner.closing_situation import ClosingSituation, closing_situation, off_course

DebrisMotion = tuple[Point, Quaternion, Point, Point]
"""Position [m], attitude (quaternion x y z w, body to launch), velocity [m/s] and angular rate [rad/s] in the body
frame: what an Odometry message carries."""

_PATIENCE = 3
"""A controller counts as dead when it has missed so many of the statuses it owes."""


class ClosingWatch:
    """Keeps the newest of what was measured; works out a closing situation only when one is asked for."""

    def __init__(self, system: System, rules: MissionParameters, control: ControlParameters):
        """Args:
        system: net and units.
        rules: of the mission.
        control: tells how often controllers report.
        """
        self.aiming_points: list[Point] | None = None
        """Where the MUs were sent [m]."""
        self.debris: Callable[[], DebrisMotion | None] = lambda: None
        """Tells the debris' newest motion."""
        self._system, self._rules = system, rules
        self._patience_ns = (_PATIENCE * control.status_every + control.watchdog_periods) * control.period_ns
        self._positions: Sequence[Point] = ()
        self._velocities: Sequence[Point] = ()
        self._silent: set[int] = set()
        self._stamp_ns = 0
        self._answered = {mu: StampGuard(control) for mu in range(1, system.unit_count + 1)}

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

    def look(self) -> ClosingSituation | None:
        """The situation, or None where too little is known or the units do not dock."""
        positions = np.asarray(self._positions, float).reshape(-1, 3)
        velocities = np.asarray(self._velocities, float).reshape(-1, 3)
        motion = self.debris()
        count = self._system.unit_count
        docking = self._system.closing.kind == "docking"
        if not docking or len(positions) != count or len(velocities) != count or motion is None:
            return None
        if not all(np.isfinite(values).all() for values in (positions, velocities, *motion)):
            return None
        lost = self._silent | self.dead()
        if self.aiming_points is not None:
            beside = off_course(positions, np.array(self.aiming_points, float), self._system, self._rules)
            lost |= {mu for mu, far in enumerate(beside, start=1) if far}
        return closing_situation(positions, velocities, *motion, [mu in lost for mu in range(1, count + 1)])
