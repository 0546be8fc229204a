"""Scenarios of a stream: random places of the debris, each with sensor noise of its own."""

from __future__ import annotations

from tethernet_core.layout import system_of
from tethernet_learning.seeds import Purpose, generators
from tethernet_planner.inference.task import random_debris_position
from tethernet_sim.scenario import Scenario


def random_scenarios(mus: int, purpose: Purpose, seed: int, begin: int, count: int) -> list[Scenario]:
    """Scenarios of a stream with nominal aiming points, each with sensor noise of its own.

    Args:
        mus: 4 or 8.
        purpose: the stream; no two streams share a scenario.
        seed: one seed gives one endless list.
        begin: number of the first scenario in that list.
        count: how many.
    """
    system = system_of(mus)
    return [
        Scenario(system, debris_position=random_debris_position(random), seed=int(random.integers(2**31)))
        for random in generators(purpose, seed, begin, count)
    ]
