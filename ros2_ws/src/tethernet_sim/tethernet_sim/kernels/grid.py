"""Tension of the threads of a rectangular net, all alike.

Nodes are numbered row by row, so that every thread leads from a node to the next one, or to the one a row further on:
no list of ends is read, and everything vectorises. Most threads are slack at any time (2 to 6 % are taut until the net
is flat), so a step first compares squared lengths for all of them and evaluates the law for the taut ones only. When
many are taut, the law is evaluated for all, vectorised.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tethernet_sim.kernels.compaction import compact_indices
from tethernet_sim.kernels.options import inlined, kernel
from tethernet_sim.kernels.rows import LINE, aligned_rows, padded

FIRST_ROW = LINE
"""Where the force of the first thread along a row stands: behind zeros, in whole cache lines."""
DENSE_STEPS = 10
"""Steps for which all threads are evaluated before the taut ones are counted again."""


class Grid(NamedTuple):
    """Constants of a rectangular net."""

    rows: int
    columns: int
    mesh: float
    """Rest length of every thread [m]."""
    stiffness: float
    """Of every thread [N/m]."""
    damping: float
    """Of every thread [N s/m]."""
    dense_from: int
    """Taut threads from which evaluating all of them is faster."""


class GridWork(NamedTuple):
    """Work space of one scenario."""

    counts: np.ndarray  # (3,) steps for which all are evaluated; taut threads along rows, along columns
    row_begins: np.ndarray  # 1 where a thread along a row begins, 0 at the end of each row and behind the last, padded
    row_flags: np.ndarray  # which threads along rows are taut, numbered by their first node, padded
    column_flags: np.ndarray  # which along columns
    row_blocks: np.ndarray  # the same bytes, eight in one
    column_blocks: np.ndarray
    busy: np.ndarray
    taut_rows: np.ndarray
    taut_columns: np.ndarray
    taut: np.ndarray  # (5, dense_from)
    row_force: np.ndarray  # (3, width), zeros before the first and behind the last thread
    column_force: np.ndarray


@kernel
def workspace(net, width):
    """Work space for one scenario; ``width`` is the room of a row of node coordinates."""
    nodes = net.rows * net.columns
    row_begins, row_flags = np.zeros(padded(nodes - 1), np.uint8), np.zeros(padded(nodes - 1), np.uint8)
    for node in range(nodes):
        if (node + 1) % net.columns:
            row_begins[node] = 1
    column_flags = np.zeros(padded(nodes - net.columns), np.uint8)
    return GridWork(
        np.zeros(3, np.int64), row_begins, row_flags, column_flags, row_flags.view(np.uint64),
        column_flags.view(np.uint64),
        np.empty(len(row_flags) // 8 + 1, np.uint32), np.empty(nodes + 1, np.uint32), np.empty(nodes + 1, np.uint32),
        np.empty((5, net.dense_from + 1)), aligned_rows(FIRST_ROW + width),
        aligned_rows(padded(net.columns) + width),
    )  # fmt: skip


@inlined
def flag_taut(x, y, z, rows, columns, mesh, row_begins, row_flags, column_flags):
    """Flag the threads whose nodes are farther apart than the rest length.

    Args:
        x, y, z: of the nodes, with room for a vector more [m].
        rows: of nodes.
        columns: of nodes.
        mesh: rest length [m].
        row_begins: which nodes a thread along a row begins at, see GridWork.
        row_flags: output.
        column_flags: output.
    """
    squared_mesh = mesh * mesh
    # Unsigned counters: numba makes sure of every signed index that it is not negative, and slices are slower.
    both, to_next, to_row = np.uint64(len(column_flags)), np.uint64(1), np.uint64(columns)
    for i in range(both):
        j = i + to_next
        dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
        row_flags[i] = (dx * dx + dy * dy + dz * dz > squared_mesh) & row_begins[i]
        j = i + to_row
        dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
        column_flags[i] = dx * dx + dy * dy + dz * dz > squared_mesh
    for i in range(both, np.uint64(len(row_flags))):
        j = i + to_next
        dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
        row_flags[i] = (dx * dx + dy * dy + dz * dz > squared_mesh) & row_begins[i]
    for i in range(rows * columns - columns, len(column_flags)):
        column_flags[i] = 0  # no thread leads on from the last row


@inlined
def measure(pos, vel, taut, count, stride, squared, closing, dx, dy, dz):
    """Find squared length [m^2], half its rate of change [m^2/s] and direction [m] of the listed threads from node i to
    i + stride.
    """
    x, y, z, vx, vy, vz = pos[0], pos[1], pos[2], vel[0], vel[1], vel[2]
    step = np.uint64(stride)
    for j in range(count):
        a = taut[j]
        b = a + step
        ux, uy, uz = x[b] - x[a], y[b] - y[a], z[b] - z[a]  # not read back from the rows that they are written to
        squared[j] = ux * ux + uy * uy + uz * uz
        closing[j] = (vx[b] - vx[a]) * ux + (vy[b] - vy[a]) * uy + (vz[b] - vz[a]) * uz
        dx[j], dy[j], dz[j] = ux, uy, uz


@inlined
def pull(vel, taut, count, stride, kick, density, dx, dy, dz):
    """Change the nodes' velocities by one step under the listed threads; ``density`` is tension by length [N/m]."""
    vx, vy, vz = vel[0], vel[1], vel[2]
    step = np.uint64(stride)
    for j in range(count):
        a = taut[j]
        b = a + step
        ux, uy, uz, strength = dx[j], dy[j], dz[j], density[j]
        gain, opposite = kick[a] * strength, kick[b] * strength
        vx[a] += gain * ux
        vy[a] += gain * uy
        vz[a] += gain * uz
        vx[b] -= opposite * ux
        vy[b] -= opposite * uy
        vz[b] -= opposite * uz


