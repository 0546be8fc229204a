"""Where a campaign's scenarios come from: a seed and an idea of what is varied.

A seed gives the same scenarios always; systems with the same bounds get the same debris positions, attitudes and
rates, so that they can be compared place by place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tethernet_core import sphere_directions
from tethernet_core.mission import as_point
from tethernet_core.settings import MissionParameters
from tethernet_core.system import System
from tethernet_learning import sphere
from tethernet_learning.campaigns.body_axis import body_axis
from tethernet_learning.campaigns.cases import Case
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_planner.inference.task import task_of
from tethernet_sim.scenario import FAILURES, Failure, Scenario

ANGLE_CLASSES_DEG = (0, 15, 30, 45, 60, 75, 90)
"""Groups of an attitude campaign: angles of the axis to the approach [deg]."""


def random_positions(system: System, count: int, seed: int, rules: MissionParameters) -> list[Case]:
    """The debris anywhere within the mission's bounds (paper, Table I), each with noise of its own.

    Args:
        system: that is flown.
        count: how many.
        seed: a longer list begins with the shorter one.
        rules: holds the bounds.
    """
    return [Case(Scenario(system, **_place(random, system, rules)), "random") for random in _generators(seed, count)]


def attitudes(system: System, direction_count: int, each: int, seed: int, rules: MissionParameters) -> list[Case]:
    """The debris' long axis (any axis, where it has none) over the whole sphere, evenly; over one half of it where both
    ends look alike.

    Args:
        system: that is flown.
        direction_count: how many directions.
        each: so many scenarios for each direction, at random debris positions.
        seed: of positions and noise.
        rules: holds the bounds of positions.
    """
    cases = []
    axis = body_axis(system)
    generators = iter(_generators(seed, direction_count * each))
    for direction in sphere_directions.directions(direction_count, hemisphere=axis.ends_alike):
        attitude = sphere.attitude_along(direction, axis.direction)
        group = _angle_class(math.degrees(math.acos(min(1.0, abs(direction[2])))))
        for _ in range(each):
            cases.append(
                Case(Scenario(system, debris_attitude=attitude, **_place(next(generators), system, rules)), group)
            )
    return cases


def tumbles(
    system: System,
    rates_deg_s: Sequence[float],
    axis_count: int,
    each: int,
    seed: int,
    rules: MissionParameters,
    random_attitude: bool = False,
) -> list[Case]:
    """The debris tumbles about axes over the whole sphere. All rates are flown at the same places.

    Args:
        system: that is flown.
        rates_deg_s: sizes of the angular rate [deg/s].
        axis_count: so many axes, fixed to the body at launch.
        each: so many scenarios for each rate and axis, at random debris positions.
        seed: of positions, noise and attitudes.
        rules: holds the bounds of positions.
        random_attitude: start at a random attitude instead of the default one.
    """
    cases = []
    for rate in rates_deg_s:
        generators = iter(_generators(seed, axis_count * each))
        for axis in sphere_directions.directions(axis_count):
            spin = as_point((math.radians(rate) * axis).tolist())
            for _ in range(each):
                random = next(generators)
                varied = _place(random, system, rules)
                if random_attitude:
                    varied["debris_attitude"] = sphere.random_attitude(random)
                cases.append(Case(Scenario(system, debris_rate=spin, **varied), f"{rate:g} deg/s"))
    return cases


def losses(
    system: System, count: int, seed: int, rules: MissionParameters, latest_s: float, kinds: Sequence[str] = FAILURES
) -> list[Case]:
    """One unit is lost in flight, any of them, at any time.

    Args:
        system: that is flown.
        count: how many.
        seed: of all that is random; a longer list begins with the shorter one.
        rules: holds the bounds of positions.
        latest_s: times of loss are drawn evenly from launch to this [s].
        kinds: what may happen, drawn evenly; of FAILURES.

    Raises:
        CampaignError: for a system without units.
    """
    if not system.unit_count:
        raise CampaignError(f"system {system.name} has no units that could be lost; allowed: systems with units")
    cases = []
    for random in _generators(seed, count):
        varied = _place(random, system, rules)
        time_s, which, kind = random.uniform(0.0, latest_s), random.random(), kinds[int(random.integers(len(kinds)))]
        failure = Failure(mu=1 + int(which * system.unit_count), kind=kind, time_s=round(time_s, 3))
        cases.append(Case(Scenario(system, failure=failure, **varied), kind))
    return cases


def _generators(seed: int, count: int) -> list[np.random.Generator]:
    return [np.random.default_rng(sequence) for sequence in np.random.SeedSequence(seed).spawn(count)]


def _place(random: np.random.Generator, system: System, rules: MissionParameters) -> dict[str, Any]:
    """A debris position within the bounds and a seed of the sensor noise."""
    bound = rules.debris_bound_xy_m
    x, y = random.uniform(-bound, bound, 2)
    z = -random.uniform(rules.debris_near_m, rules.debris_far_m)
    position = as_point(float(value) for value in task_of(system).on_grid((x, y, z)))
    return {"debris_position": position, "seed": int(random.integers(2**31))}


def _angle_class(angle_deg: float) -> str:
    place = max(1, int(np.searchsorted(ANGLE_CLASSES_DEG, angle_deg)))
    return f"axis {ANGLE_CLASSES_DEG[place - 1]:2d} to {ANGLE_CLASSES_DEG[place]:2d} deg to approach"
