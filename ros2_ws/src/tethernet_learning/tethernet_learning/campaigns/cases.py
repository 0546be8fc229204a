"""What a campaign flies: scenarios, each in a group, aimed by a policy."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tethernet_core.aiming import FALLBACK, nominal_aiming_points
from tethernet_learning.campaigns.columns import SYSTEM, Row, columns, flatten
from tethernet_learning.flight_settings import Flights
from tethernet_planner import policies
from tethernet_sim.scenario import Outcome, Scenario


@dataclass(frozen=True)
class Case:
    """One scenario of a campaign."""

    scenario: Scenario
    group: str
    """What it has in common with others; tables count by it."""
    policy: str = policies.NOMINAL
    """Who made its aiming points."""
    error: str = ""
    """Why it cannot be flown, if so."""


LABELS = {"index": int, "group": str, "policy": str}
"""Columns of an outcomes file besides those of scenario and outcome."""


def outcome_columns(units: int) -> dict[str, type]:
    """All columns of an outcomes file. What scenario and outcome both tell (system, seed) is there once.

    Args:
        units: of the system that has most.
    """
    return {**LABELS, **columns(Scenario, units), **columns(Outcome, units)}


def most_units(cases: Iterable[Case]) -> int:
    """Units of the system that has most."""
    return max((case.scenario.mus for case in cases), default=0)


def row(index: int, case: Case, outcome: Outcome, units: int) -> Row:
    """A line of an outcomes file with columns for so many units."""
    # What scenario and outcome both tell is the scenario's.
    labels: Row = {
        "index": index, "group": case.group, "policy": case.policy, SYSTEM: case.scenario.system.name,
    }  # fmt: skip
    cells = {**flatten(case.scenario, units), **flatten(outcome, units), **labels}
    return {name: cells[name] for name in outcome_columns(units)}


def as_flown(cases: Iterable[Case], flights: Flights) -> list[Case]:
    """The same cases with the systems that are flown in the place of those as they are described."""
    return [
        dataclasses.replace(
            case, scenario=dataclasses.replace(case.scenario, system=flights[case.scenario.system].system)
        )
        for case in cases
    ]


def aim(cases: Sequence[Case], policy: str | None) -> list[Case]:
    """Let a policy aim every case that has no aiming points of its own; one that it fails at becomes an error.

    Raises:
        PolicyError: when the policy is unknown, cannot be loaded, or was made for another system than one of the cases.
    """
    for system in dict.fromkeys(case.scenario.system for case in cases):
        policies.check(policies.chosen(policy, system), system)
    return [
        case
        if case.scenario.aiming_offsets is not None
        else _aimed(case, policies.chosen(policy, case.scenario.system))
        for case in cases
    ]


def _aimed(case: Case, policy: str) -> Case:
    if policy == policies.NOMINAL:
        return dataclasses.replace(case, policy=policy)
    scenario = case.scenario
    try:
        plan = policies.plan(policy, scenario.system, scenario.debris_position)
        if plan.policy == FALLBACK:
            return dataclasses.replace(case, policy=plan.policy)
        nominal = nominal_aiming_points(scenario.system, scenario.debris_position)
        offsets = tuple((p[0] - n[0], p[1] - n[1]) for p, n in zip(plan.points, nominal, strict=True))
        return dataclasses.replace(case, scenario=dataclasses.replace(scenario, aiming_offsets=offsets), policy=policy)
    except Exception as error:
        return dataclasses.replace(case, policy=policy, error=f"{type(error).__name__}: {error}")
