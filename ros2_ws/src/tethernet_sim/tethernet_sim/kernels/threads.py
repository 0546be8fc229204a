"""Tension of the net's threads.

Most threads are slack at any time (2 to 6 % are taut until the net is flat), so a step first compares squared lengths
for all of
them, which vectorises well, and evaluates the law for the taut ones only. When many are taut, the law is evaluated
for all, vectorised.
"""

from __future__ import annotations

import math

from tethernet_core.layout import KNOT_ROWS
from tethernet_sim.kernels.options import leaf
from tethernet_sim.model import KNOTS

ROW_THREADS = KNOTS - 1
"""Threads along rows, numbered by their first knot; the entries where a row ends have no thread."""
COLUMN_THREADS = KNOTS - KNOT_ROWS
"""Threads along columns, numbered by their first knot."""
COLUMN_FLAGS = 8 * ((COLUMN_THREADS + 7) // 8)
"""Flags of the threads along columns, padded so that eight can be looked at in one, as those along rows can anyway."""
FIRST_ROW, FIRST_COLUMN, FORCE_ROOM = 8, 24, 560
"""Where the forces of the first thread along a row and along a column stand, and room for all, in whole cache lines."""
DENSE_FROM = 224
"""Taut threads from which evaluating all of them, vectorised, is faster (measured)."""
DENSE_STEPS = 10
"""Steps for which all are evaluated before they are counted again."""


@leaf
def flag_taut(x, y, z, mesh, row_flags, column_flags):
    """Flag the threads whose knots are farther apart than the rest length.

    Args:
        x, y, z: of the knots, with room for eight more [m].
        mesh: rest length [m].
        row_flags: output, (ROW_THREADS,).
        column_flags: output, (COLUMN_FLAGS,).
    """
    squared_mesh = mesh * mesh
    for i in range(COLUMN_FLAGS):
        dx, dy, dz = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
        row_flags[i] = dx * dx + dy * dy + dz * dz > squared_mesh
        dx, dy, dz = x[i + KNOT_ROWS] - x[i], y[i + KNOT_ROWS] - y[i], z[i + KNOT_ROWS] - z[i]
        column_flags[i] = dx * dx + dy * dy + dz * dz > squared_mesh
    for i in range(COLUMN_FLAGS, ROW_THREADS):
        dx, dy, dz = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
        row_flags[i] = dx * dx + dy * dy + dz * dz > squared_mesh
    # No thread leads from the last knot of a row to the first of the next, nor on from the last row.
    for row in range(1, KNOT_ROWS):
        row_flags[row * KNOT_ROWS - 1] = 0
    for i in range(COLUMN_THREADS, COLUMN_FLAGS):
        column_flags[i] = 0


@leaf
def measure(pos, vel, taut, count, stride, squared, closing, dx, dy, dz):
    """Find squared length [m^2], half its rate of change [m^2/s] and direction [m] of the listed threads from knot i to
    i + stride.
    """
    x, y, z, vx, vy, vz = pos[0], pos[1], pos[2], vel[0], vel[1], vel[2]
    for j in range(count):
        a = taut[j]
        b = a + stride
        dx[j], dy[j], dz[j] = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        squared[j] = dx[j] * dx[j] + dy[j] * dy[j] + dz[j] * dz[j]
        closing[j] = (vx[b] - vx[a]) * dx[j] + (vy[b] - vy[a]) * dy[j] + (vz[b] - vz[a]) * dz[j]


@leaf
def pull(vel, taut, count, stride, kick, density, dx, dy, dz):
    """Change the knots' velocities by one step under the listed threads; ``density`` is tension by length [N/m]."""
    vx, vy, vz = vel[0], vel[1], vel[2]
    for j in range(count):
        a = taut[j]
        b = a + stride
        gain = kick[a] * density[j]
        vx[a] += gain * dx[j]
        vy[a] += gain * dy[j]
        vz[a] += gain * dz[j]
        gain = kick[b] * density[j]
        vx[b] -= gain * dx[j]
        vy[b] -= gain * dy[j]
        vz[b] -= gain * dz[j]


@leaf
def apply_taut(pos, vel, rows, row_count, columns, column_count, numbers, kick, work):
    """Change the knots' velocities by one step under the listed threads along rows and along columns.

    All forces are found before any velocity changes. ``work`` (5, DENSE_FROM) is work space.
    """
    squared, closing, dx, dy, dz = work[0], work[1], work[2], work[3], work[4]
    measure(pos, vel, rows, row_count, 1, squared, closing, dx, dy, dz)
    measure(
        pos, vel, columns, column_count, KNOT_ROWS, squared[row_count:], closing[row_count:], dx[row_count:],
        dy[row_count:], dz[row_count:],
    )  # fmt: skip
    stiffness, damping, mesh = numbers.stiffness, numbers.damping, numbers.mesh
    density = squared
    for j in range(row_count + column_count):
        inverse = 1.0 / math.sqrt(squared[j])
        density[j] = max(stiffness * (1.0 - mesh * inverse) + damping * (closing[j] * inverse * inverse), 0.0)
    pull(vel, rows, row_count, 1, kick, density, dx, dy, dz)
    pull(
        vel, columns, column_count, KNOT_ROWS, kick, density[row_count:], dx[row_count:], dy[row_count:],
        dz[row_count:],
    )  # fmt: skip


@leaf
def all_tensions(x, y, z, vx, vy, vz, count, stride, numbers, fx, fy, fz):
    """Force of each thread on its first knot, 0 where it is slack; vectorises."""
    stiffness, damping, mesh = numbers.stiffness, numbers.damping, numbers.mesh
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
        tension = max(stiffness * stretch + damping * stretching, 0.0) * inverse
        tension = tension if stretch > 0.0 else 0.0
        fx[i] = tension * dx
        fy[i] = tension * dy
        fz[i] = tension * dz


@leaf
def apply_all(pos, vel, numbers, kick, row_force, column_force):
    """Change the knots' velocities by one step under all threads.

    ``row_force`` and ``column_force`` (3, FORCE_ROOM) are work space with zeros before the first and behind the last
    thread.
    """
    # One-dimensional slices: numba keeps them contiguous, a slice of the whole array would not vectorise.
    x, y, z, vx, vy, vz = pos[0], pos[1], pos[2], vel[0], vel[1], vel[2]
    all_tensions(
        x, y, z, vx, vy, vz, ROW_THREADS, 1, numbers,
        row_force[0, FIRST_ROW:], row_force[1, FIRST_ROW:], row_force[2, FIRST_ROW:],
    )  # fmt: skip
    all_tensions(
        x, y, z, vx, vy, vz, COLUMN_FLAGS, KNOT_ROWS, numbers,
        column_force[0, FIRST_COLUMN:], column_force[1, FIRST_COLUMN:], column_force[2, FIRST_COLUMN:],
    )  # fmt: skip
    for axis in range(3):
        along_row, along_column = row_force[axis, FIRST_ROW:], column_force[axis, FIRST_COLUMN:]
        for row in range(1, KNOT_ROWS):
            along_row[row * KNOT_ROWS - 1] = 0.0
        for i in range(COLUMN_THREADS, COLUMN_FLAGS):
            along_column[i] = 0.0
    for axis in range(3):
        along_row, along_column, speed = row_force[axis], column_force[axis], vel[axis]
        for i in range(KNOTS):
            total = along_row[i + FIRST_ROW] - along_row[i + FIRST_ROW - 1]
            total += along_column[i + FIRST_COLUMN] - along_column[i + FIRST_COLUMN - KNOT_ROWS]
            speed[i] += kick[i] * total


@leaf
def drift(pos, vel, time_step):
    """Move the knots with their new velocities."""
    for axis in range(3):
        place, speed = pos[axis], vel[axis]
        for i in range(KNOTS):
            place[i] += time_step * speed[i]
