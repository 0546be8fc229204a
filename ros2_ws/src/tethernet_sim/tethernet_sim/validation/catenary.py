"""A thread that hangs between two points: the elastic catenary."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from tethernet_sim.validation.case import Case, Physics, Result, relative
from tethernet_sim.validation.stand import Stand, chain, net_system

SPAN_M, LENGTH_M, SPRINGS = 2.0, 2.2, 88
THREAD = {"modulus_pa": 1e6, "density_kg_m3": 1000.0, "radius_m": 0.01, "damping_ratio": 0.0}
GRAVITY_M_S2 = 9.81
STEP_S, DRAG_1_S, REST_AFTER_S = 2e-4, 5.0, 5.0
SHARE = 1e-3


class Catenary(NamedTuple):
    """An elastic catenary between supports of the same height (Irvine, Cable Structures, 1981, section 1.3)."""

    horizontal: float
    """Horizontal tension [N]."""
    weight: float
    """Of the thread per unstretched length [N/m]."""
    length: float
    """Unstretched [m]."""
    rigidity: float
    """E A [N]."""

    def place(self, material: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x and z [m] of points of the thread, by their unstretched distance from the first support [m]."""
        h, w, ea = self.horizontal, self.weight, self.rigidity
        v = 0.5 * w * self.length - w * material  # vertical tension
        v0 = 0.5 * w * self.length
        x = h * material / ea + h / w * (math.asinh(v0 / h) - np.arcsinh(v / h))
        z = -((v0**2 - v**2) / (2.0 * ea * w) + (math.hypot(h, v0) - np.hypot(h, v)) / w)
        return x, z

    @property
    def largest_tension(self) -> float:
        """At the supports [N]."""
        return math.hypot(self.horizontal, 0.5 * self.weight * self.length)


def elastic_catenary(span: float, length: float, weight: float, rigidity: float) -> Catenary:
    """The catenary of a thread whose ends are ``span`` [m] apart; ``weight`` [N/m], ``rigidity`` E A [N]."""
    from scipy.optimize import brentq

    def gap(horizontal: float) -> float:
        x, _ = Catenary(horizontal, weight, length, rigidity).place(np.array([length]))
        return float(x[0]) - span

    horizontal = float(brentq(gap, 1e-6 * weight * length, 1e3 * weight * length, xtol=1e-14, rtol=1e-13))
    return Catenary(horizontal, weight, length, rigidity)


def run(physics: Physics) -> Result:
    """Let the thread come to rest."""
    share = np.linspace(0.0, 1.0, SPRINGS + 1)
    # Laid out in a V of its own length, so that it is neither taut nor slack by much.
    depth = 0.5 * math.sqrt(LENGTH_M**2 - SPAN_M**2)
    nodes = np.stack([share * SPAN_M, np.zeros(SPRINGS + 1), -2.0 * depth * np.minimum(share, 1.0 - share)], axis=1)
    system = net_system(nodes, chain(nodes), np.full(SPRINGS, LENGTH_M / SPRINGS), thread=THREAD)
    stand = Stand(
        system,
        {"time_step_s": STEP_S, **physics},
        held=(0, SPRINGS),
        gravity=(0.0, 0.0, -GRAVITY_M_S2),
        drag_1_s=DRAG_1_S,
    )
    stand.run(REST_AFTER_S)
    material = system.net.material
    exact = elastic_catenary(
        SPAN_M, LENGTH_M, material.linear_density_kg_m * GRAVITY_M_S2, material.modulus_pa * material.area_m2
    )
    x, z = exact.place(share * LENGTH_M)
    got = stand.position.copy()
    # A support bears the half spring next to it too, which hangs on no node that can move.
    weight = stand.masses[0] * GRAVITY_M_S2
    pull = stand.pulls()[:, 0]
    support = math.hypot(pull[0], pull[2] - weight)
    middle = SPRINGS // 2
    away = float(np.hypot(got[0] - x, got[2] - z).max())
    quantities = (
        relative("sag in the middle", "m", -got[2, middle], -z[middle], SHARE),
        relative("horizontal tension", "N", pull[0], exact.horizontal, SHARE),
        relative("tension at the supports", "N", support, exact.largest_tension, SHARE),
        relative("sag less the largest distance of a node", "m", -z[middle] - away, -z[middle], SHARE),
    )

    def draw(figure: Any) -> None:
        panel = figure.add_subplot()
        panel.plot(x, z, label="elastic catenary")
        panel.plot(got[0], got[2], ".", markersize=5, label=f"engine, {SPRINGS} springs")
        panel.set(xlabel="x [m]", ylabel="z [m]", title="A thread that hangs between two points", aspect="equal")
        panel.grid(alpha=0.3)
        panel.legend()

    return Result(quantities, draw)


CASE = Case("thread between two points under its weight", "elastic catenary, in closed form", run)