@inlined
def apply_taut(net, pos, vel, rows, row_count, columns, column_count, kick, work):
    """Change the nodes' velocities by one step under the listed threads along rows and along columns.

    All forces are found before any velocity changes. ``work`` (5, dense_from) is work space.
    """
    squared, closing, dx, dy, dz = work[0], work[1], work[2], work[3], work[4]
    measure(pos, vel, rows, row_count, 1, squared, closing, dx, dy, dz)
    measure(
        pos, vel, columns, column_count, net.columns, squared[row_count:], closing[row_count:], dx[row_count:],
        dy[row_count:], dz[row_count:],
    )  # fmt: skip
    stiffness, damping, mesh = net.stiffness, net.damping, net.mesh
    density = squared
    for j in range(row_count + column_count):
        inverse = 1.0 / math.sqrt(squared[j])
        density[j] = max(stiffness * (1.0 - mesh * inverse) + damping * (closing[j] * inverse * inverse), 0.0)
    pull(vel, rows, row_count, 1, kick, density, dx, dy, dz)
    pull(
        vel, columns, column_count, net.columns, kick, density[row_count:], dx[row_count:], dy[row_count:],
        dz[row_count:],
    )  # fmt: skip


@inlined
def all_tensions(x, y, z, vx, vy, vz, count, stride, net, fx, fy, fz):
    """Force of each thread on its first node, 0 where it is slack; vectorises."""
    stiffness, damping, mesh = net.stiffness, net.damping, net.mesh
    step = np.uint64(stride)
    for i in range(np.uint64(count)):
        j = i + step
        dx = x[j] - x[i]
        dy = y[j] - y[i]
        dz = z[j] - z[i]
        squared = dx * dx + dy * dy + dz * dz
        inverse = 1.0 / math.sqrt(max(squared, 1e-300))
        stretch = squared * inverse - mesh
        stretching = ((vx[j] - vx[i]) * dx + (vy[j] - vy[i]) * dy + (vz[j] - vz[i]) * dz) * inverse
        tension = max(stiffness * stretch + damping * stretching, 0.0) * inverse
        tension = tension if stretch > 0.0 else 0.0
        fx[i] = tension * dx
        fy[i] = tension * dy
        fz[i] = tension * dz


@inlined
def apply_all(net, pos, vel, kick, row_force, column_force):
    """Change the nodes' velocities by one step under all threads.

    ``row_force`` and ``column_force`` are work space with zeros before the first and behind the last thread.
    """
    # One-dimensional slices: numba keeps them contiguous, a slice of the whole array would not vectorise.
    x, y, z, vx, vy, vz = pos[0], pos[1], pos[2], vel[0], vel[1], vel[2]
    columns, nodes = net.columns, net.rows * net.columns
    first_column = padded(columns)
    row_threads, column_threads = padded(nodes - 1), padded(nodes - columns)
    all_tensions(
        x, y, z, vx, vy, vz, row_threads, 1, net,
        row_force[0, FIRST_ROW:], row_force[1, FIRST_ROW:], row_force[2, FIRST_ROW:],
    )  # fmt: skip
    all_tensions(
        x, y, z, vx, vy, vz, column_threads, columns, net,
        column_force[0, first_column:], column_force[1, first_column:], column_force[2, first_column:],
    )  # fmt: skip
    for axis in range(3):
        along_row, along_column = row_force[axis, FIRST_ROW:], column_force[axis, first_column:]
        for row in range(1, net.rows):
            along_row[row * columns - 1] = 0.0
        for i in range(nodes - 1, row_threads):
            along_row[i] = 0.0
        for i in range(nodes - columns, column_threads):
            along_column[i] = 0.0
    for axis in range(3):
        along_row, along_column, speed = row_force[axis], column_force[axis], vel[axis]
        for i in range(np.uint64(padded(nodes))):
            row, column = i + np.uint64(FIRST_ROW), i + np.uint64(first_column)  # type: ignore[assignment]  # not the row above
            total = along_row[row] - along_row[row - np.uint64(1)]
            total += along_column[column] - along_column[column - np.uint64(columns)]
            speed[i] += kick[i] * total


@inlined
def apply(net, work, pos, vel, kick, _time_step):
    """Change the nodes' velocities by one step under the net's threads."""
    counts = work.counts
    if counts[0] == 0:
        flag_taut(
            pos[0], pos[1], pos[2], net.rows, net.columns, net.mesh, work.row_begins, work.row_flags, work.column_flags
        )
        counts[1] = compact_indices(work.row_flags, work.row_blocks, work.busy, work.taut_rows)
        counts[2] = compact_indices(work.column_flags, work.column_blocks, work.busy, work.taut_columns)
        counts[0] = DENSE_STEPS if counts[1] + counts[2] > net.dense_from else 0
    if counts[0] == 0:
        apply_taut(net, pos, vel, work.taut_rows, counts[1], work.taut_columns, counts[2], kick, work.taut)
    else:
        apply_all(net, pos, vel, kick, work.row_force, work.column_force)
        counts[0] -= 1
