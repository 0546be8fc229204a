"""Scenarios of a stream: random places of the debris, each with sensor noise of its own."""

from __future__ import annotations

from tethernet_core.system import System
from tethernet_learning.seeds import Purpose, generators
from tethernet_planner.inference.task import task_of
from tethernet_sim.scenario import Scenario


def random_scenarios(system: System, purpose: Purpose, seed: int, begin: int, count: int) -> list[Scenario]:
    """Scenarios of a stream with nominal aiming points, each with sensor noise of its own.

    Args:
        system: that is flown; systems with the same bounds get the same places.
        purpose: the stream; no two streams share a scenario.
        seed: one seed gives one endless list.
        begin: number of the first scenario in that list.
        count: how many.
    """
    task = task_of(system)
    return [
        Scenario(system, debris_position=task.random_debris_position(random), seed=int(random.integers(2**31)))
        for random in generators(purpose, seed, begin, count)
    ]
