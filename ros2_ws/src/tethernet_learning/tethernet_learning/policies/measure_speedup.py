"""Measure what a surrogate saves in an episode."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system import System
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning import run_folder
from tethernet_learning.policies import capture_sources as sources
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose
from tethernet_planner.inference.surrogate_file import Surrogate
from tethernet_sim.fly import Settings


def measure(system: System, surrogate: Surrogate, count: int, settings: Settings) -> dict[str, Any]:
    """Wall time of the same episodes, nominal aiming points, in full and through the surrogate, one batch each."""
    scenarios = random_scenarios(system, Purpose.POLICY_TRAINING, 0, 0, count)
    flown: dict[str, sources.Source] = {
        sources.FULL: sources.FullSimulation(settings),
        sources.SURROGATE: sources.SurrogateCapture(settings, surrogate),
    }
    seconds = {}
    for name, source in flown.items():
        source.fly(scenarios[:1])  # compiles and loads
        began = time.perf_counter()
        source.fly(scenarios)
        seconds[name] = (time.perf_counter() - began) / count
    ratio = seconds[sources.FULL] / seconds[sources.SURROGATE]
    return {"system": system.name, "episodes": count, "seconds_per_episode": seconds, "speedup": ratio}


def run(options: argparse.Namespace) -> None:
    """Measure and print."""
    system, surrogate = chosen_system(options), Surrogate.load(options.surrogate)
    surrogate.check_system(system)
    run_folder.tell(measure(system, surrogate, options.episodes, Settings.load(system)), options.output)


def _add_arguments(parser: Parser) -> None:
    add_system(parser)
    parser.add_argument("--surrogate", type=Path, required=True, metavar="FILE", help="surrogate.safetensors")
    parser.add_argument("--episodes", type=whole_number(1), default=32, metavar="N", help="default 32")
    parser.add_argument("--output", type=Path, metavar="FILE.json", help="gets what is printed")


COMMAND = Subcommand(
    "Measure the wall time of an episode in full and through a surrogate.",
    ("--mus 8 --surrogate SURROGATE/surrogate.safetensors",), run, _add_arguments,
)  # fmt: skip
