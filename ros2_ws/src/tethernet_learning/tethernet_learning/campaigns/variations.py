"""Where a campaign's scenarios come from: a seed and an idea of what is varied.

A seed gives the same scenarios always; for both designs it gives the same debris positions, attitudes and rates, so
that they can be compared place by place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tethernet_core.layout import system_of
from tethernet_core.mission import as_point
from tethernet_core.settings import MissionParameters
from tethernet_learning.campaigns import sphere
from tethernet_learning.campaigns.cases import Case
from tethernet_sim.scenario import FAILURES, Failure, Scenario

STEP_M = 0.1
"""Debris positions are multiples of this [m] (paper, Table I)."""
ANGLE_CLASSES_DEG = (0, 15, 30, 45, 60, 75, 90)
"""Groups of an attitude campaign: angles of the long axis to the approach [deg]."""


def random_positions(mus: int, count: int, seed: int, rules: MissionParameters) -> list[Case]:
    """The debris anywhere within the mission's bounds (paper, Table I), each with noise of its own.

    Args:
        mus: 4 or 8.
        count: how many.
        seed: a longer list begins with the shorter one.
        rules: holds the bounds.
    """
    return [Case(Scenario(system_of(mus), **_place(random, rules)), "random") for random in _generators(seed, count)]


def attitudes(mus: int, direction_count: int, each: int, seed: int, rules: MissionParameters) -> list[Case]:
    """The debris' long axis over the whole sphere, evenly; which end is which makes no difference.

    Args:
        mus: 4 or 8.
        direction_count: how many directions.
        each: so many scenarios for each direction, at random debris positions.
        seed: of positions and noise.
        rules: holds the bounds of positions.
    """
    cases = []
    generators = iter(_generators(seed, direction_count * each))
    for direction in sphere.directions(direction_count, hemisphere=True):
        attitude = sphere.attitude_along(direction)
        group = _angle_class(math.degrees(math.acos(min(1.0, abs(direction[2])))))
        for _ in range(each):
            cases.append(
                Case(Scenario(system_of(mus), debris_attitude=attitude, **_place(next(generators), rules)), group)
            )
    return cases


def tumbles(
    mus: int,
    rates_deg_s: Sequence[float],
    axis_count: int,
    each: int,
    seed: int,
    rules: MissionParameters,
    random_attitude: bool = False,
) -> list[Case]:
    """The debris tumbles about axes over the whole sphere. All rates are flown at the same places.

    Args:
        mus: 4 or 8.
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
        for axis in sphere.directions(axis_count):
            spin = as_point((math.radians(rate) * axis).tolist())
            for _ in range(each):
                random = next(generators)
                varied = _place(random, rules)
                if random_attitude:
                    varied["debris_attitude"] = sphere.random_attitude(random)
                cases.append(Case(Scenario(system_of(mus), debris_rate=spin, **varied), f"{rate:g} deg/s"))
    return cases


def losses(
    mus: int, count: int, seed: int, rules: MissionParameters, latest_s: float, kinds: Sequence[str] = FAILURES
) -> list[Case]:
    """One MU is lost in flight, any of them, at any time.

    Args:
        mus: 4 or 8.
        count: how many.
        seed: of all that is random; a longer list begins with the shorter one.
        rules: holds the bounds of positions.
        latest_s: times of loss are drawn evenly from launch to this [s].
        kinds: what may happen, drawn evenly; of FAILURES.
    """
    cases = []
    for random in _generators(seed, count):
        varied = _place(random, rules)
        time_s, which, kind = random.uniform(0.0, latest_s), random.random(), kinds[int(random.integers(len(kinds)))]
        failure = Failure(mu=1 + int(which * mus), kind=kind, time_s=round(time_s, 3))
        cases.append(Case(Scenario(system_of(mus), failure=failure, **varied), kind))
    return cases


def _generators(seed: int, count: int) -> list[np.random.Generator]:
    return [np.random.default_rng(sequence) for sequence in np.random.SeedSequence(seed).spawn(count)]


def _place(random: np.random.Generator, rules: MissionParameters) -> dict[str, Any]:
    """A debris position within the bounds and a seed of the sensor noise."""
    bound = rules.debris_bound_xy_m
    x, y = random.uniform(-bound, bound, 2)
    z = -random.uniform(rules.debris_near_m, rules.debris_far_m)
    position = as_point(round(round(value / STEP_M) * STEP_M, 6) for value in (x, y, z))
    return {"debris_position": position, "seed": int(random.integers(2**31))}


def _angle_class(angle_deg: float) -> str:
    place = max(1, int(np.searchsorted(ANGLE_CLASSES_DEG, angle_deg)))
    return f"axis {ANGLE_CLASSES_DEG[place - 1]:2d} to {ANGLE_CLASSES_DEG[place]:2d} deg to approach"
