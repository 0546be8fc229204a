"""The mission's phases and the rules that lead from one to the next: used by the planner's node and by the batch
engine.
"""

from __future__ import annotations

import dataclasses
import enum
import math
from dataclasses import dataclass

from .layout import design
from .settings import NANOSECOND_S, ControlParameters, MissionParameters

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

    @property
    def over(self) -> bool:
        """True once nothing more can happen."""
        return self >= Phase.COMPLETE


@dataclass(frozen=True)
class Mission:
    """State of the mission; each change makes a new one with the next sequence number."""

    mu_count: int
    """4 or 8."""
    phase: Phase = Phase.WAITING
    sequence: int = 0
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
    """One per MU [m]; empty where winches close the net."""
    closing_duration_s: float = 0.0
    """Duration of the flight to the closing points [s]."""
    docked_ns: tuple[int, ...] = ()
    """Per MU: docked with both neighbours, thrusters off from this time on [ns]; 0: not yet. Empty until one is."""
    reason: str = ""
    """Why missed or aborted."""

    def docked(self, mu: int, stamp_ns: int) -> bool:
        """True when MU ``mu`` (1..8) has its thrusters off at ``stamp_ns`` because it has docked."""
        return bool(self.docked_ns) and 0 < self.docked_ns[mu - 1] <= stamp_ns

    @property
    def closing(self) -> bool:
        """True from the decision to close on."""
        return self.closing_ns > 0

    def _next(self, phase: Phase, **changes) -> Mission:
        return dataclasses.replace(self, phase=phase, sequence=self.sequence + 1, **changes)


def seconds_between(earlier_ns: int, later_ns: int) -> float:
    """Time from one stamp to another [s]; the one way stamps become seconds, so that every part gets the same bits."""
    return (later_ns - earlier_ns) * NANOSECOND_S


def arm(mission: Mission, debris_position, policy: str) -> Mission:
    """Aiming points are ready."""
    return mission._next(Phase.ARMED, debris_position=_point(debris_position), policy=policy)


def launch(mission: Mission, launch_ns: int) -> Mission:
    """Deployment begins at ``launch_ns``."""
    return mission._next(Phase.DEPLOYING, launch_ns=launch_ns)


def abort(mission: Mission, reason: str) -> Mission:
    """Stop for the given reason; a mission that is over stays as it is."""
    return mission if mission.phase.over else mission._next(Phase.ABORTED, reason=reason)


def closing_points(mu_count: int, debris_position, rules: MissionParameters) -> tuple[Point, ...]:
    """Where the MUs fly to close the mouth: one place behind the debris, seen from the chaser.

    Args:
        mu_count: 4 or 8.
        debris_position: the debris' centre of mass at the trigger [m].
        rules: gives the depth.

    Returns:
        One point [m] per MU, or none where winches close the net.
    """
    if not design(mu_count).closes_by_docking:
        return ()
    x, y, z = _point(debris_position)
    return ((x, y, z - rules.closing_depth_m),) * mu_count


def triggered(net_position, debris_position, rules: MissionParameters) -> bool:
    """The paper's start-of-closing condition.

    Args:
        net_position: the net's centre of mass, knots without MUs [m] (the MUs' centroid where nothing measures the
            net).
        debris_position: the debris' centre of mass [m].
        rules: gives the distance.
    """
    squared = 0.0
    for axis in range(3):
        difference = float(net_position[axis]) - float(debris_position[axis])
        squared += difference * difference
    return squared <= rules.trigger_distance_m * rules.trigger_distance_m


def docked_mus(mu_count: int, locked) -> tuple[bool, ...]:
    """Which MUs have docked with both their neighbours.

    Args:
        mu_count: 4 or 8.
        locked: one for each pair of neighbours, in their order round the mouth (layout.MuDesign.closing_ring).

    Returns:
        One per MU; all False where winches close the net.
    """
    ring = design(mu_count).closing_ring
    docked = [False] * mu_count
    if len(locked) == len(ring):
        for place, mu in enumerate(ring):
            docked[mu - 1] = bool(locked[place]) and bool(locked[place - 1])
    return tuple(docked)


def advance(
    mission: Mission,
    stamp_ns: int,
    net_position,
    debris_position,
    rules: MissionParameters,
    control: ControlParameters,
    locked=(),
) -> Mission:
    """The mission after what was measured at ``stamp_ns``; the same object when nothing changes.

    What is seen at one control tick takes effect at the next: some controllers have answered this one already, others
    have not.

    Args:
        mission: before.
        stamp_ns: time of the measurements [ns].
        net_position: the net's centre of mass [m].
        debris_position: the debris' centre of mass [m].
        rules: the mission's rules.
        control: gives the control period.
        locked: which closing pairs are locked; empty where nobody knows.
    """
    if mission.phase == Phase.DEPLOYING:
        if triggered(net_position, debris_position, rules):
            closing_ns = stamp_ns + control.period_ns
            return mission._next(
                Phase.CLOSING,
                closing_ns=closing_ns,
                end_ns=closing_ns + round(rules.capture_duration_s / NANOSECOND_S),
                closing_points=closing_points(mission.mu_count, debris_position, rules),
                closing_duration_s=rules.closing_duration_s,
            )
        if seconds_between(mission.launch_ns, stamp_ns) >= rules.give_up_s:
            return mission._next(
                Phase.MISSED,
                end_ns=stamp_ns,
                reason=f"the net did not come within {rules.trigger_distance_m:g} m of the debris "
                f"in {rules.give_up_s:g} s",
            )
    elif mission.phase == Phase.CLOSING:
        if stamp_ns >= mission.end_ns:
            return mission._next(Phase.COMPLETE)
        if rules.release_docked:
            known = mission.docked_ns or (0,) * mission.mu_count
            from_now = stamp_ns + control.period_ns
            docked_ns = tuple(
                since or (from_now if docked else 0)
                for since, docked in zip(known, docked_mus(mission.mu_count, locked), strict=True)
            )
            if docked_ns != known:
                return mission._next(Phase.CLOSING, docked_ns=docked_ns)
    return mission


def check_debris_position(position, rules: MissionParameters) -> Point:
    """The position itself, when missions are planned for it.

    Raises:
        ValueError: naming the coordinate and what is allowed.
    """
    point = _point(position)
    bounds = (
        ("x", -rules.debris_bound_xy_m, rules.debris_bound_xy_m),
        ("y", -rules.debris_bound_xy_m, rules.debris_bound_xy_m),
        ("z", -rules.debris_far_m, -rules.debris_near_m),
    )
    for value, (name, low, high) in zip(point, bounds, strict=True):
        if not low <= value <= high:  # also catches NaN
            raise ValueError(
                f"debris {name} = {value:g} m is out of bounds; allowed: {low:g} to {high:g} m (frame launch)"
            )
    return point


def _point(position) -> Point:
    x, y, z = (float(value) for value in position)
    return (x, y, z)
