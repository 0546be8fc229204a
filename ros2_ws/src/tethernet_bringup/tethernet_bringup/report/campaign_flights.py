"""Flights of missions of a campaign: flown once more, to be shown. A scenario and its settings say all of it."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tethernet_bringup.report.flight import Flight
from tethernet_bringup.report.geometry import coarse_knots
from tethernet_core.settings import NANOSECOND_S
from tethernet_core.system import System
from tethernet_learning.campaigns.cases import Case
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_sim.fly import Settings, fly_many
from tethernet_sim.scenario import Outcome, Scenario
from tethernet_sim.state import CHASER, DEBRIS
from tethernet_sim.world import World

STEP_S = 0.25
"""From moment to moment [s]."""
BATCH = 8
"""So many are flown together and held in memory."""


class Flown(NamedTuple):
    """A mission that was flown once more."""

    flight: Flight
    outcome: Outcome


def fly_again(
    numbers: Sequence[int],
    cases: Sequence[Case],
    settings: Callable[[int], Settings],
    told: Callable[[int, int], None] = lambda done, total: None,
) -> Iterator[tuple[int, Flown]]:
    """Fly missions once more.

    Args:
        numbers: of the missions, places in ``cases``; those that cannot be flown are left out.
        cases: all of the campaign.
        settings: of the mission with a number.
        told: called with how many are flown, of how many.

    Yields:
        Number and flight of each, those of one system and settings after the other.
    """
    alike: dict[tuple[System, Settings], list[int]] = {}
    for number in numbers:
        if not cases[number].error:
            alike.setdefault((cases[number].scenario.system, settings(number)), []).append(number)
    done = 0
    for (_, flown_with), members in alike.items():
        for begin in range(0, len(members), BATCH):
            batch = members[begin : begin + BATCH]
            yield from zip(batch, _fly([cases[number].scenario for number in batch], flown_with), strict=True)
            done += len(batch)
            told(done, len(numbers))


class _Recorder:
    """Looks at every so many control ticks."""

    def __init__(self, scenarios: Sequence[Scenario], period_ns: int):
        self._every_ns = max(1, round(STEP_S / NANOSECOND_S / period_ns)) * period_ns
        system = scenarios[0].system
        self._shown = coarse_knots(system)
        self._worlds: list[World] = []
        self._first = 0
        self.rows: list[list[tuple[np.ndarray, ...]]] = [[] for _ in scenarios]

    @property
    def step_s(self) -> float:
        return self._every_ns * NANOSECOND_S

    def look(self, stamp_ns: int, world: World, flying: np.ndarray) -> None:
        if not self._worlds or world is not self._worlds[-1]:  # what does not fit into the memory is flown in parts
            self._first += len(self._worlds[-1].state.bodies) if self._worlds else 0
            self._worlds = [world]
        if stamp_ns % self._every_ns:
            return
        for index in flying:
            knots = world.knots_as_published(index)
            bodies = [np.array([*world.body_motion(index, body)[0], *world.body_motion(index, body)[1]])
                      for body in (DEBRIS, CHASER)]  # fmt: skip
            self.rows[self._first + int(index)].append(
                (
                    knots if self._shown is None else knots[self._shown],
                    world.mus_as_published(index),
                    *bodies,
                    np.array(world.state.locked[index], float),
                )
            )


def _fly(scenarios: Sequence[Scenario], settings: Settings) -> Iterator[Flown]:
    recorder = _Recorder(scenarios, settings.control.period_ns)
    outcomes = fly_many(scenarios, settings, recorder.look)
    for scenario, outcome, rows in zip(scenarios, outcomes, recorder.rows, strict=True):
        knots, units, debris, chaser, locked = (np.array(track) for track in zip(*rows, strict=True))
        system = scenario.system
        yield Flown(
            Flight(
                title=system.name,
                system=system.digest,
                start_s=0.0,
                step_s=recorder.step_s,
                knots=knots,
                units=units if system.unit_count else None,
                debris=debris,
                chaser=chaser,
                locked=locked,
                aiming=scenario.aiming_points() if system.unit_count else None,
                phases=_phases(outcome),
            ),
            outcome,
        )


def _phases(outcome: Outcome) -> list[tuple[str, float]]:
    phases = [("deploying", 0.0)]
    if outcome.trigger_time_s is not None:
        phases.append(("closing", outcome.trigger_time_s))
    if math.isfinite(outcome.end_time_s):
        tested = outcome.hold_s > 0.0 and outcome.trigger_time_s is not None
        phases.append(("hold test" if tested else "end", outcome.end_time_s))
    return phases


def settings_of(files: Iterable[Path], cases_of: Sequence[Sequence[Case]]) -> Callable[[int], Settings]:
    """With which settings each mission was flown, by its number among all of all files.

    Args:
        files: outcomes files; what lies beside them says it, else the system's own are taken.
        cases_of: their missions.

    Raises:
        CampaignError: for a description of a campaign that cannot be read.
    """
    by_number: list[Callable[[System], Settings]] = []
    for file, cases in zip(files, cases_of, strict=True):
        by_number += [_described(file)] * len(cases)
    systems = [case.scenario.system for cases in cases_of for case in cases]
    return lambda number: by_number[number](systems[number])


def _described(file: Path) -> Callable[[System], Settings]:
    beside = file.with_name(file.name + ".json")
    values: dict[str, dict[str, dict[str, object]]] = {}
    if beside.is_file():
        try:
            values = dict(json.loads(beside.read_text(encoding="utf-8")).get("settings", {}))
        except (AttributeError, TypeError, ValueError, OSError) as error:
            raise CampaignError(f"{beside} is no campaign's: {error}; remove it to take the system's own") from error

    @functools.cache
    def of(system: System) -> Settings:
        return Settings.load(system, **values.get(system.name, {}))

    return of
