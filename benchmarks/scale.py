"""CPU time per knot and step of square nets from 529 to 8,281 knots: ``python -m benchmarks.scale [--smoke]``.

Each net is spread flat and set moving, so that some of its threads are taut at any time, as in a flight, far from
the debris. Grid and edge list fly the same states in turn on one core, in batches of 1 to 64; CPU time of the process
counts, of the physics' steps alone, and the fastest of the turns, because a shared machine only ever takes time away.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from dataclasses import fields

import numpy as np

from tethernet_core.system import load_system
from tethernet_sim import cores
from tethernet_sim.engine import Commands, EdgeListEngine, Engine, GridEngine
from tethernet_sim.fly import Settings
from tethernet_sim.model import build_model
from tethernet_sim.state import State, initial_state

from .figures import conclude, machine

SIDES, BATCHES = (23, 45, 91), (1, 8, 64)
SPEED_M_S = 0.2
"""Standard deviation of the knots' velocities at the beginning."""
STEPS = 500
"""Of one measurement: as many for every size and batch, because the share of taut threads changes with time."""
SMOKE_SIDES, SMOKE_BATCHES, SMOKE_STEPS = (23, 45), (1, 2), 100
SYSTEM = "zenit_8mu"


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scale", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="two sizes, two batches, one short turn")
    parser.add_argument("--turns", type=int, default=5, metavar="N", help="repetitions of both engines; default 5")
    options = parser.parse_args(argv)
    if options.turns < 1:
        parser.error(f"--turns {options.turns}: allowed: 1 or more")
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
        engines, start = _net(side)
        for batch in batches:
            state = _repeated(start, batch)
            cost = _measure(engines, state, steps, turns)
            grid, edges = (1e9 * seconds / (knots * batch) for seconds in cost)
            figures[f"grid_ns_per_knot_step_{knots}x{batch}"] = grid
            figures[f"edge_list_ns_per_knot_step_{knots}x{batch}"] = edges
            print(f"{knots} knots, batch {batch}: grid {grid:.2f}, edge list {edges:.2f} ns per knot, step", flush=True)
    small, large, one = sides[0] ** 2, sides[-1] ** 2, batches[0]
    conclude(
        "scale",
        {
            "growth_of_cost_per_knot": figures[f"grid_ns_per_knot_step_{large}x{one}"]
            / figures[f"grid_ns_per_knot_step_{small}x{one}"],
            "edge_list_by_grid_most": max(
                figures[f"edge_list_ns_per_knot_step_{s * s}x{b}"] / figures[f"grid_ns_per_knot_step_{s * s}x{b}"]
                for s in sides
                for b in batches
            ),
            "memory_peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
            **figures,
        },
    )
    return 0


def _net(side: int) -> tuple[tuple[Engine, Engine], State]:
    """Both engines of a square net of so many knots a side, all with one mesh length, and it flat and moving."""
    system = load_system(SYSTEM, {"net.square.rows": side, "net.square.columns": side})
    # The step is not checked: larger nets have the same threads, and only some hundred steps are flown.
    physics = Settings.load(SYSTEM).physics
    model = build_model(system, physics)
    random = np.random.default_rng(0)
    far = np.array([[0.0, 0.0, -1e4]])
    state = initial_state(model, system, physics, far, np.array([[0.0, 0.0, 0.0, 1.0]]), np.zeros((1, 3)))
    state.knot_pos[0] = system.net.nodes.T
    state.mu_pos[0] = system.net.nodes[model.arrays.mu_knot]
    state.knot_vel[:] = random.normal(0.0, SPEED_M_S, state.knot_vel.shape)
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
