"""What contact costs: the CPU time of the same missions with it and without, on one core.

They take turns, because a shared machine is not equally fast at all times; ratios are medians over the turns. CPU time
of the process counts, compiling not.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Sequence
from typing import Any

from tethernet_core.subcommand import whole_number
from tethernet_sim import cores
from tethernet_sim.fly import Settings, fly
from tethernet_sim.scenario import Scenario

from .figures import machine
from .mission import CAPTURE_AT_ONCE, fly_in_turns

SYSTEMS = ("zenit_8mu", "zenit_4mu")


def begin(name: str, description: str, argv: list[str] | None) -> tuple[bool, int]:
    """Read the command line of such a benchmark and say on which machine it runs.

    Args:
        name: of its module.
        description: one line.
        argv: words of the command line; None: the process's.

    Returns:
        (whether it is a short run, missions of each kind).
    """
    parser = argparse.ArgumentParser(prog=f"python -m benchmarks.{name}", description=description)
    parser.add_argument("--smoke", action="store_true", help="missions of a second, one turn")
    parser.add_argument(
        "--turns", type=whole_number(1), default=5, metavar="N", help="missions with and without; default 5"
    )
    options = parser.parse_args(argv)
    cores.use(1)
    print(machine())
    return options.smoke, 1 if options.smoke else options.turns


def compare(system: str, settings: dict[str, Settings], parts: Sequence[str], turns: int) -> dict[str, Any]:
    """Fly with two settings, print what they cost.

    Args:
        system: name of a shipped system.
        settings: by name, that without first; compiled or in the cache.
        parts: of a mission, see benchmarks.mission.Cost.
        turns: missions with each.

    Returns:
        For each part the ratio of the second to the first, and the CPU time of both [s].
    """
    costs = fly_in_turns(system, settings, turns)
    without, touching = settings
    figures: dict[str, Any] = {}
    for part in parts:
        few, many = ([getattr(cost, part) for cost in costs[name]] for name in settings)
        ratio = statistics.median(more / less for more, less in zip(many, few, strict=True))
        figures |= {
            f"{part}_ratio_{system}": ratio, f"{part}_cpu_s_{without}_{system}": statistics.median(few),
            f"{part}_cpu_s_{touching}_{system}": statistics.median(many),
        }  # fmt: skip
        print(
            f"{system}, {part}: {touching} {statistics.median(many):.3f}, {without} {statistics.median(few):.3f} "
            f"CPU s: {ratio:.2f} times",
            flush=True,
        )
    return figures


def two_settings(system: str, entry: str, choices: Sequence[str], smoke: bool) -> dict[str, Settings]:
    """Settings that differ in one entry of the physics, by its value; compiled.

    Args:
        system: name of a shipped system.
        entry: of the physics.
        choices: its values.
        smoke: missions of a second.
    """
    mission = CAPTURE_AT_ONCE if smoke else {}
    for choice in choices:
        fly(Scenario(system), Settings.load(system, physics={entry: choice}, mission=CAPTURE_AT_ONCE))
    return {choice: Settings.load(system, physics={entry: choice}, mission=mission) for choice in choices}
