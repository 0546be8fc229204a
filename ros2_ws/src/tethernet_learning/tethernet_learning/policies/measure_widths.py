"""Measure what the width of the aiming points does.

The nominal points are moved towards the middle or away from it, all by the same factor: the one direction in which a
person would look for less fuel, and what a policy's savings are to be seen against.
"""

from __future__ import annotations

import argparse
import dataclasses

import numpy as np

from tethernet_core.subcommand import Parser, Subcommand, number, whole_number
from tethernet_core.system import System
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning.flight_settings import Flight, add_set, flights_of
from tethernet_learning.flown import from_outcomes
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.run_progress import Progress
from tethernet_learning.seeds import Purpose
from tethernet_planner.inference.task import aimed_task_of
from tethernet_sim.fly import fly_many

FACTORS = (0.6, 0.65, 0.7, 0.8, 0.9, 0.97, 1.0, 1.02, 1.04, 1.1)
HEAD = "| width | captured | fuel per MU, kg | until the trigger, kg | trigger, s | mouth, m^2 |"


def measure(system: System, factor: float, count: int, seed: int, flight: Flight) -> dict[str, float]:
    """Fly nominal points that are all moved by one factor.

    Args:
        system: that is aimed for, as it is described.
        factor: distance from the middle, as a share of the nominal one.
        count: scenarios, the same for every factor.
        seed: of the scenarios.
        flight: how it is flown.

    Returns:
        Means over the scenarios: share ``captured``, ``fuel_kg`` and ``fuel_at_trigger_kg`` per MU [kg],
        ``trigger_time_s`` [s] of those in which closing began, ``mouth_area_m2`` [m^2].
    """
    moved = (factor - 1.0) * system.aiming.offsets
    offsets = tuple(map(tuple, moved.tolist()))
    drawn = random_scenarios(system, Purpose.OFFSET_OPTIMISATION, seed, 0, count)
    scenarios = [dataclasses.replace(s, system=flight.system, aiming_offsets=offsets) for s in drawn]
    outcomes = fly_many(scenarios, flight.settings)
    flown = from_outcomes(outcomes, flight.system)
    times = [outcome.trigger_time_s for outcome in outcomes if outcome.trigger_time_s is not None]
    return {
        "captured": float(flown.captured.mean()),
        "fuel_kg": float(flown.fuel_kg.mean()) / system.unit_count,
        "fuel_at_trigger_kg": float(np.mean([outcome.fuel_at_trigger_kg for outcome in outcomes])),
        "trigger_time_s": float(np.mean(times)) if times else float("nan"),
        "mouth_area_m2": float(flown.mouth_area_m2.mean()),
    }


def run(options: argparse.Namespace) -> None:
    """Measure and print a table."""
    system = chosen_system(options)
    aimed_task_of(system)  # there must be units
    flight = flights_of(options.set, [system])[system]
    with Progress("widths", len(options.factors)) as progress:
        progress.print(HEAD + "\n|" + "---|" * (HEAD.count("|") - 1))
        for number_, factor in enumerate(options.factors, 1):
            r = measure(system, factor, options.scenarios, options.seed, flight)
            progress.print(
                f"| {factor:g} | {100 * r['captured']:.0f} % | {r['fuel_kg']:.5f} | {r['fuel_at_trigger_kg']:.5f} | "
                f"{r['trigger_time_s']:.2f} | {r['mouth_area_m2']:.0f} |"
            )
            progress.tell(number_)


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_system(parser)
    add(
        "--factors", type=number(0.01, 1.99), nargs="+", default=FACTORS, metavar="F",
        help=f"distances from the middle, 1: nominal; default {' '.join(f'{factor:g}' for factor in FACTORS)}",
    )  # fmt: skip
    add("--scenarios", type=whole_number(1), default=16, metavar="N", help="for each factor, default 16")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the scenarios, default 0")
    add_set(parser)


COMMAND = Subcommand(
    "Fly the nominal aiming points moved towards the middle and away from it, in full.",
    ("--mus 4", "--system zenit_8mu --factors 0.9 1 1.1 --set control.follow_through_m=0"), run, _add_arguments,
)  # fmt: skip
