"""CPU time of whole missions whose net touches itself, and passes of thread through thread, against one that does not:
``python -m benchmarks.net_contact [--smoke]``.

Both fly the same missions on one core, taking turns, because a shared machine is not equally fast at all times; ratios
are medians over the turns. CPU time of the process counts, compiling not. Passes are counted in one mission of each,
every millisecond (benchmarks/thread_passes.py).
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
from tethernet_sim.settings import NONE, THREADS

from .figures import conclude, machine
from .mission import CAPTURE_AT_ONCE, fly_in_turns
from .thread_passes import PassCounter

SYSTEMS = ("zenit_8mu", "zenit_4mu")


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.net_contact", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="missions of a second, one turn, passes of 8 MUs only")
    parser.add_argument(
        "--turns", type=whole_number(1), default=5, metavar="N", help="missions with and without; default 5"
    )
    options = parser.parse_args(argv)
    turns, mission = (1, CAPTURE_AT_ONCE) if options.smoke else (options.turns, {})

    cores.use(1)
    print(machine())
    figures: dict[str, Any] = {}
    for name in SYSTEMS:
        settings = {
            contact: Settings.load(name, physics={"net_contact": contact}, mission=mission)
            for contact in (NONE, THREADS)
        }
        for contact in (NONE, THREADS):
            at_once = Settings.load(name, physics={"net_contact": contact}, mission=CAPTURE_AT_ONCE)
            fly(Scenario(name), at_once)  # compiles or loads
        costs = fly_in_turns(name, settings, turns)
        for part in ("whole", "deployment", "capture"):
            without, touching = ([getattr(cost, part) for cost in costs[contact]] for contact in (NONE, THREADS))
            ratio = statistics.median(many / few for many, few in zip(touching, without, strict=True))
            figures[f"{part}_ratio_{name}"] = ratio
            print(
                f"{name}, {part}: with {statistics.median(touching):.3f}, without {statistics.median(without):.3f} "
                f"CPU s: {ratio:.2f} times",
                flush=True,
            )
        for contact in (NONE, THREADS):
            if options.smoke and name != SYSTEMS[0]:
                continue
            passes = PassCounter()
            fly(Scenario(name, seed=1), settings[contact], passes)
            figures |= {
                f"passes_deployment_{contact}_{name}": passes.deployment,
                f"passes_capture_{contact}_{name}": passes.capture,
            }
            print(
                f"{name}, net contact {contact}: passes of thread through thread: deployment {passes.deployment}, "
                f"capture {passes.capture}",
                flush=True,
            )
    conclude("net_contact", {"turns": turns} | figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
