"""Episodes of one step: offsets in, rewards out; what both environments and the optimiser stand on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tethernet_learning.flown import Flown
from tethernet_learning.policies.capture_sources import Source
from tethernet_learning.policies.reward import Reward
from tethernet_sim.scenario import Scenario


@dataclass(frozen=True)
class Results:
    """E flown episodes; all arrays have shape (E,)."""

    flown: Flown
    terms: dict[str, np.ndarray]
    """The reward's terms by name."""
    rewards: np.ndarray


def fly(source: Source, reward: Reward, scenarios: Sequence[Scenario], offsets: Sequence[np.ndarray]) -> Results:
    """Fly episodes.

    Args:
        source: flies them.
        reward: judges them.
        scenarios: of the reward's system.
        offsets: of the aiming points [m], one array of shape (M, 2) for each scenario.
    """
    aimed = [
        dataclasses.replace(scenario, aiming_offsets=tuple(map(tuple, np.asarray(chosen, float).tolist())))
        for scenario, chosen in zip(scenarios, offsets, strict=True)
    ]
    flown = source.fly(aimed)
    terms = reward.terms(flown)
    return Results(flown, terms, np.sum(list(terms.values()), axis=0))
