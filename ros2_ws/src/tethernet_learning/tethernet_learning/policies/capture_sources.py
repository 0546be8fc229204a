"""What a capture comes to in an episode, CQI, locked pairs and fuel: the full simulation or a surrogate, by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from tethernet_learning import assumed_numbers
from tethernet_learning.data.trigger import fly_and_look
from tethernet_learning.flight_settings import Flight
from tethernet_learning.flown import CQI_LIMIT, Flown, from_outcomes, together
from tethernet_learning.seeds import Purpose
from tethernet_planner.inference.surrogate_file import NOISES, Surrogate
from tethernet_sim.fly import Settings, fly_many
from tethernet_sim.scenario import Scenario

FULL = "full"
SURROGATE = "surrogate"


class Source(Protocol):
    """Flies episodes."""

    def fly(self, scenarios: Sequence[Scenario], flight: Flight | None = None) -> Flown:
        """Args:
        scenarios: of one system, as it is described; it judges what comes out.
        flight: the system and parameters that they are flown with instead; None: as described, with the parameters
            that the source was made with.
        """


class FullSimulation:
    """Every capture is simulated to its end."""

    def __init__(self, settings: Settings):
        self._settings = settings

    def fly(self, scenarios: Sequence[Scenario], flight: Flight | None = None) -> Flown:
        """See :class:`Source`."""
        return from_outcomes(fly_many(*_as_flown(scenarios, self._settings, flight)), scenarios[0].system)


class SurrogateCapture:
    """Deployment is simulated, a surrogate tells what the capture comes to (paper, section II.E).

    The CQI is drawn from a Gaussian around the prediction with the surrogate's own test error where it is below 20
    [P]; so are the locked pairs (the paper's state transition speaks of both), rounded. One scenario gives one draw,
    whatever is flown beside it. Missions that never come to closing are known exactly.
    """

    def __init__(self, settings: Settings, surrogate: Surrogate, noise: str = NOISES[0]):
        """Args:
        settings: of the flights.
        surrogate: tells what captures come to.
        noise: one of :data:`.surrogate_file.NOISES`.
        """
        self._settings, self._surrogate, self._noise = settings, surrogate, noise

    def fly(self, scenarios: Sequence[Scenario], flight: Flight | None = None) -> Flown:
        """See :class:`Source`.

        Raises:
            ModelFileError: for scenarios of a system that the surrogate was not made for.
        """
        outcomes, seen = fly_and_look(*_as_flown(scenarios, self._settings, flight), stop_at_trigger=True)
        flown = from_outcomes(outcomes, scenarios[0].system)
        closing = np.array([i for i, row in enumerate(seen) if row is not None], dtype=int)
        if not len(closing):
            return flown
        self._surrogate.check_system(scenarios[0].system)
        predicted = self._surrogate.predict_many(np.array([seen[i] for i in closing]))
        draws = np.array([_draw(scenarios[i].seed) for i in closing])
        cqi_error, pairs_error = self._surrogate.draw_errors(predicted, draws, self._noise, scenarios[0].system)
        cqi = np.where(predicted.cqi < CQI_LIMIT, predicted.cqi + cqi_error, predicted.cqi)
        pairs = predicted.locked_pairs + pairs_error
        all_cqi, all_pairs = flown.cqi.copy(), flown.locked_pairs.copy()
        all_cqi[closing] = np.clip(cqi, 0.0, CQI_LIMIT)
        all_pairs[closing] = np.clip(np.round(pairs), 0, flown.system.closing.max_locked_pairs)
        total = flown.fuel_kg.copy()
        total[closing] += predicted.closing_fuel_kg
        return dataclasses.replace(flown, cqi=all_cqi, locked_pairs=all_pairs, fuel_kg=total)


class _Assumed:
    """Another source with other numbers that nobody has measured for each group of scenarios.

    A surrogate knows captures with the numbers that it was trained with: with it they change what comes before.
    """

    def __init__(self, source: Source, base: Flight):
        """Args:
        source: flies.
        base: what is flown as it is described; the numbers that are not changed are its.
        """
        self._source, self._base = source, base

    def fly(self, scenarios: Sequence[Scenario], flight: Flight | None = None) -> Flown:
        """See :class:`Source`."""
        base = flight or self._base
        parts, order = [], []
        for group, (numbers, seed) in enumerate(assumed_numbers.groups(scenarios)):
            flown_with = self._flight(base, group, seed)
            parts.append(self._source.fly([scenarios[number] for number in numbers], flown_with))
            order += numbers
        return together(parts, order)

    def _flight(self, base: Flight, group: int, seed: int) -> Flight:
        """How a group of scenarios is flown."""
        raise NotImplementedError


class RandomlyAssumed(_Assumed):
    """With these numbers drawn at random, for each group anew."""

    def _flight(self, base: Flight, group: int, seed: int) -> Flight:
        return assumed_numbers.drawn(base, seed)[0]


class AssumedAtEnds(_Assumed):
    """As described, then with each of these numbers alone at either end of its range: a group each, over and over."""

    def _flight(self, base: Flight, group: int, seed: int) -> Flight:
        flights = assumed_numbers.at_ends(base)
        return flights[group % len(flights)][0]


def _as_flown(
    scenarios: Sequence[Scenario], settings: Settings, flight: Flight | None
) -> tuple[Sequence[Scenario], Settings]:
    if flight is None:
        return scenarios, settings
    return [dataclasses.replace(scenario, system=flight.system) for scenario in scenarios], flight.settings


def _draw(scenario_seed: int) -> np.ndarray:
    key = (int(Purpose.PREDICTION_NOISE), scenario_seed)
    return np.random.default_rng(np.random.SeedSequence(0, spawn_key=key)).standard_normal(2)


def make(name: str, settings: Settings, surrogate_file: Path | None = None, noise: str = NOISES[0]) -> Source:
    """The source with this name.

    Args:
        name: ``full`` or ``surrogate``.
        settings: of the flights.
        surrogate_file: which surrogate; needed for ``surrogate``.
        noise: of the surrogate's predictions, one of :data:`.surrogate_file.NOISES`.

    Raises:
        ValueError: for an unknown name or a missing file name.
        ModelFileError: when the file is no surrogate.
    """
    if name == FULL:
        return FullSimulation(settings)
    if name == SURROGATE:
        if surrogate_file is None:
            raise ValueError("source surrogate needs the file of a surrogate")
        return SurrogateCapture(settings, Surrogate.load(surrogate_file), noise)
    raise ValueError(f"no source named {name!r}; allowed: {FULL}, {SURROGATE}")
