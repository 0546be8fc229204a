"""Policies on unseen scenarios, simulated in full to the end of capture: the paper's evaluation."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tethernet_core.system import System
from tethernet_learning import assumed_numbers
from tethernet_learning.campaigns.cases import Case, aim, as_flown
from tethernet_learning.campaigns.chunks import fly_chunks
from tethernet_learning.campaigns.comparison import Comparison, compare
from tethernet_learning.campaigns.records import records
from tethernet_learning.campaigns.statistics import Estimate
from tethernet_learning.flight_settings import Flight, Flights, settings_by_system
from tethernet_learning.paper_figures import PAPER
from tethernet_learning.random_scenarios import STILL, Turned, random_scenarios
from tethernet_learning.seeds import Purpose
from tethernet_planner import policies
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.policy_file import AimingPolicy
from tethernet_sim.fly import CHUNK, Settings
from tethernet_sim.scenario import Outcome

GROUP = "evaluation"


@dataclass(frozen=True)
class Evaluated:
    """One system: all policies on the same scenarios."""

    system: System
    """By which captures were judged too."""
    cases: Mapping[str, Sequence[Case]]
    """By policy, nominal first."""
    outcomes: Mapping[str, Sequence[Outcome]]
    """Likewise."""

    def compared(self) -> dict[str, Comparison]:
        """Each policy but the nominal one against that."""
        nominal = self.outcomes[policies.NOMINAL]
        return {name: compare(nominal, flown) for name, flown in self.outcomes.items() if name != policies.NOMINAL}


def contenders(words: Sequence[str], systems: Sequence[System]) -> dict[System, list[str]]:
    """What flies which system: the nominal points, and every policy that was made for it.

    Args:
        words: policies as users name them; a file flies the system that it was made for.
        systems: to be flown.

    Raises:
        PolicyError: when one cannot be loaded or flies none of the systems.
        ModelFileError: when a file is no policy.
    """
    chosen = {system: [policies.NOMINAL] for system in systems}
    for word in words:
        fitting = list(systems)
        if shipped_models.means_file(word) and Path(word).is_file():
            made_for = AimingPolicy.load(Path(word)).made_for
            fitting = [system for system in systems if system.digest == made_for.digest]
            if not fitting:
                flown = ", ".join(f"{system.name} ({system.digest[:12]})" for system in systems)
                raise policies.PolicyError(
                    f"policy {word} was made for system {made_for.system} (digest {made_for.digest[:12]}), and none of "
                    f"those to be flown is it: {flown}; give --system {made_for.system} as it was described then"
                )
        for system in fitting:
            policies.check(word, system)
            if word not in chosen[system]:
                chosen[system].append(word)
    return chosen


def evaluate(
    chosen: Mapping[System, Sequence[str]],
    count: int,
    seed: int,
    flights: Flights,
    chunk: int = CHUNK,
    cluster: str | None = None,
    progress: Callable[[Sequence[Outcome]], None] = lambda _: None,
    turned: Turned = STILL,
    assumed: str = assumed_numbers.AS_DESCRIBED,
) -> list[Evaluated]:
    """Fly every policy on the scenarios of the stream that is kept for this.

    Args:
        chosen: policies by system, see :func:`contenders`.
        count: scenarios for each system; systems with the same bounds get the same places.
        seed: of the scenarios.
        flights: how each system is flown; it is aimed for as it is described.
        chunk: so many missions at a time.
        cluster: see :func:`tethernet_learning.workers.run`.
        progress: gets the outcomes that have come.
        turned: how the debris lies and turns.
        assumed: one of :data:`.assumed_numbers.CHOICES`; drawn numbers are the same for all policies.
    """
    settings = settings_by_system(flights)
    aimed: dict[System, dict[str, list[Case]]] = {}
    for system, names in chosen.items():
        aimed[system] = {}
        for name in names:
            cases = _cases(system, name, count, seed, turned)
            if assumed == assumed_numbers.RANDOM:
                cases, drawn = _drawn(cases, flights[system])
                settings |= drawn
            else:
                cases = as_flown(cases, flights)
            aimed[system][name] = cases
    all_cases = [case for by_policy in aimed.values() for cases in by_policy.values() for case in cases]
    flown: list[Outcome] = []
    for outcomes in fly_chunks(all_cases, settings, chunk, cluster):
        flown += outcomes
        progress(outcomes)
    rest = iter(flown)
    return [
        Evaluated(
            flights[system].system, by_policy, {name: [next(rest) for _ in cases] for name, cases in by_policy.items()}
        )
        for system, by_policy in aimed.items()
    ]


def _drawn(cases: Sequence[Case], flight: Flight) -> tuple[list[Case], dict[System, Settings]]:
    """Cases with the assumed numbers drawn, and the parameters of their flights by system."""
    flown, settings = list(cases), {}
    for numbers, seed in assumed_numbers.groups([case.scenario for case in cases]):
        with_draw, _ = assumed_numbers.drawn(flight, seed)
        settings[with_draw.system] = with_draw.settings
        for number in numbers:
            scenario = dataclasses.replace(cases[number].scenario, system=with_draw.system)
            flown[number] = dataclasses.replace(cases[number], scenario=scenario)
    return flown, settings


def _cases(system: System, policy: str, count: int, seed: int, turned: Turned) -> list[Case]:
    scenarios = random_scenarios(system, Purpose.POLICY_EVALUATION, seed, 0, count, turned)
    return aim([Case(scenario, GROUP) for scenario in scenarios], policy)


def as_json(evaluated: Sequence[Evaluated]) -> dict[str, Any]:
    """Statistics, comparisons, the paper's figures and every record, by system and policy."""
    return {e.system.name: _system(e) for e in evaluated}


def _system(e: Evaluated) -> dict[str, Any]:
    by_policy = {}
    for name, cases in e.cases.items():
        by_policy[name] = {"model": policies.fingerprint(name, e.system), **records(cases, e.outcomes[name], e.system)}
    for name, comparison in e.compared().items():
        facts = {field.name: _estimate(getattr(comparison, field.name)) for field in dataclasses.fields(comparison)}
        by_policy[name]["against_nominal"] = facts
    paper = PAPER.get(e.system.name)
    return {
        "system_digest": e.system.digest,
        "paper": None if paper is None else dataclasses.asdict(paper),
        "policies": by_policy,
    }


def _estimate(value: Any) -> Any:
    if isinstance(value, Estimate):
        return {"mean": value.value, "low_95": value.low, "high_95": value.high}
    return list(value) if isinstance(value, tuple) else value
