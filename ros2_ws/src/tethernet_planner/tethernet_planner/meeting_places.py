"""Places where a docking group could meet behind the debris, rated by net, clearance and thrust."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tethernet_core.free_rotation import attitude_after
from tethernet_core.mission import Point, as_point
from tethernet_core.settings import MissionParameters
from tethernet_core.system import System
from tethernet_planner.closing_situation import ClosingSituation
from tethernet_planner.debris_section import DebrisPose, longest_axis
from tethernet_planner.docking_groups import is_many

_WAY = np.linspace(0.1, 0.9, 9)
"""Where along its straight way to the meeting place a unit's distance from the debris is looked at."""
_GRID_REACH_M = 11.71
"""The places looked at are given for a net whose nearest unit reaches this far; for others they are in proportion."""
_STILL_RAD = 0.05
"""A debris that turns less than this until the units meet is taken for still."""
_HALFWAY, _HOLD_S = 0.6, 2.0  # [-], [s]


@dataclass(frozen=True)
class Place:
    """A place for a docking group to meet."""

    point: Point
    """[m], frame launch."""
    cost: float
    """Velocity that the docking group must gain and what the place is worth, summed over its units [m/s]."""
    violation: float
    """Net that is missing, and clearance, summed over its units [m]."""


class MeetingPlaces:
    """Rates places where a docking group could meet after a given time."""

    def __init__(self, seen: ClosingSituation, system: System, rules: MissionParameters, duration: float):
        """Args:
        seen: what is known when closing begins.
        system: net, units and debris.
        rules: slack and clearances.
        duration: until the group meets [s].
        """
        self._seen, self._system, self._rules, self._duration = seen, system, rules, duration
        self._center = seen.debris_position + duration * seen.debris_velocity
        self._sideways = sideways_directions(system)
        debris = system.debris
        tumbles = float(np.linalg.norm(seen.debris_rate)) * duration > _STILL_RAD
        self._slack = rules.closing_slack_m + (rules.tumbling_slack_m if tumbles else 0.0)
        times = [duration, _HALFWAY * duration, duration + _HOLD_S] if tumbles else [duration]
        attitudes = [
            attitude_after(seen.debris_attitude, seen.debris_rate, debris.inertia, debris.mass_kg, time)[0]
            for time in times
        ]
        self._axis = attitudes[0] @ longest_axis(debris)
        """Along what the debris is long when the units meet."""
        self._poses = [DebrisPose(debris, attitude) for attitude in attitudes]
        """The debris when the units meet, and, where it turns in the meantime, on their way and while they dock."""
        self._outlines = [[pose.outline(side) for pose in self._poses] for side in self._sideways]

    def best(self, group: Sequence[int]) -> Place:
        """The place for these units (from 1) with the least violation, then the least cost."""
        rules, members = self._rules, np.array(group) - 1
        many = is_many(group, self._system)
        targets = self._grid(members, many)
        absolute = targets + self._center
        distance = self._distance(targets)
        violation = len(group) * np.maximum(rules.closing_clearance_m - distance, 0.0)
        amiss = np.maximum(distance - rules.ring_clearance_m, 0.0) if many else targets[:, 2]  # less is deeper
        cost = rules.place_gain * len(group) * amiss
        for m, left in zip(members, self.net_left(group, targets), strict=True):
            way = absolute - self._seen.mu_positions[m]
            violation += np.maximum(self._slack - left, 0.0) + self._in_the_way(m, way)
            cost += np.linalg.norm(way / self._duration - self._seen.mu_velocities[m], axis=1)
        i = np.lexsort((cost, np.round(violation, 6)))[0]
        return Place(as_point(absolute[i]), float(cost[i]), float(np.round(violation[i], 6)))

    def net_left(self, group: Sequence[int], places: np.ndarray) -> np.ndarray:
        """Length of net that each of N units (from 1) has left at each of T places, in the debris' least favourable
        attitude.

        Args:
            group: the units.
            places: relative to the debris' centre of mass [m], shape (T, 3).

        Returns:
            [m], shape (N, T); negative: so much is missing.
        """
        return np.array(
            [
                self._system.unit_reach_m[mu - 1]
                - np.max([outline.path_length(places) for outline in self._outlines[mu - 1]], axis=0)
                for mu in group
            ]
        )

    def _grid(self, members: np.ndarray, many: bool) -> np.ndarray:
        """Places in the plane of the approach and the docking group's side, relative to the debris' centre of mass [m],
        shape (T, 3).
        """
        if many:
            side, widths, depths = self._axis[:2], np.arange(-2.0, 2.5, 0.5), np.arange(1.5, 9.0, 0.5)
        else:
            side = self._sideways[members].sum(axis=0)
            widths, depths = np.arange(0.0, 9.0), np.arange(0.0, 9.0, 0.5)
        size = float(np.linalg.norm(side))
        side = side / size if size > 0.1 else np.array([1.0, 0.0])
        scale = float(self._system.unit_reach_m.min()) / _GRID_REACH_M
        wide, deep = (scale * grid.ravel() for grid in np.meshgrid(widths, depths, indexing="ij"))
        return np.stack([wide * side[0], wide * side[1], -deep], axis=1)

    def _in_the_way(self, m: int, way: np.ndarray) -> np.ndarray:
        """How deep the straight ways (T, 3) of unit index m dip into the debris' clearance, over some points [m]."""
        start = self._seen.mu_positions[m] - self._center
        passing = start + _WAY[:, None, None] * way
        return np.maximum(self._rules.way_clearance_m - self._distance(passing), 0.0).sum(axis=0)

    def _distance(self, points: np.ndarray) -> np.ndarray:
        """Least distance from the debris' surface [m], over its attitudes; points relative to its centre, (..., 3)."""
        return np.min([pose.distance(points) for pose in self._poses], axis=0)


def sideways_directions(system: System) -> np.ndarray:
    """Horizontal unit vector from the net's middle towards each unit, shape (M, 2): that of its nominal aiming point,
    or of its node where that has none.
    """
    offsets = system.aiming.offsets
    size = np.linalg.norm(offsets, axis=1)[:, None]
    if (size > 1e-6).all():
        return offsets / size
    net = system.net
    flat = (net.nodes[[unit.node for unit in system.units]] - net.nodes[net.center_node])[:, :2]
    chosen = np.where(size > 1e-6, offsets, flat)
    size = np.linalg.norm(chosen, axis=1)[:, None]
    return np.where(size > 1e-6, chosen / np.maximum(size, 1e-6), np.array([1.0, 0.0]))
