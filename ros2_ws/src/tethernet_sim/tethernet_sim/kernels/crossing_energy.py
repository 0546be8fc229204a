"""What the contact of net with net does in one step: see :mod:`~tethernet_sim.kernels.energy`, of which it is a part.

From the law of :mod:`~tethernet_sim.kernels.crossing_law` once more, apart from the kernels that fly, with vectors.
"""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels.crossing_law import COLLINEAR
from tethernet_sim.kernels.options import entry_point, ieee

WORK, NET_CONTACT = 0, 11
"""Rows of the ledger [J]: the work of all forces; what dampers, friction and pairs that part while they touch take out
in the contact of net with net."""

ROUNDING_M = 1e-12
"""Depth of a contact that is none."""


@ieee
def _gap(threads, row, x):
    """Of one touching pair: knots (4,), lever rule (4,), from the first thread to the second (3,) [m], common normal on
    its remembered side (3,).
    """
    a, b = int(row[0]), int(row[1])
    ends = np.array([threads[a, 0], threads[a, 1], threads[b, 0], threads[b, 1]])
    u, v, w = x[:, ends[1]] - x[:, ends[0]], x[:, ends[3]] - x[:, ends[2]], x[:, ends[0]] - x[:, ends[2]]
    across = np.cross(u, v)
    area = max(np.dot(across, across), 1e-300)
    s = np.dot(np.cross(-w, v), across) / area
    t = np.dot(np.cross(-w, u), across) / area
    normal = across / math.sqrt(area)
    if np.dot(normal, row[2:5]) < 0.0:
        normal = -normal
    return ends, np.array([s - 1.0, -s, 1.0 - t, t]), t * v - w - s * u, normal


@ieee
def _of_ends(shares, ends, values):
    total = np.zeros(3)
    for end in range(4):
        total += shares[end] * values[:, ends[end]]
    return total


@ieee
def _turning(mass, ends, x, v):
    """Angular rate of four ends as one rigid body that has their angular momentum [rad/s]; NaN along one line."""
    total, center, mean = 0.0, np.zeros(3), np.zeros(3)
    for e in ends:
        total += mass[e]
        center += mass[e] * x[:, e]
        mean += mass[e] * v[:, e]
    center, mean = center / total, mean / total
    inertia, momentum = np.zeros((3, 3)), np.zeros(3)
    for e in ends:
        r = x[:, e] - center
        inertia += mass[e] * (np.dot(r, r) * np.eye(3) - np.outer(r, r))
        momentum += mass[e] * np.cross(r, v[:, e] - mean)
    a, b, c = inertia[0], inertia[1], inertia[2]
    determinant = np.dot(a, np.cross(b, c))
    if determinant <= COLLINEAR * (np.trace(inertia) / 3.0) ** 3:
        return np.full(3, np.nan)
    return (momentum[0] * np.cross(b, c) + momentum[1] * np.cross(c, a) + momentum[2] * np.cross(a, b)) / determinant


@ieee
def _bristle(numbers, row):
    return 0.5 * numbers.crossing_grip * np.dot(row[6:9], row[6:9])


@ieee
def _spring(numbers, threads, row, x):
    """Energy in the normal spring [J]."""
    _, _, gap, normal = _gap(threads, row, x)
    depth = max(row[5] - np.dot(normal, gap), 0.0)
    return 0.5 * numbers.crossing_stiffness * depth * depth


@entry_point
def stored(numbers, arrays, knots, rows):
    """Energy in the contacts of net with net [J]: ``rows`` of touching pairs as in State.crossed, places (3, N) [m]."""
    total = 0.0
    for r in range(len(rows)):
        total += _spring(numbers, arrays.crossing_threads.ends, rows[r], knots) + _bristle(numbers, rows[r])
    return total


@ieee
def book(ledger, numbers, arrays, x, vels, before, after):
    """Add what one step did to the ``ledger``.

    Args:
        ledger: updated.
        numbers, arrays: constants of the model.
        x: places of the knots before the step [m], (3, N).
        vels: velocities before and after [m/s], (2, 3, N).
        before: touching pairs, as they remembered the step before, (., RECORD).
        after: those that touched in this step, likewise.
    """
    h, threads = numbers.time_step, arrays.crossing_threads.ends
    lost = 0.0
    for r in range(len(before)):
        lost += _spring(numbers, threads, before[r], x) + _bristle(numbers, before[r])
    for r in range(len(after)):
        row = after[r]
        ends, shares, gap, normal = _gap(threads, row, x)
        lost -= _spring(numbers, threads, row, x) + _bristle(numbers, row)
        depth = row[5] - np.dot(normal, gap)
        if depth <= ROUNDING_M:  # it touches from here on, or parts
            continue
        rate = _of_ends(shares, ends, vels[0])
        mean = 0.5 * (rate + _of_ends(shares, ends, vels[1]))
        spring = numbers.crossing_stiffness * depth
        pressing = max(
            spring - numbers.crossing_stiffness * numbers.crossing_viscosity * np.dot(rate, normal), 0.0
        )  # fmt: skip
        ledger[WORK] += h * pressing * np.dot(mean, normal)
        lost -= h * (pressing - spring) * np.dot(mean, normal)
        if pressing == 0.0 or numbers.crossing_grip == 0.0:
            continue
        turning = _turning(arrays.knot_mass, ends, x, vels[0])
        later = _turning(arrays.knot_mass, ends, x, vels[1])
        if math.isnan(turning[0]):
            continue
        slip, way = rate - np.cross(turning, gap), mean - np.cross(0.5 * (turning + later), gap)
        slip, way = slip - np.dot(slip, normal) * normal, way - np.dot(way, normal) * normal
        was = np.zeros(3)
        for other in range(len(before)):
            if before[other, 0] == row[0] and before[other, 1] == row[1]:
                was = before[other, 6:9]
        was = was + h * np.cross(turning, was)
        raw = was - np.dot(was, normal) * normal + h * slip
        limit, grip = numbers.friction * pressing, numbers.crossing_grip
        force = -grip * raw - grip * numbers.crossing_viscosity * slip
        force = force * min(1.0, limit / max(math.sqrt(np.dot(force, force)), 1e-300))
        ledger[WORK] += h * np.dot(force, way)
        # What the bristle gained is counted with what all remember; the knots gave it, and what is lost.
        lost -= h * np.dot(force, way)
    ledger[NET_CONTACT] += lost
