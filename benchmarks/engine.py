"""CPU time and error of an 8-MU deployment against MuJoCo, in the same run: ``python -m benchmarks.engine [--smoke]``.

Both codes fly the same deployment on one core, taking turns, because a shared machine is not equally fast at all times;
the ratio is the median over the turns. CPU time of the process counts, of the physics' steps alone. Errors are the
largest distances over all control ticks from our engine at an eighth of its step. A slack net is chaotic: any change,
be it of the step or of the compiler, gives other figures of the same size.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from typing import Any

from tethernet_core.subcommand import whole_number
from tethernet_sim import cores

from .deployment import DURATION_S, Deployment, fly_engine, fly_mujoco
from .figures import conclude, machine

REFERENCE_STEP_S = 1.25e-5
MUJOCO: dict[str, Any] = {"time_step_s": 5e-3, "integrator": "discrete", "threads": "actuator"}
"""MuJoCo's fastest usable route: its largest step that is still accurate."""
SMOKE_S = 1.0


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.engine", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help=f"only {SMOKE_S:g} s of deployment, one turn")
    parser.add_argument(
        "--turns", type=whole_number(1), default=5, metavar="N", help="repetitions of both codes; default 5"
    )
    options = parser.parse_args(argv)
    duration, turns = (SMOKE_S, 1) if options.smoke else (DURATION_S, options.turns)

    cores.use(1)
    print(machine())
    print(f"8 MUs, {duration:g} s of deployment, no noise, one core, {turns} turns")
    fly_engine(duration_s=0.2)  # compiles or loads
    ours, peers, ratios = [], [], []
    for turn in range(turns):
        before = fly_engine(duration_s=duration)
        peer = fly_mujoco(duration_s=duration, **MUJOCO)
        after = fly_engine(duration_s=duration)
        ours += [before, after]
        peers.append(peer)
        ratios.append(2.0 * peer.cpu_s / (before.cpu_s + after.cpu_s))
        print(
            f"turn {turn + 1}: engine {_cost(before):.4f}, MuJoCo {_cost(peer):.4f}, engine {_cost(after):.4f} "
            f"CPU s per simulated s: {ratios[-1]:.1f} times less",
            flush=True,
        )
    reference = fly_engine(duration_s=duration, time_step_s=REFERENCE_STEP_S)
    mu_error, center_error = ours[0].errors(reference)
    mujoco_mu_error, mujoco_center_error = peers[0].errors(reference)
    print(
        f"against {REFERENCE_STEP_S:g} s: engine's MUs {mu_error * 1e3:.2f} mm, net centre {center_error:.3f} m; "
        f"MuJoCo's {mujoco_mu_error * 1e3:.2f} mm, {mujoco_center_error:.3f} m"
    )
    conclude(
        "engine",
        {
            "cpu_ratio_mujoco": statistics.median(ratios),
            "mu_max_error_mm": mu_error * 1e3,
            "com_max_error_m": center_error,
            "cpu_s_per_sim_s": statistics.median(map(_cost, ours)),
            "mujoco_cpu_s_per_sim_s": statistics.median(map(_cost, peers)),
            "mujoco_mu_max_error_mm": mujoco_mu_error * 1e3,
            "mujoco_com_max_error_m": mujoco_center_error,
            "simulated_s": duration,
        },
    )
    return 0


def _cost(flown: Deployment) -> float:
    return flown.cpu_s / flown.simulated_s


if __name__ == "__main__":
    sys.exit(main())
