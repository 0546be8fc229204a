"""Fly cases so that every one comes to an outcome."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping, Sequence

from tethernet_core.system import System
from tethernet_learning import workers
from tethernet_learning.campaigns.cases import Case
from tethernet_sim.fly import CHUNK, Settings, fly_many
from tethernet_sim.scenario import Outcome, Scenario


def fly_chunks(
    cases: Sequence[Case], settings: Mapping[System, Settings], chunk: int = CHUNK, cluster: str | None = None
) -> Iterator[list[Outcome]]:
    """Fly cases in chunks, each on all cores of this machine or on one of a cluster.

    Args:
        cases: what to fly.
        settings: parameters of the flights, by system.
        chunk: so many cases at a time.
        cluster: see :func:`tethernet_learning.workers.run`.

    Yields:
        The outcomes of the next cases, in their order.

    Raises:
        ClusterError: when the cluster cannot be used.
    """
    chunks = [cases[begin : begin + chunk] for begin in range(0, len(cases), chunk)]
    yield from workers.run(functools.partial(fly_cases, settings=settings), chunks, cluster)


def fly_cases(cases: Sequence[Case], settings: Mapping[System, Settings]) -> list[Outcome]:
    """Fly cases together; whatever cannot be flown becomes an outcome in error.

    Args:
        cases: what to fly.
        settings: parameters of the flights, by system.

    Returns:
        One outcome for each case, in their order.
    """
    flyable = [case.scenario for case in cases if not case.error]
    try:
        flown = _fly(flyable, settings)
    except Exception:  # one of them spoils the batch: alone it can be told which
        flown = [_fly_alone(scenario, settings) for scenario in flyable]
    outcomes = iter(flown)
    return [failed(case.scenario, case.error) if case.error else next(outcomes) for case in cases]


def _fly(scenarios: Sequence[Scenario], settings: Mapping[System, Settings]) -> list[Outcome]:
    """All of one system together."""
    numbers: dict[System, list[int]] = {}
    for number, scenario in enumerate(scenarios):
        numbers.setdefault(scenario.system, []).append(number)
    flown: dict[int, Outcome] = {}
    for system, chosen in numbers.items():
        flown.update(zip(chosen, fly_many([scenarios[i] for i in chosen], settings[system]), strict=True))
    return [flown[number] for number in range(len(scenarios))]


def failed(scenario: Scenario, error: str) -> Outcome:
    """The outcome of a scenario of which nothing is known but that it failed.

    Args:
        scenario: what was to be flown.
        error: why it failed.
    """
    nothing = (math.nan,) * scenario.mus
    return Outcome(
        captured=False,
        verdict=f"error: {error}",
        cqi=math.nan,
        cqi_all=math.nan,
        locked_pairs=0,
        trigger_time_s=None,
        end_time_s=math.nan,
        fuel_kg=nothing,
        fuel_at_trigger_kg=nothing,
        mouth_area_m2=None,
        net_debris_distance_m=math.nan,
        max_tracking_error_m=math.nan,
        seed=scenario.seed,
        mus=scenario.mus,
        system=scenario.system.name,
        error=error,
    )


def _fly_alone(scenario: Scenario, settings: Mapping[System, Settings]) -> Outcome:
    try:
        return fly_many([scenario], settings[scenario.system])[0]
    except Exception as error:
        return failed(scenario, f"{type(error).__name__}: {error}")
