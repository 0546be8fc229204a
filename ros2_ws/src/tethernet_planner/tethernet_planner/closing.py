"""How the 8 MUs close the mouth: where they meet, chosen from where the debris lies and where the MUs
are, and where they meet instead when somebody does not get there.

The net is laid round the debris like a sheet round a parcel. How far behind the debris an MU gets is limited by the
net's own length between the central knot, which the debris' front holds, and the MU's knot: 11.71 m for the MUs in the
middle of a side, 16.97 m for the corners, against a debris of 11.1 m x 3.9 m. Where all can reach one place behind the
debris, all meet there and 8 pairs dock. Where they cannot, because the long axis lies along a row of the net or along
the approach, the mouth is closed in two docking groups of four neighbours, one on either side: 6 pairs dock, as many
as a capture needs.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tethernet_core import rotation
from tethernet_core.layout import CORNER_THREAD_M, KNOT_ROWS, SIDE_THREAD_M, design
from tethernet_core.mission import Point, as_point
from tethernet_core.settings import MissionParameters
from tethernet_planner.debris_section import Outline, axis_after, gap, tumbled
from tethernet_planner.mouth import project_to_reachable

_HALF_NET_M = 0.5 * (KNOT_ROWS - 1)
REACH_M = np.array([math.sqrt(2.0) * _HALF_NET_M + CORNER_THREAD_M] * 4 + [_HALF_NET_M + SIDE_THREAD_M] * 4)
"""Length of net and thread from the central knot to each of the 8 MUs [m]."""

_WAY = np.linspace(0.1, 0.9, 9)
"""Where along its straight way to the meeting place an MU's distance from the debris is looked at."""
_RING = design(8).closing_ring
_OFFSETS = np.array(design(8).nominal_offsets)
_SIDEWAYS = _OFFSETS / np.linalg.norm(_OFFSETS, axis=1)[:, None]


@dataclass(frozen=True)
class ClosingSituation:
    """What is known of MUs and debris at one moment; frame launch."""

    mu_positions: np.ndarray
    """[m], shape (8, 3), MU 1 first."""
    mu_velocities: np.ndarray
    """[m/s], shape (8, 3)."""
    debris_position: np.ndarray
    """Centre of mass [m], shape (3,)."""
    debris_velocity: np.ndarray
    """[m/s], shape (3,)."""
    debris_axis: np.ndarray
    """Unit vector along the long axis, shape (3,)."""
    debris_rate: np.ndarray
    """Angular rate [rad/s], shape (3,)."""
    lost: tuple[bool, ...] = (False,) * 8
    """MUs that cannot be counted on."""


def closing_situation(
    mu_positions: npt.ArrayLike,
    mu_velocities: npt.ArrayLike,
    debris_position: npt.ArrayLike,
    debris_attitude: npt.ArrayLike,
    debris_linear: npt.ArrayLike,
    debris_angular: npt.ArrayLike,
    lost: Iterable[bool] = (False,) * 8,
) -> ClosingSituation:
    """What is known, from odometry as messages carry it; the one way to the numbers, so that all get the same bits.

    Args:
        mu_positions: [m], shape (8, 3), frame launch.
        mu_velocities: [m/s], shape (8, 3), frame launch.
        debris_position: [m], frame launch.
        debris_attitude: unit quaternion x y z w, body to launch.
        debris_linear: velocity in the body frame [m/s], as nav_msgs/Odometry has it.
        debris_angular: angular rate in the body frame [rad/s], likewise.
        lost: MUs that cannot be counted on.
    """
    matrix = rotation.matrix(debris_attitude)
    return ClosingSituation(
        np.asarray(mu_positions, float),
        np.asarray(mu_velocities, float),
        np.asarray(debris_position, float),
        matrix @ np.asarray(debris_linear, float),
        matrix[:, 2].copy(),
        matrix @ np.asarray(debris_angular, float),
        tuple(bool(value) for value in lost),
    )


