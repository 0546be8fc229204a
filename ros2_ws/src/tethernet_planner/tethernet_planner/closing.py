"""How units that dock close the mouth: where they meet, chosen from where the debris lies and where the units are.

The net is laid round the debris like a sheet round a parcel. How far behind the debris a unit gets is limited by the
net's own length between the central node, which the debris' front holds, and the unit's node. Where all can reach one
place behind the debris, all meet there and every pair of the ring docks. Where they cannot, because the debris is long
along a row of the net or along the approach, the mouth is closed in two docking groups of neighbours, one on either
side: two pairs fewer.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from tethernet_core.mission import Point, as_point
from tethernet_core.settings import MissionParameters
from tethernet_core.system import System
from tethernet_planner.closing_situation import ClosingSituation
from tethernet_planner.debris_section import longest_axis
from tethernet_planner.docking_groups import groupings, pairs_of
from tethernet_planner.meeting_places import MeetingPlaces, Place

_TURN_RAD, _LEAST_SHARE = math.radians(38.0), 0.55
"""The long axis may turn so far until two docking groups meet, unless they had less than this share of their time
for it.
"""


@dataclass(frozen=True)
class ClosingPlan:
    """Where and when the units meet."""

    points: tuple[Point, ...]
    """One for each unit [m], frame launch; those who shall dock share one, a lost one has its own."""
    duration_s: float
    """Until they meet."""
    pairs: int
    """Pairs of neighbours that will dock when all goes well."""
    feasible: bool
    """False when no place was found that all can reach on a clear way; the points are then the least bad ones."""


def plan(seen: ClosingSituation, system: System, rules: MissionParameters) -> ClosingPlan:
    """Choose where the units meet: as many docked pairs as possible, then as little thrust as possible.

    Args:
        seen: what is known when closing begins.
        system: net, units that dock, debris.
        rules: clearances, durations.
    """
    parts = planning(seen, system, rules)
    while True:
        try:
            next(parts)
        except StopIteration as end:
            found: ClosingPlan = end.value
            return found


def planning(seen: ClosingSituation, system: System, rules: MissionParameters) -> Generator[None, None, ClosingPlan]:
    """The work of :func:`plan` in parts, for one who has little time at once: each step rates the places of one
    docking group, at most :func:`.docking_groups.most_parts` of them; the generator's return value is the plan.
    """
    candidates: list[tuple[tuple[bool, float, float], list[list[int]], list[Place], float, int]] = []
    durations = _durations(seen, system, rules)
    meeting_after: dict[float, MeetingPlaces] = {}
    for groups in groupings(system, seen.lost):
        duration = durations[len(groups) > 1]
        if duration not in meeting_after:
            meeting_after[duration] = MeetingPlaces(seen, system, rules, duration)
        chosen = []
        for group in groups:
            chosen.append(meeting_after[duration].best(group))
            yield
        pairs = pairs_of(groups, system)
        violation = sum(place.violation for place in chosen)
        # A plan that cannot be flown is worse than any that can, by how much net or clearance is missing.
        rank = (violation > 0.0, violation if violation > 0.0 else -pairs, sum(place.cost for place in chosen))
        candidates.append((rank, groups, chosen, duration, pairs))
    rank, groups, chosen, duration, pairs = min(candidates, key=lambda candidate: candidate[0])
    points = [as_point(place) for place in seen.mu_positions]
    for group, place in zip(groups, chosen, strict=True):
        for mu in group:
            points[mu - 1] = place.point
    return ClosingPlan(tuple(points), duration, pairs, not rank[0])


def _durations(seen: ClosingSituation, system: System, rules: MissionParameters) -> tuple[float, float]:
    """Time to one meeting place, and to two [s].

    Docking groups meet sooner round a debris that turns: a row of net between two docking groups is caught on its
    rim when it has turned too far.
    """
    axis = seen.debris_attitude @ longest_axis(system.debris)
    spin = seen.debris_rate @ axis
    turning = float(np.linalg.norm(seen.debris_rate - spin * axis))
    apart = rules.group_duration_s
    if turning * apart > _TURN_RAD:
        apart = max(_TURN_RAD / turning, _LEAST_SHARE * apart)
    return rules.closing_duration_s, apart
