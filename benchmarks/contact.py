"""CPU time of whole missions whose threads touch, against knots alone: ``python -m benchmarks.contact [--smoke]``.

Both contacts fly the same mission on one core, taking turns, because a shared machine is not equally fast at all times;
ratios are medians over the turns. CPU time of the process counts, compiling not.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from typing import Any

from tethernet_core.subcommand import whole_number
from tethernet_sim import cores
from tethernet_sim.fly import Settings, fly
from tethernet_sim.scenario import Scenario
from tethernet_sim.settings import KNOTS, THREADS

from .figures import conclude, machine
from .mission import CAPTURE_AT_ONCE, fly_in_turns

SYSTEMS = ("zenit_8mu", "zenit_4mu")


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.contact", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="missions of a second, one turn")
    parser.add_argument(
        "--turns", type=whole_number(1), default=5, metavar="N", help="missions of each contact; default 5"
    )
    options = parser.parse_args(argv)
    turns, mission = (1, CAPTURE_AT_ONCE) if options.smoke else (options.turns, {})

    cores.use(1)
    print(machine())
    figures: dict[str, Any] = {}
    for name in SYSTEMS:
        fly(Scenario(name), Settings.load(name, mission=CAPTURE_AT_ONCE))  # compiles or loads
        settings = {
            contact: Settings.load(name, physics={"contact": contact}, mission=mission) for contact in (KNOTS, THREADS)
        }
        costs = fly_in_turns(name, settings, turns)
        for part in ("whole", "capture"):
            knots, threads = ([getattr(cost, part) for cost in costs[contact]] for contact in (KNOTS, THREADS))
            ratio = statistics.median(many / few for many, few in zip(threads, knots, strict=True))
            figures |= {
                f"{part}_ratio_{name}": ratio, f"{part}_cpu_s_knots_{name}": statistics.median(knots),
                f"{part}_cpu_s_threads_{name}": statistics.median(threads),
            }  # fmt: skip
            print(
                f"{name}, {part}: threads {statistics.median(threads):.3f}, knots {statistics.median(knots):.3f} "
                f"CPU s: {ratio:.2f} times",
                flush=True,
            )
    conclude("contact", {"turns": turns} | figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