def foreseen(seen: ClosingSituation, duration: float, rules: MissionParameters) -> ClosingSituation:
    """What will be seen after ``duration`` [s]: MUs and debris fly on as they do, the debris tumbles freely.

    Args:
        seen: what is known now.
        duration: [s].
        rules: size of the debris.
    """
    tumble = seen.debris_axis, seen.debris_rate, duration, rules.target_radius_m, rules.target_length_m
    return replace(
        seen,
        mu_positions=seen.mu_positions + duration * seen.mu_velocities,
        debris_position=seen.debris_position + duration * seen.debris_velocity,
        debris_axis=tumbled(seen.debris_axis, *tumble),
        debris_rate=tumbled(seen.debris_rate, *tumble),
    )


def off_course(mu_positions: npt.ArrayLike, aiming_points: npt.ArrayLike, rules: MissionParameters) -> tuple[bool, ...]:
    """Which MUs are lost, as far as their places at the trigger tell: far beside their aiming points, or far before or
    behind the others. Nobody is lost who is only held back by a net too short for the points it was given.

    Args:
        mu_positions: [m], shape (M, 3).
        aiming_points: [m], shape (M, 3).
        rules: gives the limit.
    """
    miss = np.asarray(mu_positions, float) - project_to_reachable(aiming_points)
    miss[:, 2] -= np.median(miss[:, 2])
    return tuple(bool(far) for far in np.linalg.norm(miss, axis=1) > rules.off_course_m)


@dataclass(frozen=True)
class ClosingPlan:
    """Where and when the MUs meet."""

    points: tuple[Point, ...]
    """One for each MU [m], frame launch; those who shall dock share one, a lost one has its own."""
    duration_s: float
    """Until they meet."""
    pairs: int
    """Pairs of neighbours that will dock when all goes well."""
    feasible: bool
    """False when no place was found that all can reach on a clear way; the points are then the least bad ones."""


def plan(seen: ClosingSituation, rules: MissionParameters) -> ClosingPlan:
    """Choose where the 8 MUs meet: as many docked pairs as possible, then as little thrust as possible.

    Args:
        seen: what is known when closing begins.
        rules: size of the debris, clearances, durations.
    """
    parts = planning(seen, rules)
    while True:
        try:
            next(parts)
        except StopIteration as end:
            found: ClosingPlan = end.value
            return found


def planning(seen: ClosingSituation, rules: MissionParameters) -> Generator[None, None, ClosingPlan]:
    """The work of :func:`plan` in parts, for one who has little time at once: each step rates the places of one
    docking group, at most MOST_PARTS of them; the generator's return value is the plan.
    """
    best: tuple[tuple[bool, float, float], list[list[int]], list[_Place], float, int] | None = None
    durations = _durations(seen, rules)
    meeting_after: dict[float, _Places] = {}
    for groups in _groupings(seen.lost):
        duration = durations[len(groups) > 1]
        if duration not in meeting_after:
            meeting_after[duration] = _Places(seen, rules, duration)
        chosen = []
        for group in groups:
            chosen.append(meeting_after[duration].best(group))
            yield
        pairs = 8 if groups == [list(_RING)] else sum(len(group) - 1 for group in groups)
        violation = sum(place.violation for place in chosen)
        # A plan that cannot be flown is worse than any that can, by how much net or clearance is missing.
        rank = (violation > 0.0, violation if violation > 0.0 else -pairs, sum(place.cost for place in chosen))
        if best is None or rank < best[0]:
            best = rank, groups, chosen, duration, pairs
    if best is None:
        raise ValueError("no way to part the MUs; allowed: at least one, if only into no docking group")
    rank, groups, chosen, duration, pairs = best
    points = [as_point(place) for place in seen.mu_positions]
    for group, place in zip(groups, chosen, strict=True):
        for mu in group:
            points[mu - 1] = place.point
    return ClosingPlan(tuple(points), duration, pairs, not rank[0])


MOST_PARTS = 9
"""Parts of a plan at the most: one docking group of all, and four ways to part them in two; likewise with one MU
lost.
"""


