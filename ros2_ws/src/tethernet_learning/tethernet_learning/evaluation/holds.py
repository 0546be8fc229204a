"""What the shipped policies hold: captures at random attitudes of the debris, with the hold test."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from tethernet_core.system import System
from tethernet_learning.campaigns.records import records
from tethernet_learning.evaluation.policy_scores import Evaluated, evaluate
from tethernet_learning.flight_settings import flights_of
from tethernet_learning.random_scenarios import Turned
from tethernet_planner import policies
from tethernet_sim.scenario import Outcome

SCENARIOS = 24
"""For each system."""
SEED = 5
HOLD_S, TOW_N = 60.0, 20.0


def fly(
    systems: Sequence[System], count: int = SCENARIOS, progress: Callable[[Sequence[Outcome]], None] = lambda _: None
) -> list[Evaluated]:
    """Fly the shipped policies at random attitudes, with the hold test.

    Args:
        systems: that one is shipped for.
        count: scenarios for each, the first of a stream that no training uses.
        progress: gets the outcomes that have come.
    """
    flights = flights_of([f"mission.hold_s={HOLD_S}", f"mission.tow_n={TOW_N}"], systems)
    chosen = {system: [policies.RL] for system in systems}
    return evaluate(chosen, count, SEED, flights, progress=progress, turned=Turned(random_attitude=True))


def told(e: Evaluated) -> dict[str, Any]:
    """How it was flown and what came out, for the card, ready for JSON."""
    found = records(e.cases[policies.RL], e.outcomes[policies.RL], e.system)
    how = {"scenarios": len(found.pop("scenarios")), "seed": SEED, "attitude": "random"}
    return {**how, "hold_s": HOLD_S, "tow_n": TOW_N, **found}


def flown(e: Evaluated) -> list[dict[str, Any]]:
    """What each scenario came to, for who flies it again."""
    return [
        {"captured": outcome.captured, "held": outcome.held, "fuel_kg": sum(outcome.fuel_kg)}
        for outcome in e.outcomes[policies.RL]
    ]
