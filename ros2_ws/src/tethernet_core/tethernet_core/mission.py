"""The mission's phases and its state, as all nodes share them."""

from __future__ import annotations

import dataclasses
import enum
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from tethernet_core.settings import NANOSECOND_S

Point = tuple[float, float, float]


class Phase(enum.IntEnum):
    """Phases; the numbers are those of tethernet_msgs/MissionState."""

    WAITING = 0
    ARMED = 1
    DEPLOYING = 2
    CLOSING = 3
    COMPLETE = 4
    MISSED = 5
    ABORTED = 6
    HOLDING = 7
    """After CLOSING, where a hold test was asked for; its number is the newest, so that older bags keep theirs."""

    @property
    def over(self) -> bool:
        """True once nothing more can happen."""
        return self in (Phase.COMPLETE, Phase.MISSED, Phase.ABORTED)

    @property
    def under_way(self) -> bool:
        """True from the launch until nothing more can happen."""
        return self in (Phase.DEPLOYING, Phase.CLOSING, Phase.HOLDING)


class Mode(enum.IntEnum):
    """What the controller does; the numbers are those of tethernet_msgs/MuStatus."""

    IDLE = 0
    DEPLOYING = 1
    CLOSING = 2
    OFF = 3
    NO_ODOMETRY = 4
    NO_PLANNER = 5
    EMPTY = 6

    @property
    def flying(self) -> bool:
        """True while the MU is under way: it thrusts, or would."""
        return self in (Mode.DEPLOYING, Mode.CLOSING, Mode.NO_ODOMETRY, Mode.NO_PLANNER)


@dataclass(frozen=True)
class Mission:
    """State of the mission; each change makes a new one with the next sequence number."""

    mu_count: int
    """Number of units, 0 for a net without any."""
    phase: Phase = Phase.WAITING
    sequence: int = 0
    mission_id: int = 0
    """Which planner leads it: drawn anew by each planner when it starts, 64 bits."""
    policy: str = ""
    """Name of the policy that made the aiming points."""
    launch_ns: int = 0
    """Launch time on the odometry's clock [ns]; valid from DEPLOYING on."""
    closing_ns: int = 0
    """Start of closing [ns]; valid from CLOSING on."""
    end_ns: int = 0
    """When the capture is judged [ns]; valid from CLOSING on."""
    debris_position: Point = (math.nan, math.nan, math.nan)
    """Debris' centre of mass at launch [m]."""
    closing_points: tuple[Point, ...] = ()
    """One per unit [m]; those who shall dock share one; empty where units do not dock."""
    points_ns: int = 0
    """From when on the closing points hold [ns]: the ones before hold until then."""
    closing_duration_s: float = 0.0
    """Duration of the flight to the closing points [s]; 0 where nothing closes the net."""
    docked_ns: tuple[int, ...] = ()
    """Per MU: its whole docking group has docked, thrusters off from this time on [ns]; 0: not yet. Empty until one
    is.
    """
    hold_s: float = 0.0
    """How long the hold test takes that follows the verdict [s]; 0: the mission ends with the verdict."""
    tow_n: float = 0.0
    """Tension of the main tether that the chaser tows with in the hold test [N]; 0: it coasts."""
    hold_ns: int = 0
    """Start of the hold test, after the verdict [ns]; valid from HOLDING on."""
    hold_end_ns: int = 0
    """Its end [ns]; likewise."""
    reason: str = ""
    """Why missed or aborted."""

    @property
    def judged(self) -> bool:
        """True once the capture has been judged: the mission is complete or missed, or its hold is tested."""
        return self.phase in (Phase.HOLDING, Phase.COMPLETE, Phase.MISSED)

    def docked(self, mu: int, stamp_ns: int) -> bool:
        """True when unit ``mu`` (from 1) has its thrusters off at ``stamp_ns`` because it has docked."""
        return bool(self.docked_ns) and 0 < self.docked_ns[mu - 1] <= stamp_ns

    @property
    def closing(self) -> bool:
        """True from the decision to close on."""
        return self.closing_ns > 0

    @property
    def units_fly_on(self) -> bool:
        """True where closing has begun but nothing closes the net: units go on to their aiming points and beyond."""
        return self.closing and not self.closing_points and self.closing_duration_s == 0.0

    def next(self, phase: Phase, **changes: Any) -> Mission:
        return dataclasses.replace(self, phase=phase, sequence=self.sequence + 1, **changes)


def seconds_between(earlier_ns: int, later_ns: int) -> float:
    """Time from one stamp to another [s]; the one way stamps become seconds, so that every part gets the same bits."""
    return (later_ns - earlier_ns) * NANOSECOND_S


def arm(mission: Mission, debris_position: Iterable[float], policy: str) -> Mission:
    """Aiming points are ready."""
    return mission.next(Phase.ARMED, debris_position=as_point(debris_position), policy=policy)


def launch(mission: Mission, launch_ns: int) -> Mission:
    """Deployment begins at ``launch_ns``."""
    return mission.next(Phase.DEPLOYING, launch_ns=launch_ns)


def abort(mission: Mission, reason: str) -> Mission:
    """Stop for the given reason; a mission that is over stays as it is."""
    return mission if mission.phase.over else mission.next(Phase.ABORTED, reason=reason)


def as_point(position: Iterable[float]) -> Point:
    x, y, z = (float(value) for value in position)
    return (x, y, z)
