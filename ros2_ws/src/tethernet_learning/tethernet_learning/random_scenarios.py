"""Scenarios of a stream: random places of the debris, each with sensor noise of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tethernet_core.mission import as_point
from tethernet_core.system import System
from tethernet_learning import sphere
from tethernet_learning.seeds import Purpose, generators
from tethernet_planner.inference.task import task_of
from tethernet_sim.scenario import Scenario


@dataclass(frozen=True)
class Turned:
    """How the debris of a stream's scenarios lies and turns."""

    random_attitude: bool = False
    """At a random attitude instead of the system's own."""
    tumble_rate_deg_s: float = 0.0
    """About a random axis of the body [deg/s]; 0: as the system's own scenario says."""

    def draw(self, random: np.random.Generator) -> dict[str, Any]:
        """Attitude and angular rate, as far as they are not the system's own."""
        drawn: dict[str, Any] = {}
        if self.random_attitude:
            drawn["debris_attitude"] = sphere.random_attitude(random)
        if self.tumble_rate_deg_s:
            axis = random.normal(size=3)
            rate = math.radians(self.tumble_rate_deg_s) / float(np.linalg.norm(axis))
            drawn["debris_rate"] = as_point((rate * axis).tolist())
        return drawn


STILL = Turned()


def random_scenarios(
    system: System, purpose: Purpose, seed: int, begin: int, count: int, turned: Turned = STILL
) -> list[Scenario]:
    """Scenarios of a stream with nominal aiming points, each with sensor noise of its own.

    Args:
        system: that is flown; systems with the same bounds get the same places.
        purpose: the stream; no two streams share a scenario.
        seed: one seed gives one endless list.
        begin: number of the first scenario in that list.
        count: how many.
        turned: how the debris lies and turns. What it draws comes last, so that places and noise are those of the
            stream whatever it is.
    """
    task = task_of(system)
    scenarios = []
    for random in generators(purpose, seed, begin, count):
        place, noise = task.random_debris_position(random), int(random.integers(2**31))
        scenarios.append(Scenario(system, debris_position=place, seed=noise, **turned.draw(random)))
    return scenarios
