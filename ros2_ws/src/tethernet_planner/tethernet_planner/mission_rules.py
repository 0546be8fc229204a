"""The rules that lead from one phase of a mission to the next: used by the planner's node and by the batch engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tethernet_core.mission import Mission, Phase, Point, as_point, seconds_between
from tethernet_core.settings import NANOSECOND_S, ControlParameters, MissionParameters
from tethernet_core.system import System
from tethernet_planner import closing
from tethernet_planner.closing_situation import ClosingSituation
from tethernet_planner.docking_groups import docked_mus, regroup
from tethernet_planner.plan_ahead import PlanAhead


def triggered(net_position: Sequence[float], debris_position: Sequence[float], rules: MissionParameters) -> bool:
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


def advance(
    mission: Mission,
    system: System,
    stamp_ns: int,
    net_position: Sequence[float],
    debris_position: Sequence[float],
    rules: MissionParameters,
    control: ControlParameters,
    locked: Sequence[bool] = (),
    look: Callable[[], ClosingSituation | None] | None = None,
    ahead: PlanAhead | None = None,
) -> Mission:
    """The mission after what was measured at ``stamp_ns``; the same object when nothing changes.

    What is seen at one control tick takes effect at the next: some controllers have answered this one already, others
    have not.

    Args:
        mission: before.
        system: how the net is closed, and what the closing plan must know of it.
        stamp_ns: time of the measurements [ns].
        net_position: the net's centre of mass [m].
        debris_position: the debris' centre of mass [m].
        rules: the mission's rules.
        control: gives the control period.
        locked: which closing pairs are locked; empty where nobody knows.
        look: tells where the units are and how the debris lies, None where that is not known; asked only when it
            matters.
        ahead: makes the closing plan before the trigger; without it the whole plan is made at the trigger.
    """
    if mission.phase == Phase.DEPLOYING:
        if triggered(net_position, debris_position, rules):
            closing_ns = stamp_ns + control.period_ns
            points, duration_s = _closing_plan(system, stamp_ns, debris_position, rules, look, ahead)
            return mission.next(
                Phase.CLOSING,
                closing_ns=closing_ns,
                end_ns=closing_ns + round(rules.capture_duration_s / NANOSECOND_S),
                closing_points=points,
                points_ns=closing_ns,
                closing_duration_s=duration_s,
            )
        if seconds_between(mission.launch_ns, stamp_ns) >= rules.give_up_s:
            return mission.next(
                Phase.MISSED,
                end_ns=stamp_ns,
                reason=f"the net did not come within {rules.trigger_distance_m:g} m of the debris "
                f"in {rules.give_up_s:g} s",
            )
        if ahead is not None and look is not None and _plans(system, rules):
            ahead.watch(stamp_ns, net_position, debris_position, look)
    elif mission.phase == Phase.CLOSING:
        if stamp_ns >= mission.end_ns:
            return _judged(mission, stamp_ns, control)
        if rules.release_docked:
            known = mission.docked_ns or (0,) * mission.mu_count
            from_now = stamp_ns + control.period_ns
            docked_ns = tuple(
                since or (from_now if docked else 0)
                for since, docked in zip(known, docked_mus(system, locked, mission.closing_points), strict=True)
            )
            if docked_ns != known:
                return mission.next(Phase.CLOSING, docked_ns=docked_ns)
        return _regrouped(mission, system, stamp_ns, rules, control, locked, look)
    elif mission.phase == Phase.HOLDING and stamp_ns >= mission.hold_end_ns:
        return mission.next(Phase.COMPLETE)
    return mission


def _judged(mission: Mission, stamp_ns: int, control: ControlParameters) -> Mission:
    """The mission at its verdict: complete, or holding where a hold test is asked for."""
    if mission.hold_s == 0.0:
        return mission.next(Phase.COMPLETE)
    hold_ns = stamp_ns + control.period_ns
    return mission.next(Phase.HOLDING, hold_ns=hold_ns, hold_end_ns=hold_ns + round(mission.hold_s / NANOSECOND_S))


def _plans(system: System, rules: MissionParameters) -> bool:
    """True where the place to meet is chosen by a plan."""
    return system.closing.kind == "docking" and rules.closing_plan == "planned"


def _closing_plan(
    system: System,
    stamp_ns: int,
    debris_position: Sequence[float],
    rules: MissionParameters,
    look: Callable[[], ClosingSituation | None] | None,
    ahead: PlanAhead | None,
) -> tuple[tuple[Point, ...], float]:
    """Closing points [m] and the time to get there [s]; no points where units do not dock, and no time either where
    nothing closes the net: the units fly on.
    """
    if system.closing.kind != "docking":
        return (), rules.closing_duration_s if system.closing.kind == "winch" else 0.0
    if _plans(system, rules):
        plan = ahead.ready(stamp_ns) if ahead is not None else None
        seen = look() if plan is None and look is not None else None
        if seen is not None:
            plan = closing.plan(seen, system, rules)
        if plan is not None:
            return plan.points, plan.duration_s
    x, y, z = as_point(debris_position)
    return ((x, y, z - rules.closing_depth_m),) * system.unit_count, rules.closing_duration_s


def _regrouped(
    mission: Mission,
    system: System,
    stamp_ns: int,
    rules: MissionParameters,
    control: ControlParameters,
    locked: Sequence[bool],
    look: Callable[[], ClosingSituation | None] | None,
) -> Mission:
    """The mission with new closing points where a docking group has not docked in time, else the same object."""
    planned_ns = mission.closing_ns + round(mission.closing_duration_s / NANOSECOND_S)
    period_ns = round(rules.regroup_period_s / NANOSECOND_S)
    due = period_ns > 0 and stamp_ns >= planned_ns and stamp_ns - mission.points_ns >= period_ns
    if not due or look is None or not mission.closing_points or len(locked) != len(system.closing_ring):
        return mission
    seen = look()
    points = None if seen is None else regroup(mission.closing_points, seen.mu_positions, locked, system, rules)
    if points is None:
        return mission
    return mission.next(Phase.CLOSING, closing_points=points, points_ns=stamp_ns + control.period_ns)


def check_debris_position(position: Sequence[float], rules: MissionParameters) -> Point:
    """The position itself, when missions are planned for it.

    Raises:
        ValueError: naming the coordinate and what is allowed.
    """
    point = as_point(position)
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
