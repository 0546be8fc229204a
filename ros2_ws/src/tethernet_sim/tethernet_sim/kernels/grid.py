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

from tethernet_sim.kernels import lanes
from tethernet_sim.kernels.compaction import list_busy
from tethernet_sim.kernels.options import inlined, kernel
from tethernet_sim.kernels.rows import LINE, aligned_rows, padded

FIRST_ROW = LINE
"""Where the force of the first thread along a row stands: behind zeros, in whole cache lines."""
_ROW_BITS = 255
"""Those of the threads along rows in a mask of both kinds."""
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
    threads: np.ndarray  # (nodes / 8,) which of eight nodes a thread along a row begins at, then along a column: bits
    masks: np.ndarray  # which of these are taut
    busy: np.ndarray  # indices of the masks that are not 0
    taut_rows: np.ndarray
    taut_columns: np.ndarray
    taut: np.ndarray  # (5, dense_from)
    row_force: np.ndarray  # (3, width), zeros before the first and behind the last thread
    column_force: np.ndarray


@inlined
def blocks(count):
    """Blocks of eight that hold so many."""
    return (count + (lanes.COUNT - 1)) // lanes.COUNT


@kernel
def workspace(net, width):
    """Work space for one scenario; ``width`` is the room of a row of node coordinates."""
    nodes = net.rows * net.columns
    threads = np.zeros(blocks(nodes - 1), np.uint16)
    for node in range(nodes - 1):
        bit = 1 << (node % lanes.COUNT)
        if (node + 1) % net.columns:
            threads[node // lanes.COUNT] |= bit
        if node < nodes - net.columns:
            threads[node // lanes.COUNT] |= bit << lanes.COUNT
    room = nodes + lanes.COUNT
    return GridWork(
        np.zeros(3, np.int64), threads, np.empty(len(threads), np.uint16), np.empty(len(threads) + 1, np.uint32),
        np.empty(room, np.uint32), np.empty(room, np.uint32),
        np.empty((5, net.dense_from + 1)), aligned_rows(FIRST_ROW + width),
        aligned_rows(padded(net.columns) + width),
    )  # fmt: skip


@inlined
def find_along_rows(x, y, z, xs, ys, zs, limit):
    """Which of eight threads along rows are taut, given their nodes x, y, z and the eight nodes after these."""
    dx, dy, dz = lanes.next_lanes(x, xs) - x, lanes.next_lanes(y, ys) - y, lanes.next_lanes(z, zs) - z
    return lanes.mask_greater(dx * dx + dy * dy + dz * dz, limit)


@inlined
def list_taut(net, work, x, y, z):
    """List the threads whose nodes are farther apart than the rest length. Return how many along rows and columns.

    Eight at a time, and without branches: which threads are taut changes so often that a processor guesses wrong.
    """
    threads, masks = work.threads, work.masks
    limit = lanes.spread(net.mesh * net.mesh)
    # Unsigned counters: numba makes sure of every signed index that it is not negative.
    to_row, eight = np.uint64(net.columns), np.uint64(lanes.COUNT)
    with_columns = np.uint64(blocks(net.rows * net.columns - net.columns))
    i = np.uint64(0)
    here_x, here_y, here_z = lanes.load(x, i), lanes.load(y, i), lanes.load(z, i)
    for block in range(with_columns):
        j = i + to_row
        dx, dy, dz = lanes.load(x, j) - here_x, lanes.load(y, j) - here_y, lanes.load(z, j) - here_z
        column = lanes.mask_greater(dx * dx + dy * dy + dz * dz, limit)
        i = eight * (block + np.uint64(1))
        next_x, next_y, next_z = lanes.load(x, i), lanes.load(y, i), lanes.load(z, i)
        row = find_along_rows(here_x, here_y, here_z, next_x, next_y, next_z, limit)
        mask = (row | (column << eight)) & np.uint64(threads[block])
        masks[block] = mask
        here_x, here_y, here_z = next_x, next_y, next_z
    for block in range(with_columns, np.uint64(len(threads))):
        i = eight * (block + np.uint64(1))
        next_x, next_y, next_z = lanes.load(x, i), lanes.load(y, i), lanes.load(z, i)
        mask = find_along_rows(here_x, here_y, here_z, next_x, next_y, next_z, limit) & np.uint64(threads[block])
        masks[block] = mask
        here_x, here_y, here_z = next_x, next_y, next_z
    rows, columns = np.uint64(0), np.uint64(0)
    for b in range(list_busy(masks, work.busy)):
        which = np.uint64(work.busy[b])
        mask, begin = np.uint64(masks[which]), eight * which
        rows = lanes.append_indices(work.taut_rows, rows, begin, mask & np.uint64(_ROW_BITS))
        columns = lanes.append_indices(work.taut_columns, columns, begin, mask >> eight)
    return np.int64(rows), np.int64(columns)


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
        counts[1], counts[2] = list_taut(net, work, pos[0], pos[1], pos[2])
        counts[0] = DENSE_STEPS if counts[1] + counts[2] > net.dense_from else 0
    if counts[0] == 0:
        apply_taut(net, pos, vel, work.taut_rows, counts[1], work.taut_columns, counts[2], kick, work.taut)
    else:
        apply_all(net, pos, vel, kick, work.row_force, work.column_force)
        counts[0] -= 1
