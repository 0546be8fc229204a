"""The closing plan made before the trigger, a part of it at every control tick, so that the trigger costs no time.

Planning takes up to half a control period. Who plans at the trigger publishes too late: the controllers answer the next
ticks before the plan reaches them. So the plan is begun as soon as the net's approach lets the trigger be expected, for
what will be seen then, and spread over the ticks. Time is the measurements' stamps; work is counted in parts, not in
seconds: who replays the same measurements gets the same plan.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator, Sequence

from tethernet_core.settings import NANOSECOND_S, MissionParameters
from tethernet_core.system import System
from tethernet_planner import closing
from tethernet_planner.closing import ClosingPlan
from tethernet_planner.closing_situation import ClosingSituation, foreseen

_APPROACH_S = 1.0
"""The speed of approach is measured over this time: one tick's difference is mostly noise where the MUs' odometry
stands for the net."""
_STALE_S = 1.0
"""A plan is worth nothing when it is so much older than it should be: the approach has stopped in the meantime."""


class PlanAhead:
    """Makes the closing plan of one mission with units that dock ahead of its trigger."""

    def __init__(self, system: System, rules: MissionParameters):
        """Args:
        system: what the plan must know of net and debris.
        rules: trigger distance, how long ahead, and what the plan itself needs.
        """
        self._system, self._rules = system, rules
        self._approach: deque[tuple[int, float]] = deque()
        self._parts: Generator[None, None, ClosingPlan] | None = None
        self._begun_ns = 0
        self._plan: ClosingPlan | None = None
        self._planned_ns = 0

    def ready(self, stamp_ns: int) -> ClosingPlan | None:
        """The newest plan that is whole; None where the trigger came before there was one, or long after.

        Args:
            stamp_ns: of the trigger [ns].
        """
        old = (stamp_ns - self._planned_ns) * NANOSECOND_S > self._rules.plan_ahead_s + _STALE_S
        return None if old else self._plan

    def watch(
        self,
        stamp_ns: int,
        net_position: Sequence[float],
        debris_position: Sequence[float],
        look: Callable[[], ClosingSituation | None],
    ) -> None:
        """One control tick before the trigger: at most one look and one part of a plan.

        Args:
            stamp_ns: time of the measurements [ns].
            net_position: the net's centre of mass [m]; NaN where it is not known.
            debris_position: the debris' centre of mass [m]; likewise.
            look: see :func:`tethernet_planner.mission_rules.advance`; asked when a plan is begun.
        """
        to_go = self._time_to_go(stamp_ns, net_position, debris_position)
        if self._parts is None:
            ahead_s = self._rules.plan_ahead_s
            fresh = self._plan is not None and (stamp_ns - self._planned_ns) * NANOSECOND_S < ahead_s
            seen = None if fresh or to_go > ahead_s else look()
            if seen is None:
                return
            self._parts = closing.planning(foreseen(seen, to_go, self._system), self._system, self._rules)
            self._begun_ns = stamp_ns
        try:
            next(self._parts)
        except StopIteration as end:
            self._plan, self._planned_ns, self._parts = end.value, self._begun_ns, None

    def _time_to_go(self, stamp_ns: int, net_position: Sequence[float], debris_position: Sequence[float]) -> float:
        """Until the trigger, as far as the approach tells [s]; infinite where the net does not come nearer."""
        distance = math.dist(net_position, debris_position)
        if not math.isfinite(distance):
            return math.inf
        approach = self._approach
        approach.append((stamp_ns, distance))
        while (stamp_ns - approach[0][0]) * NANOSECOND_S > _APPROACH_S:
            approach.popleft()
        since_ns, far = approach[0]
        if far <= distance:
            return math.inf
        return (distance - self._rules.trigger_distance_m) * ((stamp_ns - since_ns) * NANOSECOND_S) / (far - distance)
