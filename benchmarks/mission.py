"""Cost of whole missions in process, to the end of the capture: ``python -m benchmarks.mission [--smoke]``.

One mission on one core (process CPU time, compiling not counted), and batches on one core and on all.
"""

from __future__ import annotations

import argparse
import dataclasses
import statistics
import sys
import time
from collections.abc import Mapping

from tethernet_core.subcommand import whole_number
from tethernet_sim import cores
from tethernet_sim.fly import Settings, fly, fly_many
from tethernet_sim.scenario import Scenario
from tethernet_sim.world import World

from .figures import conclude, machine

CAPTURE_AT_ONCE = {"trigger_distance_m": 50.0, "capture_duration_s": 1.0}
"""Rules of a mission that runs through all phases within a second."""


@dataclasses.dataclass(frozen=True)
class Cost:
    """CPU time of one mission [s]."""

    whole: float
    deployment: float
    """Up to the start of closing."""

    @property
    def capture(self) -> float:
        """From the start of closing to the verdict."""
        return self.whole - self.deployment


@dataclasses.dataclass(frozen=True)
class BatchCost:
    """Cost of one batch [s]."""

    wall: float
    cpu: float


def fly_once(scenario: Scenario, settings: Settings) -> Cost:
    """Fly one mission and see what it costs."""
    deployed = None

    def watch(_stamp_ns: int, world: World, _flying: object) -> None:
        nonlocal deployed
        if deployed is None and world.state.closing[0]:
            deployed = time.process_time()

    began = time.process_time()
    fly(scenario, settings, watch)
    ended = time.process_time()
    return Cost(ended - began, (ended if deployed is None else deployed) - began)


def fly_batch(scenarios: list[Scenario], settings: Settings, threads: int) -> BatchCost:
    """Fly a batch on so many cores and see what it costs."""
    cores.use(threads)
    began, cpu_began = time.perf_counter(), time.process_time()
    fly_many(scenarios, settings)
    return BatchCost(time.perf_counter() - began, time.process_time() - cpu_began)


def fly_in_turns(system: str, settings: Mapping[str, Settings], turns: int) -> dict[str, list[Cost]]:
    """What the same missions cost with each of the settings, by their names: seed by seed, one after the other.

    Args:
        system: name of the shipped system that is flown.
        settings: by name.
        turns: missions with each.
    """
    costs: dict[str, list[Cost]] = {name: [] for name in settings}
    for seed in range(1, turns + 1):
        for name, parameters in settings.items():
            costs[name].append(fly_once(Scenario(system, seed=seed), parameters))
    return costs


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mission", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="missions of a second")
    parser.add_argument(
        "--missions", type=whole_number(1), default=5, metavar="N", help="missions of each design; default 5"
    )
    parser.add_argument(
        "--batch", type=whole_number(1), default=16, metavar="N", help="scenarios of a batch; default 16"
    )
    options = parser.parse_args(argv)
    missions, batch = (1, 4) if options.smoke else (options.missions, options.batch)
    settings = Settings.load(mission=CAPTURE_AT_ONCE) if options.smoke else Settings.load()

    threads = cores.count()
    print(machine())
    cores.use(1)
    shortest = Settings.load(mission=CAPTURE_AT_ONCE)
    costs: dict[int, list[Cost]] = {}
    for mus in (8, 4):
        fly(Scenario(f"zenit_{mus}mu"), shortest)  # compiles or loads
        costs[mus] = [fly_once(Scenario(f"zenit_{mus}mu", seed=seed), settings) for seed in range(1, missions + 1)]
        whole, deployment, capture = (
            statistics.median(getattr(cost, part) for cost in costs[mus]) for part in ("whole", "deployment", "capture")
        )
        print(
            f"{mus} MUs, one core: {whole:.3f} CPU s a mission (deployment {deployment:.3f}, capture {capture:.3f}), "
            f"median of {missions}",
            flush=True,
        )
    scenarios = [Scenario("zenit_8mu", seed=seed) for seed in range(1, batch + 1)]
    alone = fly_batch(scenarios, settings, 1)
    together = fly_batch(scenarios, settings, threads)
    speed_up = alone.wall / together.wall
    print(
        f"{batch} missions as a batch: {batch / alone.wall:.2f} a second on one core, {batch / together.wall:.2f} on "
        f"{threads}: {speed_up:.2f} times faster, CPU time {together.cpu / alone.cpu:.2f} times as much"
    )
    eight, four = costs[8], costs[4]
    conclude(
        "mission",
        {
            "cpu_s": statistics.median(cost.whole for cost in eight),
            "deployment_cpu_s": statistics.median(cost.deployment for cost in eight),
            "capture_cpu_s": statistics.median(cost.capture for cost in eight),
            "cpu_s_4_mus": statistics.median(cost.whole for cost in four),
            "batch_scenarios_per_s": batch / together.wall,
            "batch_scenarios_per_s_one_core": batch / alone.wall,
            "batch_cores": threads,
            "batch_efficiency": speed_up / threads,
            "batch_cpu_ratio": together.cpu / alone.cpu,
        },
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
