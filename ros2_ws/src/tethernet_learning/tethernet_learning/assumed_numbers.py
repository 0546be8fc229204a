"""The numbers that every flight assumes and nobody has measured, and how they are drawn at random.

A policy that was trained with one value of the threads' damping may save nothing with another. Trained and evaluated
with values drawn from the range in which the true ones lie, what it saves holds over that range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tethernet_core.parameters import load
from tethernet_core.system.changing import changed
from tethernet_learning.flight_settings import Flight
from tethernet_learning.seeds import Purpose, sequence
from tethernet_learning.stable_step import stable_step_s
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Scenario
from tethernet_sim.settings import PhysicsParameters

AS_DESCRIBED, RANDOM, ENDS = "described", "random", "ends"
CHOICES = (AS_DESCRIBED, RANDOM)
CHOICES_OF_TRAINING = (*CHOICES, ENDS)
"""``ends``: as described, then with each number alone at either end of its range, see :func:`at_ends`."""
GROUP = 8
"""Different scenarios that share a draw: they are flown as one batch, which is what makes a flight cheap."""


@dataclass(frozen=True)
class Assumed:
    """A number and the range in which it may lie."""

    name: str
    """Entry of the description, or of the physics."""
    low: float
    high: float
    by_described: bool = False
    """The range is in multiples of the described value, and even in its logarithm."""

    def value(self, share: float, described: float) -> float:
        """The value at a share of the range, 0 to 1."""
        if self.by_described:
            return float(described * self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)


OF_SYSTEM = (
    Assumed("net.thread.damping_ratio", 0.05, 0.2),
    Assumed("tether.stiffness_n_m", 0.5, 2.0, by_described=True),
    Assumed("closing.winch.stiffness_n_m", 0.1, 1.0, by_described=True),
)
"""Entries of descriptions. The last one only where there are winches."""
OF_PHYSICS = (
    Assumed("fold_factor", 0.02, 0.1),
    Assumed("friction_coefficient", 0.0, 1.0),
)
"""Parameters of the physics."""


def drawn(base: Flight, seed: int) -> tuple[Flight, dict[str, float]]:
    """How a system is flown with all assumed numbers drawn, evenly and independently.

    Args:
        base: how it is flown as it is described; all else stays.
        seed: of the draw.

    Returns:
        System and settings, with a stable time step, and the numbers by name.
    """
    random = np.random.default_rng(sequence(Purpose.ASSUMED_NUMBERS, seed, 0))
    # A share for each number, whether the system has it or not: systems without winches draw the same of all else.
    of_system, of_physics = random.random(len(OF_SYSTEM)), random.random(len(OF_PHYSICS))
    system, physics = base.system, base.settings.physics
    entries = {
        number.name: number.value(share, float(described_entry(system.content, number.name)))
        for number, share in zip(OF_SYSTEM, of_system.tolist(), strict=True)
        if described_entry(system.content, number.name) is not None
    }
    parameters = {
        number.name: number.value(share, float(getattr(physics, number.name)))
        for number, share in zip(OF_PHYSICS, of_physics.tolist(), strict=True)
    }
    return _flown_with(base, entries, parameters), {**entries, **parameters}


def at_ends(base: Flight) -> list[tuple[Flight, dict[str, float]]]:
    """How a system is flown as it is described, then with each assumed number alone at either end of its range.

    Args:
        base: how it is flown as it is described; all else stays.

    Returns:
        System and settings, with a stable time step, and the number that is changed by its name; an end that is the
        described value is left out.
    """
    flights: list[tuple[Flight, dict[str, float]]] = [(base, {})]
    for number in OF_SYSTEM:
        entry = described_entry(base.system.content, number.name)
        for share in (0.0, 1.0) if entry is not None else ():
            value = number.value(share, float(entry))
            if value != entry:
                flights.append((_flown_with(base, {number.name: value}, {}), {number.name: value}))
    for number in OF_PHYSICS:
        described = float(getattr(base.settings.physics, number.name))
        for share in (0.0, 1.0):
            value = number.value(share, described)
            if value != described:
                flights.append((_flown_with(base, {}, {number.name: value}), {number.name: value}))
    return flights


def _flown_with(base: Flight, entries: dict[str, float], parameters: dict[str, float]) -> Flight:
    """With entries of the description and parameters of the physics replaced, and a stable time step."""
    flown, physics = changed(base.system, entries), base.settings.physics
    as_given = {name: getattr(physics, name) for name in PhysicsParameters.__dataclass_fields__ if name != "FILE"}
    wanted = load(PhysicsParameters, {**as_given, **parameters})
    step_s = stable_step_s(flown, wanted, base.settings.control)
    settings = Settings(
        load(PhysicsParameters, {**as_given, **parameters, "time_step_s": step_s}),
        base.settings.control,
        base.settings.mission,
    )
    return Flight(flown, settings)


def groups(scenarios: Sequence[Scenario]) -> list[tuple[list[int], int]]:
    """Scenarios that share a draw, by their numbers in the list, and the seed of each draw: that of the first of them.

    The same scenarios in the same order, whatever aims them, get the same draws; so does one that is there twice.
    """
    first: dict[int, int] = {}
    for scenario in scenarios:
        first.setdefault(scenario.seed, len(first))
    members: dict[int, list[int]] = {}
    for number, scenario in enumerate(scenarios):
        members.setdefault(first[scenario.seed] // GROUP, []).append(number)
    return [(numbers, scenarios[numbers[0]].seed) for numbers in members.values()]


def described_entry(content: Any, name: str) -> Any:
    """What a description says under a dotted name; None where it has no such entry."""
    for key in name.split("."):
        content = content.get(key) if hasattr(content, "get") else None
    return content
