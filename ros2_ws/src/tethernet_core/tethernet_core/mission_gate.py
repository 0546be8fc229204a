"""Which states of the mission to follow: those of one planner, in order, and every abort. No ROS."""

from __future__ import annotations

from collections import OrderedDict
from typing import TypeVar

from tethernet_core.mission import Mission, Phase
from tethernet_core.step_guard import StepGuard

LONGEST_STEP = 100
"""States that may have been missed in between: a mission has some thirty changes in all."""

RECOVER_AFTER = 3
"""States in succession that are off the count but agree: their planner counts anew."""

_REMEMBERED = 16
"""Planners whose counts are remembered: one and, after restarts, a few more."""


Remembered = TypeVar("Remembered")


class MissionGate:
    """Keeps the newest state of the mission that counts.

    Every planner draws an identity when it starts (``mission_id``) and counts its states. A state that is not newer
    than what was heard of the same planner is no news. Another planner's state counts when no mission is flown, or when
    the one that leads it has fallen silent: a restarted planner takes over, a second one beside it does not. An abort
    counts in flight whoever says it and whatever its number: an MU that stops its thrust in vain is the smaller harm.
    The mission that was aborted is over then, whatever its planner says later.
    """

    def __init__(self, mission: Mission):
        """Args:
        mission: before anything is heard.
        """
        self.mission = mission
        self.refused = 0
        """States that were refused: of another planner in flight, or with a sequence that is far off."""
        self._counts: OrderedDict[int, StepGuard] = OrderedDict()
        self._ended: OrderedDict[int, None] = OrderedDict()

    def take(self, mission: Mission, leader_lost: bool = False) -> bool:
        """Judge a state that was heard.

        Args:
            mission: the state.
            leader_lost: whether the planner that leads the present mission has fallen silent.

        Returns:
            True when it is the mission's state now.
        """
        flying = self.mission.phase.under_way
        if flying and mission.phase == Phase.ABORTED:
            self._remember(self._ended, self.mission.mission_id, None)
            self._count(mission.mission_id).take(mission.sequence)
            self.mission = mission
            return True
        other = mission.mission_id != self.mission.mission_id
        if mission.mission_id in self._ended or (flying and other and not leader_lost):
            self.refused += 1
            return False
        count = self._count(mission.mission_id)
        jumps = count.jumps
        good = count.take(mission.sequence).good
        self.refused += count.jumps - jumps
        if good:
            self.mission = mission
        return good

    def is_present(self, mission: Mission) -> bool:
        """True for a repetition of the present state, which may be confirmed now."""
        return (mission.mission_id, mission.sequence) == (self.mission.mission_id, self.mission.sequence)

    def _count(self, mission_id: int) -> StepGuard:
        count = self._counts.get(mission_id) or StepGuard(LONGEST_STEP, RECOVER_AFTER)
        self._remember(self._counts, mission_id, count)
        return count

    @staticmethod
    def _remember(memory: OrderedDict[int, Remembered], mission_id: int, value: Remembered) -> None:
        memory[mission_id] = value
        memory.move_to_end(mission_id)
        if len(memory) > _REMEMBERED:
            memory.popitem(last=False)