def _durations(seen: ClosingSituation, rules: MissionParameters) -> tuple[float, float]:
    """Time to one meeting place, and to two [s].

    Docking groups meet sooner round a debris that turns: a row of net between two docking groups is caught on its
    rim when it has turned too far.
    """
    spin = seen.debris_rate @ seen.debris_axis
    turning = float(np.linalg.norm(seen.debris_rate - spin * seen.debris_axis))
    apart = rules.group_duration_s
    if turning * apart > _TURN_RAD:
        apart = max(_TURN_RAD / turning, _LEAST_SHARE * apart)
    return rules.closing_duration_s, apart


def docking_groups(closing_points: Sequence[Point]) -> list[list[int]]:
    """The MUs (from 1) that share a closing point, in their order round the mouth; who is alone is in none."""
    shared: dict[Point, list[int]] = {}
    for mu in _RING:
        shared.setdefault(closing_points[mu - 1], []).append(mu)
    return [group for group in shared.values() if len(group) > 1]


def docked_group(group: Sequence[int], locked: Sequence[bool]) -> bool:
    """True when all neighbours within a docking group have docked.

    Args:
        group: MUs, from 1.
        locked: one for each pair of neighbours round the mouth.
    """
    return all(
        locked[place] for place, mu in enumerate(_RING) if mu in group and _RING[(place + 1) % len(_RING)] in group
    )


def regroup(
    closing_points: Sequence[Point], mu_positions: npt.ArrayLike, locked: Sequence[bool], rules: MissionParameters
) -> tuple[Point, ...] | None:
    """New closing points where a docking group has not docked in time: all of it flies to the one who is farthest
    from its middle, because that one cannot get any nearer. Who is too far away is given up.

    Args:
        closing_points: the present ones [m].
        mu_positions: [m], shape (8, 3).
        locked: one for each pair of neighbours round the mouth.
        rules: gives the distance at which an MU is given up.

    Returns:
        One for each MU [m], or None when every docking group has docked.
    """
    points = list(closing_points)
    positions = np.asarray(mu_positions, float)
    for group in docking_groups(closing_points):
        if docked_group(group, locked):
            continue
        members = np.array(group) - 1
        astray = np.linalg.norm(positions[members] - np.median(positions[members], axis=0), axis=1)
        for member in members[astray > rules.regroup_reach_m]:
            points[member] = as_point(positions[member])
        members = members[astray <= rules.regroup_reach_m]
        if len(members):
            away = ((positions[members] - positions[members].mean(axis=0)) ** 2).sum(axis=1)
            for member in members:
                points[member] = as_point(positions[members[np.argmax(away)]])
    return tuple(points) if points != list(closing_points) else None


def _groupings(lost: tuple[bool, ...]) -> list[list[list[int]]]:
    """Ways to part the ring of MUs that can be counted on into one or two docking groups of neighbours."""
    count = len(_RING)
    gone = [place for place, mu in enumerate(_RING) if lost[mu - 1]]
    if not gone:
        half = count // 2
        return [[list(_RING)]] + [
            [[_RING[(cut + i) % count] for i in range(half)], [_RING[(cut + half + i) % count] for i in range(half)]]
            for cut in range(half)
        ]
    runs: list[list[int]] = [[]]
    for i in range(1, count):
        mu = _RING[(gone[0] + i) % count]
        if lost[mu - 1]:
            runs.append([])
        else:
            runs[-1].append(mu)
    runs = [run for run in runs if run]
    if not runs:
        return [[]]
    groupings = [[[mu for run in runs for mu in run]]]
    if len(runs) > 1:
        groupings.append(runs)
    else:
        groupings += [[runs[0][:cut], runs[0][cut:]] for cut in range(2, len(runs[0]) - 1)]
    return groupings


@dataclass(frozen=True)
class _Place:
    point: Point
    """[m], frame launch."""
    cost: float
    """Velocity that the docking group must gain, summed over its MUs [m/s], and what stretching the net far is
    worth.
    """
    violation: float
    """Net that is missing, and clearance, summed over its MUs [m]."""


