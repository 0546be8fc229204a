"""Measure how far the net at the trigger decides the capture.

A capture is chaotic: knots bounce, threads snap taut, friction sticks and slips. Two nets that no surrogate can tell
apart may end differently, and that bounds what a surrogate can be right in.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.errors import InputError
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system import System
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning import run_folder
from tethernet_learning.data.make_data import scenarios as data_scenarios
from tethernet_learning.flown import CQI_LIMIT, from_outcomes
from tethernet_learning.run_progress import Progress
from tethernet_sim.fly import Settings, fly_many
from tethernet_sim.scenario import Outcome, Scenario
from tethernet_sim.world import World

DISPLACEMENT_M = 1e-6
"""Largest displacement of a knot along each axis [m]: less than the published float32 coordinates resolve at 50 m."""

_PART = 40
"""Scenarios between two lines of progress."""


def measure(system: System, count: int, seed: int, settings: Settings) -> dict[str, Any]:
    """Fly test scenarios of a data set twice, the knots displaced by different micrometres when closing begins.

    Args:
        system: that is flown.
        count: scenarios.
        seed: of the data set.
        settings: of the flights.

    Returns:
        ``closing_began``: scenarios in which it did; of these ``same_verdict``, the share with two equal verdicts, and
        ``bound``, the share in which a surrogate that knows everything but those micrometres can be right at the most;
        standard deviations of the difference of CQI (both below 20) and locked pairs, over the square root of two.
    """
    first, second = [], []
    with Progress(f"scenarios of {system.name}, twice", count) as progress:
        for begin in range(0, count, _PART):
            chosen = data_scenarios(system, "test", seed, begin, min(_PART, count - begin))
            first += _displaced(chosen, settings, 2 * begin)
            second += _displaced(chosen, settings, 2 * begin + 1)
            progress.tell(len(first))
    closed = [i for i, outcome in enumerate(first) if outcome.trigger_time_s is not None]
    if not closed:
        raise InputError(f"closing began in none of {count} scenarios; take more")
    a, b = (from_outcomes([outcomes[i] for i in closed], system) for outcomes in (first, second))
    differ = float((a.captured != b.captured).mean())
    both = (a.cqi < CQI_LIMIT) & (b.cqi < CQI_LIMIT)
    return {
        "system": system.name,
        "system_digest": system.digest,
        "scenarios": count,
        "seed": seed,
        "displacement_m": DISPLACEMENT_M,
        "closing_began": len(closed),
        "same_verdict": 1.0 - differ,
        "bound": 1.0 - differ / 2.0,
        "cqi_std": float(np.std((a.cqi - b.cqi)[both]) / np.sqrt(2.0)) if both.any() else None,
        "pairs_std": float(np.std(a.locked_pairs - b.locked_pairs) / np.sqrt(2.0)),
    }


def _displaced(chosen: Sequence[Scenario], settings: Settings, seed: int) -> list[Outcome]:
    random = np.random.default_rng(seed)
    by = random.uniform(-DISPLACEMENT_M, DISPLACEMENT_M, (len(chosen), 3, chosen[0].system.net.node_count))

    def displace(number: int, world: World, index: int) -> None:
        world.state.knot_pos[index] += by[number]

    return fly_many(chosen, settings, at_trigger=displace)


def run(options: argparse.Namespace) -> None:
    """Measure and print."""
    system = chosen_system(options)
    run_folder.tell(measure(system, options.scenarios, options.seed, Settings.load(system)), options.output)


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_system(parser)
    add("--scenarios", type=whole_number(1), default=200, metavar="N", help="default 200")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the data set, default 0")
    add("--output", type=Path, metavar="FILE.json", help="gets what is printed")


COMMAND = Subcommand(
    "Fly a data set's test scenarios twice, the net displaced by a micrometre when closing begins: how often the "
    "verdict stays the same bounds what any surrogate can be right in.",
    ("--mus 8", "--system zenit_4mu --scenarios 40 --output repeatability.json"), run, _add_arguments,
)  # fmt: skip
