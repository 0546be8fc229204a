"""CPU time per knot and step of square nets from 529 to 8,281 knots: ``python -m benchmarks.scale [--smoke]``.

Each net is flat, shrunk a little and its knots shifted at random, so that the same share of threads is taut at every
size: as many as while a net opens, when single threads are looked up, and as many as in a flat net, when all are
evaluated. The step is so short that the share stays what it is; its length changes nothing about what a step costs.
Grid and edge list fly the same states in turn on one core, in batches of 1 to 64, far from the debris; CPU time of the
process counts, of the physics' steps alone, and the fastest of the turns, because a shared machine only ever takes time
away.

Positions and velocities are 48 bytes a knot. Those of the smallest net fit into a first cache of 32 KiB, those of the
others do not: ``growth_beyond_first_cache`` compares the largest net with the middle one, both of which have left it.
"""

from __future__ import annotations

import argparse
import math
import resource
import statistics
import sys
import time
from dataclasses import fields, replace

import numpy as np

from tethernet_core.subcommand import whole_number
from tethernet_core.system import load_system
from tethernet_sim import cores
from tethernet_sim.engine import Commands, EdgeListEngine, Engine, GridEngine
from tethernet_sim.fly import Settings
from tethernet_sim.model import build_model
from tethernet_sim.state import State, initial_state

from .figures import conclude, machine

SIDES, BATCHES = (23, 45, 91), (1, 8, 64)
SHARES = {"opening": 0.04, "flat": 0.5}
"""Of the threads that are taut."""
SHIFT_M = 1e-3
"""Standard deviation of the knots' shifts along each axis in the plane."""
STEP_S = 1e-9
STEPS = 500
"""Of one measurement."""
SMOKE_SIDES, SMOKE_BATCHES, SMOKE_STEPS = (23, 45), (1, 2), 100
SYSTEM = "zenit_8mu"


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scale", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="two sizes, two batches, one short turn")
    parser.add_argument(
        "--turns", type=whole_number(1), default=5, metavar="N", help="repetitions of both engines; default 5"
    )
    options = parser.parse_args(argv)
    sides: tuple[int, ...] = SIDES
    batches: tuple[int, ...] = BATCHES
    steps, turns = STEPS, options.turns
    if options.smoke:
        sides, batches, steps, turns = SMOKE_SIDES, SMOKE_BATCHES, SMOKE_STEPS, 1

    cores.use(1)
    print(machine())
    figures: dict[str, float] = {}
    for side in sides:
        knots = side * side
        for name, share in SHARES.items():
            engines, start = _net(side, share)
            for batch in batches:
                state = _repeated(start, batch)
                cost = _measure(engines, state, steps, turns)
                grid, edges = (1e9 * seconds / (knots * batch) for seconds in cost)
                figures[f"grid_ns_per_knot_step_{name}_{knots}x{batch}"] = grid
                figures[f"edge_list_ns_per_knot_step_{name}_{knots}x{batch}"] = edges
                print(
                    f"{knots} knots, batch {batch}, {share:.0%} taut: grid {grid:.2f}, edge list {edges:.2f} ns per "
                    "knot, step",
                    flush=True,
                )
    small, middle, large = sides[0] ** 2, sides[1] ** 2, sides[-1] ** 2
    ratios = [cost / figures[name.replace("edge_list", "grid")] for name, cost in figures.items() if "edge" in name]
    conclude(
        "scale",
        {
            **{
                f"growth_of_cost_per_knot_{name}": figures[f"grid_ns_per_knot_step_{name}_{large}x{batches[0]}"]
                / figures[f"grid_ns_per_knot_step_{name}_{small}x{batches[0]}"]
                for name in SHARES
            },
            **{
                f"growth_beyond_first_cache_{name}": figures[f"grid_ns_per_knot_step_{name}_{large}x{batches[0]}"]
                / figures[f"grid_ns_per_knot_step_{name}_{middle}x{batches[0]}"]
                for name in SHARES
            },
            "edge_list_by_grid_most": max(ratios),
            "memory_peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
            **figures,
        },
    )
    return 0


def _net(side: int, share: float) -> tuple[tuple[Engine, Engine], State]:
    """Both engines of a square net of so many knots a side, all with one mesh length, and it flat and partly taut."""
    system = load_system(SYSTEM, {"net.square.rows": side, "net.square.columns": side})
    physics = replace(Settings.load(SYSTEM).physics, time_step_s=STEP_S)
    model = build_model(system, physics)
    random = np.random.default_rng(0)
    far = np.array([[0.0, 0.0, -1e4]])
    state = initial_state(model, system, physics, far, np.array([[0.0, 0.0, 0.0, 1.0]]), np.zeros((1, 3)))
    # Along a thread its two knots' shifts differ by the square root of two times as much.
    slack = statistics.NormalDist(0.0, math.sqrt(2.0) * SHIFT_M).inv_cdf(1.0 - share)
    flat = system.net.nodes * (1.0 - slack / float(model.arrays.rest[0]))
    flat[:, :2] += random.normal(0.0, SHIFT_M, (len(flat), 2))
    state.knot_pos[0] = flat.T
    state.mu_pos[0] = flat[model.arrays.mu_knot]
    return (GridEngine(model), EdgeListEngine(model)), state


def _repeated(state: State, batch: int) -> State:
    return State(**{f.name: np.repeat(getattr(state, f.name), batch, axis=0) for f in fields(state)})


def _measure(engines: tuple[Engine, Engine], state: State, steps: int, turns: int) -> tuple[float, float]:
    """CPU time of a step of the whole batch [s], of either engine."""
    best = [np.inf, np.inf]
    commands = Commands.of_thrust(np.zeros_like(state.mu_pos))
    for _ in range(turns):
        for number, engine in enumerate(engines):
            time_step = engine.model.numbers.time_step
            flown = state.copy()
            engine.advance(flown, commands, time_step)  # compiles or loads
            begin = time.process_time()
            engine.advance(flown, commands, steps * time_step)
            best[number] = min(best[number], (time.process_time() - begin) / steps)
    return best[0], best[1]


if __name__ == "__main__":
    sys.exit(main())
