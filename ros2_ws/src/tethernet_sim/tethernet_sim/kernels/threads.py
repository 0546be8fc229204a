"""Tension of the net's threads.

Most threads are slack at any time (2 to 6 % are taut until the net is flat), so a step first compares squared lengths
for all of
them, which vectorises well, and evaluates the law for the taut ones only. When many are taut, the law is evaluated
for all, vectorised.
"""

from __future__ import annotations

import math

from tethernet_control.layout import KNOT_ROWS

from ..model import KNOTS
from .options import leaf

ROW_THREADS = KNOTS - 1
"""Threads along rows, numbered by their first knot; the entries where a row ends have no thread."""
COLUMN_THREADS = KNOTS - KNOT_ROWS
"""Threads along columns, numbered by their first knot."""
FLAGS = 8 * ((ROW_THREADS + COLUMN_THREADS + 7) // 8)
"""Flags of all threads, rows first, padded so that eight can be looked at in one."""
DENSE_FROM = 224
"""Taut threads from which evaluating all of them, vectorised, is faster (measured)."""
DENSE_STEPS = 10
"""Steps for which all are evaluated before they are counted again."""


@leaf
def flag_taut(x, y, z, count, stride, mesh, flags):
    """Set ``flags[i]`` where knots i and i + stride are farther apart than the rest length."""
    squared_mesh = mesh * mesh
    for i in range(count):
        dx = x[i + stride] - x[i]
        dy = y[i + stride] - y[i]
        dz = z[i + stride] - z[i]
        flags[i] = dx * dx + dy * dy + dz * dz > squared_mesh


@leaf
def clear_row_ends(flags):
    """Remove the flags between the last knot of a row and the first of the next: no thread is there."""
    for row in range(1, KNOT_ROWS):
        flags[row * KNOT_ROWS - 1] = 0


@leaf
def apply_taut(pos, vel, taut, count, ends, numbers, kick, force):
    """Change the knots' velocities by one step under the listed taut threads.

    All forces are found before any velocity changes. ``ends`` (2, 1034) are the knots of each thread.
    """
    for j in range(count):
        a, b = ends[0, taut[j]], ends[1, taut[j]]
        dx = pos[0, b] - pos[0, a]
        dy = pos[1, b] - pos[1, a]
        dz = pos[2, b] - pos[2, a]
        squared = dx * dx + dy * dy + dz * dz
        inverse = 1.0 / math.sqrt(squared)
        stretching = (
            (vel[0, b] - vel[0, a]) * dx + (vel[1, b] - vel[1, a]) * dy + (vel[2, b] - vel[2, a]) * dz
        ) * inverse
        tension = numbers.stiffness * (squared * inverse - numbers.mesh) + numbers.damping * stretching
        tension = max(tension, 0.0) * inverse
        force[0, j] = tension * dx
        force[1, j] = tension * dy
        force[2, j] = tension * dz
    for j in range(count):
        a, b = ends[0, taut[j]], ends[1, taut[j]]
        for axis in range(3):
            vel[axis, a] += kick[a] * force[axis, j]
            vel[axis, b] -= kick[b] * force[axis, j]


@leaf
def all_tensions(x, y, z, vx, vy, vz, count, stride, stiffness, damping, mesh, fx, fy, fz):
    """Force of each thread on its first knot, 0 where it is slack; vectorises."""
    for i in range(count):
        dx = x[i + stride] - x[i]
        dy = y[i + stride] - y[i]
        dz = z[i + stride] - z[i]
        squared = dx * dx + dy * dy + dz * dz
        inverse = 1.0 / math.sqrt(max(squared, 1e-300))
        stretch = squared * inverse - mesh
        stretching = (
            (vx[i + stride] - vx[i]) * dx + (vy[i + stride] - vy[i]) * dy + (vz[i + stride] - vz[i]) * dz
        ) * inverse
        tension = max(stiffness[i] * stretch + damping[i] * stretching, 0.0) * inverse
        tension = tension if stretch > 0.0 else 0.0
        fx[i] = tension * dx
        fy[i] = tension * dy
        fz[i] = tension * dz


@leaf
def apply_all(pos, vel, mesh, arrays, row_force, column_force):
    """Change the knots' velocities by one step under all threads.

    ``row_force`` (3, 530) and ``column_force`` (3, 552) are work space with zeros before the first and behind the
    last thread.
    """
    # One-dimensional slices: numba keeps them contiguous, a slice of the whole array would not vectorise.
    x, y, z, vx, vy, vz = pos[0], pos[1], pos[2], vel[0], vel[1], vel[2]
    all_tensions(
        x, y, z, vx, vy, vz, ROW_THREADS, 1, arrays.row_stiffness, arrays.row_damping, mesh,
        row_force[0, 1:], row_force[1, 1:], row_force[2, 1:],
    )  # fmt: skip
    all_tensions(
        x, y, z, vx, vy, vz, COLUMN_THREADS, KNOT_ROWS, arrays.column_stiffness, arrays.column_damping, mesh,
        column_force[0, KNOT_ROWS:], column_force[1, KNOT_ROWS:], column_force[2, KNOT_ROWS:],
    )  # fmt: skip
    kick = arrays.kick
    for axis in range(3):
        along_row, along_column, speed = row_force[axis], column_force[axis], vel[axis]
        for i in range(KNOTS):
            total = along_row[i + 1] - along_row[i] + along_column[i + KNOT_ROWS] - along_column[i]
            speed[i] += kick[i] * total


@leaf
def drift(pos, vel, time_step):
    """Move the knots with their new velocities."""
    for axis in range(3):
        place, speed = pos[axis], vel[axis]
        for i in range(KNOTS):
            place[i] += time_step * speed[i]
