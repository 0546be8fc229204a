"""Measure what a surrogate saves in an episode (``python -m tethernet_learning.policies.measure_speedup``)."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import command_start

    command_start()

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from tethernet_core.command import command
from tethernet_learning import run_folder
from tethernet_learning.policies import capture_sources as sources
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose
from tethernet_planner.inference.model_file import ModelFileError
from tethernet_planner.inference.surrogate_file import Surrogate
from tethernet_sim.fly import Settings


def measure(surrogate: Surrogate, count: int, settings: Settings) -> dict:
    """Wall time of the same episodes, nominal aiming points, in full and through the surrogate, one batch each."""
    scenarios = random_scenarios(surrogate.mus, Purpose.POLICY_TRAINING, 0, 0, count)
    flown = {
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
    return {"mus": surrogate.mus, "episodes": count, "seconds_per_episode": seconds, "speedup": ratio}


@command
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print. Returns 0; 2 for a wrong file."""
    parser = argparse.ArgumentParser(
        prog="python -m tethernet_learning.policies.measure_speedup",
        description="Measure the wall time of an episode in full and through a surrogate.",
    )
    parser.add_argument("--surrogate", type=Path, required=True, metavar="FILE")
    parser.add_argument("--episodes", type=int, default=32, metavar="N")
    parser.add_argument("--output", type=Path, metavar="FILE.json")
    options = parser.parse_args(argv)
    if options.episodes < 1:
        parser.error(f"--episodes {options.episodes}: allowed: 1 or more")
    try:
        surrogate = Surrogate.load(options.surrogate)
    except ModelFileError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    run_folder.tell(measure(surrogate, options.episodes, Settings.load()), options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
