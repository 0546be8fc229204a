"""What captures owe to friction: ``python -m benchmarks.friction [--system NAME] [--missions N] [--friction MU ...]``.

For each coefficient of friction the same missions: threads touch, nominal aiming points, random attitudes, a tow after
the verdict. Slip is how far the net goes over the debris in the tow: the mean way, in the debris' frame, of the knots
that were near its surface when the tow began.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from tethernet_core.rotation import inverse, rotate
from tethernet_core.subcommand import whole_number
from tethernet_sim import cores
from tethernet_sim.debris import surface_distance
from tethernet_sim.fly import Settings, fly
from tethernet_sim.scenario import Outcome, Scenario
from tethernet_sim.state import ATTITUDE, DEBRIS, POSITION
from tethernet_sim.world import World

from .figures import conclude

FRICTION = (0.0, 0.1, 0.3, 0.6, 1.0)
HOLD: dict[str, Any] = {"hold_s": 60.0, "tow_n": 20.0}
SMOKE: dict[str, Any] = {
    "trigger_distance_m": 50.0, "capture_duration_s": 1.0, "hold_s": 0.5, "tow_n": 20.0,
}  # fmt: skip
NEAR_M = 0.1
"""Knots nearer to the surface count as lying on it."""


@dataclass
class Slip:
    """Watches one mission; an observer of fly."""

    begun: np.ndarray | None = None
    ended: np.ndarray | None = None
    near: np.ndarray | None = None

    def __call__(self, _stamp_ns: int, world: World, _flying: np.ndarray) -> None:
        """Look at a control tick of the tow."""
        if not world.chaser_force[0].any():
            return
        debris = world.state.bodies[0, DEBRIS]
        self.ended = rotate(inverse(debris[ATTITUDE])[None], world.state.knot_pos[0].T - debris[POSITION])
        if self.begun is None:
            self.begun = self.ended
            self.near = surface_distance(world.model.debris, self.begun) < NEAR_M

    @property
    def way_m(self) -> float:
        """Mean way of the knots that lay on the debris [m]; NaN where none did."""
        if self.begun is None or self.ended is None or self.near is None or not self.near.any():
            return math.nan
        return float(np.linalg.norm(self.ended - self.begun, axis=1)[self.near].mean())


def attitude(seed: int) -> tuple[float, float, float, float]:
    """A random attitude."""
    q = np.random.default_rng(seed).normal(size=4)
    x, y, z, w = q / np.linalg.norm(q)
    return float(x), float(y), float(z), float(w)


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.friction", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="one mission of a second a row")
    parser.add_argument("--system", default="zenit_8mu", metavar="NAME", help="what is flown; default zenit_8mu")
    parser.add_argument(
        "--missions", type=whole_number(1), default=20, metavar="N", help="missions of each row; default 20"
    )
    parser.add_argument("--friction", type=float, nargs="+", default=FRICTION, metavar="MU", help="coefficients")
    options = parser.parse_args(argv)
    missions = 1 if options.smoke else options.missions
    cores.use(1)
    figures: dict[str, Any] = {"system": options.system, "missions": missions}
    print("| friction | captured | held | pairs | CQI | slip in the tow, m: median (most) |\n|---|---|---|---|---|---|")
    for friction in options.friction:
        settings = Settings.load(
            options.system, physics={"contact": "threads", "friction_coefficient": friction},
            mission=SMOKE if options.smoke else HOLD,
        )  # fmt: skip
        outcomes: list[Outcome] = []
        slips: list[float] = []
        for seed in range(missions):
            slip = Slip()
            outcomes.append(fly(Scenario(options.system, debris_attitude=attitude(seed), seed=seed), settings, slip))
            slips.append(slip.way_m)
        known = [way for way in slips if not math.isnan(way)]
        quality = [outcome.cqi for outcome in outcomes if not math.isnan(outcome.cqi)]
        row = {
            "captured": sum(outcome.captured for outcome in outcomes),
            "held": sum(outcome.held is True for outcome in outcomes),
            "pairs": statistics.fmean(outcome.locked_pairs for outcome in outcomes),
            "cqi": statistics.fmean(quality) if quality else math.nan,
            "slip_m": statistics.median(known) if known else math.nan,
            "slip_most_m": max(known) if known else math.nan,
        }
        figures |= {f"{name}_{friction:g}": value for name, value in row.items()}
        print(
            f"| {friction:g} | {row['captured']} of {missions} | {row['held']} of {missions} | {row['pairs']:.2f} | "
            f"{row['cqi']:.2f} | {row['slip_m']:.2f} ({row['slip_most_m']:.2f}) |",
            flush=True,
        )
    conclude("friction", figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
