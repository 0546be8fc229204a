"""How fast waves run along a thread."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tethernet_sim.validation.case import Case, Physics, Result, relative
from tethernet_sim.validation.stand import Stand, chain, net_system

LENGTH_M, SPRINGS = 20.0, 400
THREAD = {"material": "technora", "radius_m": 0.0005, "damping_ratio": 0.0}
STRAIN = 2e-3
STATIONS_M = (5.0, 15.0)
"""Unstretched distances from the end that is moved."""
SHARE = 1e-3
PULSE_M = 4.0
"""Length of the pulse: long compared with a spring, because a chain of springs disperses short waves."""


def _speed(physics: Physics, axis: int, speed: float, amplitude_m_s: float) -> tuple[float, dict[float, np.ndarray]]:
    """Move an end for a moment, and see when the pulse passes the stations.

    Args:
        physics: parameters to replace.
        axis: 0 along the thread, 2 across it.
        speed: expected, from which follow the step and the times [m/s].
        amplitude_m_s: largest speed of the end.

    Returns:
        Speed [m/s] by unstretched length; time [s] and node velocity [m/s] at each station, shape (2, S).
    """
    nodes = np.zeros((SPRINGS + 1, 3))
    nodes[:, 0] = np.linspace(0.0, LENGTH_M * (1.0 + STRAIN), SPRINGS + 1)
    mesh = LENGTH_M / SPRINGS
    system = net_system(nodes, chain(nodes), np.full(SPRINGS, mesh), thread=THREAD)
    stand = Stand(system, {"time_step_s": 2.5e-6, "contact_stiffness_n_m": 0.0, **physics}, held=(0, SPRINGS))
    numbers = [round(station / mesh) for station in STATIONS_M]
    times: list[float] = []
    seen: list[np.ndarray] = []

    def look(time_s: float, state: Any) -> None:
        times.append(time_s)
        seen.append(state.knot_vel[0, axis, numbers].copy())

    duration, end = PULSE_M / speed, (STATIONS_M[1] + PULSE_M) / speed
    pieces = 200
    for piece in range(pieces):
        stand.held_velocity[axis, 0] = amplitude_m_s * math.sin(math.pi * (piece + 0.5) / pieces) ** 2
        stand.run(duration / pieces, look)
    stand.held_velocity[:] = 0.0
    stand.run(end - duration, look)
    t, v = np.array(times), np.array(seen).T
    middles = [float((t * row).sum() / row.sum()) for row in v]
    measured = (numbers[1] - numbers[0]) * mesh / (middles[1] - middles[0])
    return measured, {station: np.stack([t, row]) for station, row in zip(STATIONS_M, v, strict=True)}


def run(physics: Physics) -> Result:
    """A pulse along the thread, and one across it."""
    material = net_system([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1.0], thread=THREAD).net.material
    rigidity, density = material.modulus_pa * material.area_m2, material.linear_density_kg_m
    along = math.sqrt(rigidity / density)
    # By unstretched length: rho u_tt = T / (1 + strain) u_XX.
    across = math.sqrt(rigidity * STRAIN / ((1.0 + STRAIN) * density))
    fast, seen_fast = _speed(physics, 0, along, 0.5)
    slow, seen_slow = _speed(physics, 2, across, 0.1)
    quantities = (
        relative("speed along, sqrt(E A / rho)", "m/s", fast, along, SHARE),
        relative("speed across, sqrt(T / rho)", "m/s", slow, across, SHARE),
    )

    def draw(figure: Any) -> None:
        panels = figure.subplots(2, 1)
        for panel, seen, title in ((panels[0], seen_fast, "along the thread"), (panels[1], seen_slow, "across it")):
            for station, (t, v) in seen.items():
                panel.plot(1e3 * t, v, label=f"at {station:g} m")
            panel.set(xlabel="time [ms]", ylabel="node velocity [m/s]", title=f"Pulse {title}")
            panel.grid(alpha=0.3)
            panel.legend()

    return Result(quantities, draw)


CASE = Case("waves along and across a taut thread", "wave equation", run)
