"""The mission's sequence and its handshake with the controllers, without ROS.

Every change of the mission's state is published, echoed by every controller that is reachable, and published again as
confirmed; only then does the next thing happen. Waiting is bounded in wall time: a controller that does not echo in
time counts as lost, is named in the state's reason, and is not waited for again until it echoes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence

from tethernet_core.mission import Mission, Phase, abort, arm, launch, seconds_between
from tethernet_core.settings import NANOSECOND_S, ControlParameters, MissionParameters
from tethernet_core.system import System
from tethernet_planner.closing_situation import ClosingSituation
from tethernet_planner.mission_rules import advance, check_debris_position
from tethernet_planner.plan_ahead import PlanAhead

Publish = Callable[[Mission, int, bool, str], None]
"""Publishes a state: mission, stamp [ns], confirmed, reason."""

Beat = Callable[[int], None]
"""Publishes the heartbeat for the control tick with this stamp [ns]."""


class MissionSequencer:
    """Leads one mission from start to end. The rules themselves are those of :mod:`tethernet_core.mission`."""

    def __init__(
        self,
        system: System,
        rules: MissionParameters,
        control: ControlParameters,
        publish: Publish,
        beat: Beat,
        clock: Callable[[], float] = time.monotonic,
        mission_id: int = 0,
    ):
        """Args:
        system: net and units.
        rules: of the mission.
        control: period of the control ticks, time limit of planning.
        publish: called at every change and again when it is confirmed.
        beat: called once for every tick that has been decided on.
        clock: wall time [s].
        mission_id: tells this planner's mission from that of any other.
        """
        self.mission = Mission(system.unit_count, mission_id=mission_id, hold_s=rules.hold_s, tow_n=rules.tow_n)
        self.confirmed = True
        self.lost: set[int] = set()
        self.stamp_ns = 0
        """Newest time anything was measured at [ns]."""
        self._mus = frozenset(range(1, system.unit_count + 1))
        self._system, self._rules, self._control = system, rules, control
        self._ahead = PlanAhead(system, rules)
        self._publish, self._beat, self._clock = publish, beat, clock
        self._awaited: set[int] = set()
        self._deadline_s = math.inf
        self._held_beat_ns: int | None = None

    def announce(self) -> None:
        """Publish the state as it is."""
        self._publish(self.mission, self.stamp_ns, self.confirmed, "")

    def start(self, debris_position: Sequence[float], policy: str) -> None:
        """Arm the mission; launch follows as soon as the controllers have their aiming points.

        Args:
            debris_position: the debris' centre of mass [m].
            policy: name of the policy that makes the aiming points.

        Raises:
            ValueError: when it was started before, or the debris is out of bounds; the state stays as it is.
        """
        if self.mission.phase != Phase.WAITING:
            raise ValueError(f"the mission was started before: it is {self.mission.phase.name}")
        point = check_debris_position(debris_position, self._rules)
        # Controllers may use all of their own time limit and must still be able to say that they fell back.
        self._change(
            arm(self.mission, point, policy),
            self.stamp_ns,
            self._control.plan_timeout_s + self._rules.confirm_timeout_s,
        )

    def abort(self, reason: str) -> bool:
        """Stop the mission.

        Returns:
            False when it was over already.
        """
        after = abort(self.mission, reason)
        if after is self.mission:
            return False
        self._change(after, self.stamp_ns, self._rules.confirm_timeout_s)
        return True

    def saw_time(self, stamp_ns: int) -> None:
        """Something was measured at ``stamp_ns``; the launch will not be before. A time that is far back means that the
        clock was set anew: whose stamps can be is decided where they are read.
        """
        if not 0.0 <= seconds_between(stamp_ns, self.stamp_ns) <= self._control.longest_gap_s:
            self.stamp_ns = stamp_ns

    def measured(
        self,
        stamp_ns: int,
        net_position: Sequence[float],
        debris_position: Sequence[float],
        locked: Sequence[bool] = (),
        look: Callable[[], ClosingSituation | None] | None = None,
    ) -> None:
        """Decide on one control tick and beat for it, at once or when the change it caused is confirmed.

        Args:
            stamp_ns: time of the tick [ns].
            net_position: the net's centre of mass [m]; NaN where it could not be measured: nothing triggers, but time
                goes on.
            debris_position: the debris' centre of mass [m]; NaN likewise.
            locked: which closing pairs are locked; empty where nobody knows.
            look: see :func:`tethernet_planner.mission_rules.advance`.
        """
        self.saw_time(stamp_ns)
        if self.confirmed:
            after = advance(
                self.mission,
                self._system,
                stamp_ns,
                net_position,
                debris_position,
                self._rules,
                self._control,
                locked,
                look,
                self._ahead,
            )
            if after is self.mission:
                self._beat(stamp_ns)
                return
            self._held_beat_ns = stamp_ns
            self._change(after, stamp_ns, self._rules.confirm_timeout_s)
        else:
            self._held_beat_ns = stamp_ns

    def echoed(self, mu: int, sequence: int) -> None:
        """Controller ``mu`` says which state it has taken over."""
        if sequence == self.mission.sequence:
            self.lost.discard(mu)
            if mu in self._awaited:
                self._awaited.discard(mu)
                self._confirm_when_all_have()

    def poll(self) -> None:
        """Look at the wall clock; to be called several times a second."""
        if self._awaited and self._clock() >= self._deadline_s:
            self.lost |= self._awaited
            self._awaited = set()
            self._confirm_when_all_have()

    def _change(self, mission: Mission, stamp_ns: int, patience_s: float) -> None:
        self.mission, self.confirmed = mission, False
        self._awaited = set(self._mus - self.lost)
        self._deadline_s = self._clock() + patience_s
        self._publish(mission, stamp_ns, False, "")
        self._confirm_when_all_have()

    def _confirm_when_all_have(self) -> None:
        if self._awaited or self.confirmed:
            return
        self.confirmed = True
        mission = self.mission
        not_confirmed = f"not confirmed by {mu_names(self.lost)}" if self.lost else ""
        self._publish(mission, self.stamp_ns, True, "; ".join(text for text in (mission.reason, not_confirmed) if text))
        if mission.phase == Phase.ARMED:
            delay_ns = round(self._rules.launch_delay_s / NANOSECOND_S)
            self._change(launch(mission, self.stamp_ns + delay_ns), self.stamp_ns, self._rules.confirm_timeout_s)
        elif self._held_beat_ns is not None:
            held, self._held_beat_ns = self._held_beat_ns, None
            self._beat(held)


def mu_names(mus: Iterable[int]) -> str:
    """``MU 3, MU 5``."""
    return ", ".join(f"MU {mu}" for mu in sorted(mus))
