"""The ring of units that dock: ways to part it into groups, and where a group meets that has not docked in time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tethernet_core.mission import Point, as_point
from tethernet_core.settings import MissionParameters
from tethernet_core.system import System

_MANY = 0.75
"""Docking groups of more than this share of the ring come from all round the debris and meet behind its middle."""


def is_many(group: Sequence[int], system: System) -> bool:
    """Whether a docking group comes from all round the debris."""
    return len(group) > _MANY * len(system.closing_ring)


def most_parts(system: System) -> int:
    """Parts of a closing plan at the most, each the search for one docking group's place: one group of all, and the
    ways to part it in two, which are most with one unit lost or none.
    """
    with_one_lost = 1 + 2 * max(len(system.closing_ring) - 4, 0)
    return max(with_one_lost, sum(len(groups) for groups in groupings(system, ())))


def pairs_of(groups: Sequence[Sequence[int]], system: System) -> int:
    """Pairs of neighbours that dock when every group does."""
    if len(groups) == 1 and len(groups[0]) == len(system.closing_ring):
        return len(system.closing_ring)
    return sum(max(len(group) - 1, 0) for group in groups)


def groupings(system: System, lost: Sequence[bool]) -> list[list[list[int]]]:
    """Ways to part the ring of units that can be counted on into one or two docking groups of neighbours.

    Args:
        system: gives the ring.
        lost: units that cannot be counted on, unit 1 first; empty: none.

    Returns:
        One or more groupings, each a list of groups, each a list of units from 1.
    """
    ring = system.closing_ring
    count, half = len(ring), len(ring) // 2
    gone = [place for place, mu in enumerate(ring) if lost and lost[mu - 1]]
    if not gone:
        cuts = half if 2 * half == count else count  # halves of an even ring are the same from either end
        in_two = [
            [[ring[(cut + i) % count] for i in range(half)], [ring[(cut + i) % count] for i in range(half, count)]]
            for cut in range(cuts if half > 1 else 0)
        ]
        return [[list(ring)], *in_two]
    runs: list[list[int]] = [[]]
    for i in range(1, count):
        mu = ring[(gone[0] + i) % count]
        if lost[mu - 1]:
            runs.append([])
        else:
            runs[-1].append(mu)
    runs = [run for run in runs if run]
    if not runs:
        return [[]]
    ways = [[[mu for run in runs for mu in run]]]
    if len(runs) > 1:
        ways.append(runs)
    else:
        ways += [[runs[0][:cut], runs[0][cut:]] for cut in range(2, len(runs[0]) - 1)]
    return ways


def docking_groups(closing_points: Sequence[Point], system: System) -> list[list[int]]:
    """The units (from 1) that share a closing point, in their order round the mouth; who is alone is in none."""
    shared: dict[Point, list[int]] = {}
    for mu in system.closing_ring:
        shared.setdefault(closing_points[mu - 1], []).append(mu)
    return [group for group in shared.values() if len(group) > 1]


def docked_group(group: Sequence[int], locked: Sequence[bool], system: System) -> bool:
    """True when all neighbours within a docking group have docked.

    Args:
        group: units, from 1.
        locked: one for each pair of neighbours round the mouth.
        system: gives the ring.
    """
    return all(
        locked[place] for place, (one, other) in enumerate(system.ring_neighbours) if one in group and other in group
    )


def docked_mus(system: System, locked: Sequence[bool], closing_points: Sequence[Point]) -> tuple[bool, ...]:
    """Which units are done: all neighbours who share their closing point have docked. A docking group is released as a
    whole: who let go earlier would be dragged away by the net, and the last would not find it.

    Args:
        system: gives the ring.
        locked: one for each pair of neighbours, in their order round the mouth; empty where nobody knows.
        closing_points: one per unit [m]; empty where units do not dock.

    Returns:
        One per unit.
    """
    done = [False] * system.unit_count
    ring = system.closing_ring
    if closing_points and ring and len(locked) == len(ring):
        for group in docking_groups(closing_points, system):
            if docked_group(group, locked, system):
                for mu in group:
                    done[mu - 1] = True
    return tuple(done)


def regroup(
    closing_points: Sequence[Point],
    mu_positions: np.ndarray,
    locked: Sequence[bool],
    system: System,
    rules: MissionParameters,
) -> tuple[Point, ...] | None:
    """New closing points where a docking group has not docked in time: all of it flies to the one who is farthest
    from its middle, because that one cannot get any nearer. Who is too far away is given up.

    Args:
        closing_points: the present ones [m].
        mu_positions: [m], shape (M, 3).
        locked: one for each pair of neighbours round the mouth.
        system: gives the ring.
        rules: gives the distance at which a unit is given up.

    Returns:
        One for each unit [m], or None when every docking group has docked.
    """
    points = list(closing_points)
    positions = np.asarray(mu_positions, float)
    for group in docking_groups(closing_points, system):
        if docked_group(group, locked, system):
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
