"""A free body without symmetry: its rotation against Jacobi's elliptic functions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tethernet_core.rotation import matrix
from tethernet_sim.debris import body_rate, inertia_tensor
from tethernet_sim.state import ATTITUDE, DEBRIS, MOMENTUM
from tethernet_sim.validation.case import Case, Physics, Quantity, Result, relative
from tethernet_sim.validation.stand import Stand, net_system

SIZE_M, MASS_KG = (2.0, 3.0, 6.0), 4000.0
RATE_RAD_S = (0.06, 0.0, 0.12)
"""At the start, about the axes of the largest, the middle and the smallest moment."""
PERIOD_S, TICKS = 0.05, 8000
SHARE = 1e-6


def exact_rates(moments: np.ndarray, rate: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, float]:
    """Euler's free body (Landau and Lifshitz, Mechanics, section 37).

    Args:
        moments: principal moments of inertia, largest first [kg m^2], shape (3,).
        rate: about these axes at time 0 [rad/s], shape (3,); the middle one is 0, the others are positive.
        times: [s], shape (T,).

    Returns:
        Rates [rad/s], shape (3, T), and their period [s].
    """
    from scipy.special import ellipj, ellipk

    c, b, a = moments  # a < b < c
    twice_energy = float((moments * rate**2).sum())
    squared = float(((moments * rate) ** 2).sum())
    if squared > twice_energy * b:  # round the axis of the largest moment
        frequency = math.sqrt((c - b) * (squared - twice_energy * a) / (a * b * c))
        modulus = (b - a) * (twice_energy * c - squared) / ((c - b) * (squared - twice_energy * a))
        most = [
            math.sqrt((squared - twice_energy * a) / (c * (c - a))),
            math.sqrt((twice_energy * c - squared) / (b * (c - b))),
            math.sqrt((twice_energy * c - squared) / (a * (c - a))),
        ]
        shapes = (2, 0, 1)  # dn, sn, cn
    else:
        frequency = math.sqrt((b - a) * (twice_energy * c - squared) / (a * b * c))
        modulus = (c - b) * (squared - twice_energy * a) / ((b - a) * (twice_energy * c - squared))
        most = [
            math.sqrt((squared - twice_energy * a) / (c * (c - a))),
            math.sqrt((squared - twice_energy * a) / (b * (b - a))),
            math.sqrt((twice_energy * c - squared) / (a * (c - a))),
        ]
        shapes = (1, 0, 2)
    functions = ellipj(frequency * times, modulus)
    rates = np.stack([size * functions[shape] for size, shape in zip(most, shapes, strict=True)])
    return rates, 4.0 * float(ellipk(modulus)) / frequency


def run(physics: Physics) -> Result:
    """Fly it for some of its periods."""
    system = net_system(
        [[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]], [[0, 1]], [1.0],
        thread={"material": "technora", "radius_m": 0.0005},
        shape={"kind": "box", "size_m": list(SIZE_M)}, mass_kg=MASS_KG,
    )  # fmt: skip
    body = Stand(system, {"time_step_s": 1e-5, **physics}).model.debris
    moments = np.diag(inertia_tensor(body))
    order = np.argsort(-moments)  # largest first
    rate = np.zeros(3)
    rate[order] = RATE_RAD_S
    stand = Stand(system, {"time_step_s": 1e-5, **physics}, debris_rate=rate.tolist())
    row = stand.state.bodies[0, DEBRIS]
    momentum = row[MOMENTUM].copy()
    times, rates, energies = [0.0], [rate], []
    for _ in range(TICKS):
        stand.coast(PERIOD_S)
        times.append(stand.time_s)
        own = matrix(row[ATTITUDE]).T @ row[MOMENTUM]
        rates.append(body_rate(body, own))
        energies.append(0.5 * float(own @ rates[-1]))
    t, got = np.array(times), np.array(rates).T[order]
    expected, period = exact_rates(moments[order], rate[order], t)
    # sn may run either way round: the sign of the middle rate follows from the handedness of the axes.
    if float((got[1] * expected[1]).sum()) < 0.0:
        expected[1] = -expected[1]
    start = 0.5 * float((moments * rate**2).sum())
    crossings = np.flatnonzero((got[1, 1:-1] < 0.0) & (got[1, 2:] >= 0.0)) + 1
    passed = t[crossings] - got[1, crossings] * PERIOD_S / (got[1, crossings + 1] - got[1, crossings])
    measured_period = float(np.diff(passed).mean()) if len(passed) > 1 else math.nan
    top = float(np.abs(expected).max())
    off = float(np.abs(got - expected).max())
    energy = float(np.abs(np.array(energies) / start - 1.0).max())
    turned = float(np.abs(row[MOMENTUM] - momentum).max() / np.linalg.norm(momentum))
    quantities = (
        relative("period", "s", measured_period, period, SHARE),
        Quantity("largest difference of a rate, by the largest rate", "-", off / top, 0.0, SHARE),
        Quantity("change of the energy, by itself", "-", energy, 0.0, 1e-9),
        Quantity("change of the angular momentum, by itself", "-", turned, 0.0, 1e-15),
    )

    def draw(figure: Any) -> None:
        panels = figure.subplots(2, 1, sharex=True)
        shown = t <= 2.5 * period
        for axis, name in enumerate(("largest", "middle", "smallest")):
            panels[0].plot(t[shown], got[axis, shown], label=f"{name} moment")
            panels[0].plot(t[shown][::80], expected[axis, shown][::80], "k.", markersize=3)
            panels[1].plot(t[shown], got[axis, shown] - expected[axis, shown])
        panels[0].set(ylabel="rate [rad/s]", title="A free box; dots: elliptic functions")
        panels[0].set_ylim(top=0.17)
        panels[0].legend(ncols=3, loc="upper center")
        panels[1].set(xlabel="time [s]", ylabel="difference [rad/s]")
        for panel in panels:
            panel.grid(alpha=0.3)

    return Result(quantities, draw)


CASE = Case("free rotation of a body without symmetry", "Jacobi's elliptic functions", run)
