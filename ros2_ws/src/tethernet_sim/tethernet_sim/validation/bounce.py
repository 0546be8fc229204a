"""A knot that bounces off a flat: the damped contact, without friction and threads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tethernet_sim.settings import KNOTS
from tethernet_sim.validation.case import Case, Physics, Quantity, Result
from tethernet_sim.validation.stand import Stand, net_system

RATIOS = (0.0, 0.1, 0.3, 0.5, 0.7)
SPEED_M_S, MASS_KG, STEP_S = 0.5, 0.1, 1e-5
TOLERANCE = 0.002
_HALF_M = 1.0


def restitution(ratio: float) -> float:
    """Speed after by speed before for a linear spring and damper that only push (Schwager and Poeschel, Granular
    Matter 9, 2007): the contact ends when the force does, before the way does.

    Args:
        ratio: damping ratio zeta, from 0 to below 1.
    """
    damped = math.sqrt(1.0 - ratio**2)
    return math.exp(-ratio / damped * math.atan2(2.0 * ratio * damped, 2.0 * ratio**2 - 1.0))


def bounce(ratio: float, physics: Physics) -> float:
    """Let a knot fall on a box at SPEED_M_S; its speed after by that before."""
    # The law of one contact: where threads touch too, a knot shares it with them.
    parameters = {"time_step_s": STEP_S, "contact": KNOTS, **physics, "contact_damping_ratio": ratio}
    nodes = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]])
    system = net_system(
        nodes, [[0, 1]], [9.0],
        thread={"material": "technora", "radius_m": 0.0001},
        masses={0: MASS_KG},
        shape={"kind": "box", "size_m": [2.0, 2.0, 2.0 * _HALF_M]},
    )  # fmt: skip
    stand = Stand(system, parameters, debris_position=(0.0, 0.0, 0.0))
    radius = stand.physics.knot_radius_m
    begin = _HALF_M + radius + 1e-4
    stand.position[:] = [[0.0, 0.0], [0.0, 0.0], [begin, begin + 3.0]]
    stand.velocity[2, 0] = -SPEED_M_S
    contact_s = math.pi / math.sqrt(stand.physics.contact_stiffness_n_m / stand.masses[0])
    stand.coast(3.0 * contact_s + 4e-4 / SPEED_M_S)
    return float(stand.velocity[2, 0]) / SPEED_M_S


def run(physics: Physics) -> Result:
    """For several damping ratios."""
    measured = {ratio: bounce(ratio, physics) for ratio in RATIOS}
    quantities = tuple(
        Quantity(f"restitution, damping ratio {ratio:g}", "-", value, restitution(ratio), TOLERANCE)
        for ratio, value in measured.items()
    )

    def draw(figure: Any) -> None:
        panel = figure.add_subplot()
        ratios = np.linspace(0.0, 0.9, 91)
        panel.plot(ratios, [restitution(float(ratio)) for ratio in ratios], label="linear spring and damper, push only")
        panel.plot(list(measured), list(measured.values()), "o", label="engine")
        panel.set(xlabel="damping ratio", ylabel="speed after / before", title="A knot bounces off a flat")
        panel.grid(alpha=0.3)
        panel.legend()

    return Result(quantities, draw)


CASE = Case("a knot bounces off a flat", "damped oscillator that only pushes, in closed form", run)
