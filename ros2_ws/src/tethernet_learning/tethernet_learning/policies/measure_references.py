"""Measure the reward's constants on nominal missions.

m_fmax and A_max are "set from prior observations" in the paper. Here: A_max is the largest mouth area of nominal
missions; m_fmax is twice their largest total fuel [A], which brings the bonus on fuel of a nominal mission near to one
half, as the paper's converged rewards (1.5 with 4 MUs, 2.0 with 8) show it.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core import atomic_file
from tethernet_core.errors import InputError
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system import System
from tethernet_core.system.option import add_systems, chosen_systems
from tethernet_learning import flown
from tethernet_learning.flight_settings import settings_fingerprint
from tethernet_learning.policies import reward
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.run_progress import Progress
from tethernet_learning.seeds import Purpose
from tethernet_planner.inference.task import aimed_task_of
from tethernet_sim.fly import Settings, fly_many

FUEL_FACTOR = 2.0


def measure(system: System, count: int, seed: int, settings: Settings) -> dict[str, Any]:
    """The constants for one system, and how they came about.

    Raises:
        InputError: when no mission was captured, which is what the constants are measured on.
    """
    scenarios = random_scenarios(system, Purpose.REWARD_REFERENCES, seed, 0, count)
    with Progress(f"missions of {system.name}", count) as progress:
        outcomes = fly_many(scenarios, settings, progress=lambda n, _: progress.tell(n))
    done = flown.from_outcomes(outcomes, system)
    if not done.captured.any():
        raise InputError(
            f"none of {count} nominal missions of {system.name} was captured; take more, or a system that captures"
        )
    return {
        "system_digest": system.digest,
        "fuel_max_kg": round(FUEL_FACTOR * float(done.fuel_kg[done.captured].max()), 4),
        "mouth_max_m2": round(float(done.mouth_area_m2.max()), 1),
        "nominal_fuel_mean_kg": round(float(done.fuel_kg[done.captured].mean()), 4),
        "nominal_mouth_mean_m2": round(float(np.mean(done.mouth_area_m2)), 1),
        "nominal_captured": int(done.captured.sum()),
        "missions": count,
        "seed": seed,
        "fuel_factor": FUEL_FACTOR,
        "flight_parameters": settings_fingerprint(settings),
    }


def run(options: argparse.Namespace) -> None:
    """Measure, write and print the constants."""
    systems = chosen_systems(options)
    for system in systems:
        aimed_task_of(system)  # there must be units
    measured = {
        system.name: measure(system, options.missions, options.seed, Settings.load(system)) for system in systems
    }
    kept = reward.references(options.output) if options.output.exists() else {}
    text = json.dumps({**kept, **measured}, indent=2)
    atomic_file.write_text(options.output, text + "\n")
    print(text)


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_systems(parser)
    add("--missions", type=whole_number(1), default=50, metavar="N", help="for each system, default 50")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the missions, default 0")
    add(
        "--output", type=Path, default=reward.REFERENCES_FILE, metavar="FILE.json",
        help="default: the file that training reads; constants of other systems there are kept",
    )  # fmt: skip


COMMAND = Subcommand(
    "Measure m_fmax and A_max of the reward on nominal missions that are captured.",
    ("", "--missions 10 --output references.json"), run, _add_arguments,
)  # fmt: skip
