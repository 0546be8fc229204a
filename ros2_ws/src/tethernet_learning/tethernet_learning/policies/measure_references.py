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
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system.option import add_systems, chosen_systems, family_units
from tethernet_learning import flown
from tethernet_learning.flight_settings import settings_fingerprint
from tethernet_learning.policies import reward
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.run_progress import Progress
from tethernet_learning.seeds import Purpose
from tethernet_sim.fly import Settings, fly_many

FUEL_FACTOR = 2.0


def measure(mus: int, count: int, seed: int, settings: Settings) -> dict[str, Any]:
    """The constants for one design, and how they came about."""
    scenarios = random_scenarios(mus, Purpose.REWARD_REFERENCES, seed, 0, count)
    progress = Progress(f"missions with {mus} MUs", count)
    outcomes = fly_many(scenarios, settings, progress=lambda n, _: progress.tell(n))
    done = flown.from_outcomes(outcomes, scenarios[0].system)
    return {
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
    settings = Settings.load()
    designs = family_units(chosen_systems(options))
    measured = {str(mus): measure(mus, options.missions, options.seed, settings) for mus in designs}
    text = json.dumps(measured, indent=2)
    atomic_file.write_text(options.output, text + "\n")
    print(text)


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_systems(parser)
    add("--missions", type=whole_number(1), default=50, metavar="N", help="for each system, default 50")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the missions, default 0")
    add(
        "--output", type=Path, default=reward.REFERENCES_FILE, metavar="FILE.json",
        help="default: the file that training reads",
    )  # fmt: skip


COMMAND = Subcommand(
    "Measure m_fmax and A_max of the reward on nominal missions that are captured.",
    ("", "--missions 10 --output references.json"), run, _add_arguments,
)  # fmt: skip
