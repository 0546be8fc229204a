"""Flights with a look at the net when closing begins."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tethernet_planner.inference.net_features import features
from tethernet_sim.fly import Settings, fly_many
from tethernet_sim.scenario import Outcome, Scenario
from tethernet_sim.state import DEBRIS, VELOCITY
from tethernet_sim.world import World


def fly_and_look(
    scenarios: Sequence[Scenario],
    settings: Settings,
    stop_at_trigger: bool,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[list[Outcome], list[np.ndarray | None]]:
    """Fly scenarios and note what a surrogate sees.

    Args:
        scenarios: of one system.
        settings: of the flights.
        stop_at_trigger: fly no further than the start of closing.
        progress: as in :func:`tethernet_sim.fly.fly_many`.

    Returns:
        Outcomes, and for each scenario the features at the start of closing, from the arrays as
        published; None where closing never began.
    """
    seen: list[np.ndarray | None] = [None] * len(scenarios)

    def look(number: int, world: World, index: int) -> None:
        seen[number] = features(
            scenarios[number].system,
            world.knots_as_published(index),
            world.knot_velocities_as_published(index),
            world.mus_as_published(index),
            world.state.mu_vel[index].astype(np.float32),
            world.debris_position(index),
            world.state.bodies[index, DEBRIS, VELOCITY],
        )

    outcomes = fly_many(scenarios, settings, progress=progress, at_trigger=look, stop_at_trigger=stop_at_trigger)
    return outcomes, seen
