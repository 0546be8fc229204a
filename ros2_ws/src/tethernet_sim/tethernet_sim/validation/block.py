"""A block on a plane: friction that holds, that gives way, that brakes."""

from __future__ import annotations

from typing import Any

import numpy as np

from tethernet_sim.settings import KNOTS
from tethernet_sim.state import DEBRIS, State
from tethernet_sim.validation.case import Case, Physics, Quantity, Result, relative
from tethernet_sim.validation.stand import Stand, net_system

FRICTION, GRAVITY_M_S2, MASS_KG, STEP_S = 0.3, 9.81, 1.0, 5e-5
HOLDING, SLIDING = 0.95, 1.5
"""Pull by what friction can bear."""
RAMP_S = 0.2
"""In which a pull grows to its size [s]."""
SPEED_M_S = 1.0
SHARE = 2e-3
_HALF_M = 2.0
_PIECES = 100


def _block(physics: Physics, pull_n: float, speed_m_s: float, duration_s: float) -> tuple[Stand, np.ndarray]:
    """Pull a block along x, or push it off; stand and (time, way, speed), shape (3, S)."""
    system = net_system(
        [[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]], [[0, 1]], [9.0],
        thread={"material": "technora", "radius_m": 0.0001},
        masses={0: MASS_KG},
        shape={"kind": "box", "size_m": [20.0, 4.0, 2.0 * _HALF_M]},
    )  # fmt: skip
    # The law of one contact: where threads touch too, a knot shares it with them.
    parameters = {"time_step_s": STEP_S, "friction_coefficient": FRICTION, "contact": KNOTS, **physics}
    stand = Stand(
        system, parameters, held=(1,), gravity=(0.0, 0.0, -GRAVITY_M_S2), debris_position=(0.0, 0.0, 0.0)
    )  # fmt: skip
    depth = stand.masses[0] * GRAVITY_M_S2 / stand.physics.contact_stiffness_n_m
    height = _HALF_M + stand.physics.knot_radius_m
    stand.position[:] = [[0.0, 0.0], [0.0, 0.0], [height - depth, height + 3.0]]
    stand.velocity[0, 0] = speed_m_s
    seen: list[tuple[float, float, float]] = []

    def look(time_s: float, state: State) -> None:
        plane = float(state.bodies[0, DEBRIS, 3])  # 1e7 kg are not for ever at rest
        seen.append((time_s, float(state.knot_pos[0, 0, 0]), float(state.knot_vel[0, 0, 0]) - plane))

    # Pulled gently: the jerk of a sudden pull is more than friction can bear.
    for piece in range(_PIECES if pull_n else 0):
        stand.force[0, 0] = pull_n * (piece + 1) / _PIECES
        stand.run(RAMP_S / _PIECES, look)
    stand.run(duration_s, look)
    return stand, np.array(seen).T


def run(physics: Physics) -> Result:
    """Pull too weakly, pull hard, push off."""
    coefficient = float(physics.get("friction_coefficient", FRICTION))
    stand, _ = _block(physics, 0.0, 0.0, STEP_S)
    weight = float(stand.masses[0]) * GRAVITY_M_S2
    limit = coefficient * weight
    stand, held = _block(physics, HOLDING * limit, 0.0, 1.0)
    stretch = HOLDING * limit / stand.physics.contact_stiffness_n_m
    _, slid = _block(physics, SLIDING * limit, 0.0, 1.0)
    stop_s = SPEED_M_S / (coefficient * GRAVITY_M_S2)
    stop_m = 0.5 * SPEED_M_S * stop_s
    _, braked = _block(physics, 0.0, SPEED_M_S, 1.5 * stop_s)
    half = len(slid[0]) // 2
    acceleration = (slid[2, -1] - slid[2, half]) / (slid[0, -1] - slid[0, half])
    braking = braked[0] < 0.8 * stop_s
    deceleration = -np.polyfit(braked[0, braking], braked[2, braking], 1)[0]
    quantities = (
        relative(f"way of the bristle at {HOLDING:g} mu N", "m", held[1, -1], stretch, SHARE),
        Quantity("speed then, after 1 s", "m/s", float(held[2, -1]), 0.0, 1e-7),
        relative(
            f"acceleration at {SLIDING:g} mu N", "m/s^2", acceleration,
            (SLIDING - 1.0) * coefficient * GRAVITY_M_S2, SHARE,
        ),
        relative("deceleration without pull", "m/s^2", deceleration, coefficient * GRAVITY_M_S2, SHARE),
        # The contact springs back by mu N / k when it stops.
        Quantity(
            "way until it stops", "m", float(braked[1, -1]), stop_m,
            SHARE * stop_m + limit / stand.physics.contact_stiffness_n_m,
        ),
    )  # fmt: skip

    def draw(figure: Any) -> None:
        panel = figure.add_subplot()
        panel.plot(held[0], held[2], label=f"pulled with {HOLDING:g} mu N")
        panel.plot(slid[0], slid[2], label=f"pulled with {SLIDING:g} mu N")
        panel.plot(braked[0], braked[2], label=f"pushed off with {SPEED_M_S:g} m/s")
        # It gives way when the growing pull passes mu N.
        away = np.linspace(RAMP_S / SLIDING, RAMP_S, 20)
        rate = coefficient * GRAVITY_M_S2 * SLIDING / RAMP_S
        speed = 0.5 * rate * (away - away[0]) ** 2
        t = np.append(away, RAMP_S + 1.0)
        panel.plot(t, np.append(speed, speed[-1] + (SLIDING - 1.0) * coefficient * GRAVITY_M_S2), "k:", label="Coulomb")
        t = np.array([0.0, stop_s])
        panel.plot(t, SPEED_M_S - coefficient * GRAVITY_M_S2 * t, "k:")
        panel.set(xlabel="time [s]", ylabel="speed [m/s]", title=f"A block on a plane, mu = {coefficient:g}")
        panel.grid(alpha=0.3)
        panel.legend()

    return Result(quantities, draw)


CASE = Case("a block on a plane: friction holds, gives way, brakes", "Coulomb's law", run)