class _Places:
    """Rates places where a docking group could meet after a given time."""

    def __init__(self, seen: ClosingSituation, rules: MissionParameters, duration: float):
        self._seen, self._rules, self._duration = seen, rules, duration
        self._center = seen.debris_position + duration * seen.debris_velocity
        self._size = rules.target_radius_m, 0.5 * rules.target_length_m
        tumbles = float(np.linalg.norm(seen.debris_rate)) * duration > _STILL_RAD
        self._axes = [
            axis_after(seen.debris_axis, seen.debris_rate, time, rules.target_radius_m, rules.target_length_m)
            for time in ([duration, _HALFWAY * duration, duration + _HOLD_S] if tumbles else [duration])
        ]
        """The long axis when the MUs meet, and, where it turns in the meantime, on their way and while they dock."""
        self._outlines = [[Outline(axis, side, *self._size) for axis in self._axes] for side in _SIDEWAYS]

    def best(self, group: list[int]) -> _Place:
        """The place for these MUs (from 1) with the least violation, then the least cost."""
        rules, members = self._rules, np.array(group) - 1
        targets = self._grid(members)
        absolute = targets + self._center
        short = np.maximum(rules.closing_clearance_m - self._gap(targets), 0.0)
        violation = len(group) * short
        cost = np.zeros(len(targets))
        for m in members:
            way = absolute - self._seen.mu_positions[m]
            paths = [outline.path_length(targets) for outline in self._outlines[m]]
            spare = REACH_M[m] - np.max(paths, axis=0)
            violation += np.maximum(rules.closing_slack_m - spare, 0.0) + self._in_the_way(m, way)
            if len(members) <= _MANY:
                cost += np.maximum(rules.group_slack_m - spare, 0.0) ** 2
            cost += np.linalg.norm(way / self._duration - self._seen.mu_velocities[m], axis=1)
        i = np.lexsort((cost, np.round(violation, 6)))[0]
        return _Place(as_point(absolute[i]), float(cost[i]), float(np.round(violation[i], 6)))

    def _grid(self, members: np.ndarray) -> np.ndarray:
        """Places in the plane of the approach and the docking group's side, relative to the debris' centre [m], (T,
        3).
        """
        middle = _SIDEWAYS[members].sum(axis=0)
        if len(members) <= _MANY:
            side, widths, depths = middle, np.arange(0.0, 9.0), np.arange(0.0, 9.0, 0.5)
        else:
            side, widths, depths = self._axes[0][:2], np.arange(-2.0, 2.5, 0.5), np.arange(1.5, 9.0, 0.5)
        size = float(np.linalg.norm(side))
        side = side / size if size > 0.1 else np.array([1.0, 0.0])
        wide, deep = (grid.ravel() for grid in np.meshgrid(widths, depths, indexing="ij"))
        return np.stack([wide * side[0], wide * side[1], -deep], axis=1)

    def _in_the_way(self, m: int, way: np.ndarray) -> np.ndarray:
        """How deep the straight ways (T, 3) of MU index m dip into the debris' clearance, over some points [m]."""
        start = self._seen.mu_positions[m] - self._center
        passing = start + _WAY[:, None, None] * way
        return np.maximum(self._rules.way_clearance_m - self._gap(passing), 0.0).sum(axis=0)

    def _gap(self, points: np.ndarray) -> np.ndarray:
        """Least distance from the debris' surface [m], over its attitudes; points relative to its centre, (..., 3)."""
        return np.min([gap(points, axis, *self._size) for axis in self._axes], axis=0)


_STILL_RAD = 0.05
"""A debris that turns less than this until the MUs meet is taken for still."""
_TURN_RAD, _LEAST_SHARE = math.radians(38.0), 0.6
"""The long axis may turn so far until two docking groups meet, unless they had less than this share of their time
for it.
"""
_HALFWAY, _HOLD_S = 0.6, 2.0  # [-], [s]
_MANY = 6
"""Docking groups of more MUs than this come from all round the debris and meet behind its middle."""
