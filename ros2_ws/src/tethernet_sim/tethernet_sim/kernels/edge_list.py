"""Tension of the threads of any net, given as a list.

Numbered nodes of a net that is woven, knitted or wound have threads that run side by side: from nodes in a row to nodes
in another row, all the same number of nodes further on. Such threads stand in blocks of eight, which are compared with
their rest lengths and evaluated in vectors, without looking up single nodes. As for grids, the law is evaluated for the
taut threads only, or for all blocks while many are taut.

Threads that fit into no block are loose. Reading their two ends from all over memory costs several times as much, so
most of them are left out, as neighbour lists do it (Verlet 1967, Phys. Rev. 159): threads that are shorter than their
rest length by more than twice a skin stay slack until some node has moved by the skin, in a frame that moves with the
net as a whole. Until then only the others are looked at. This is exact: no taut thread is ever missed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tethernet_sim.kernels import lanes
from tethernet_sim.kernels.compaction import compact_indices, list_busy
from tethernet_sim.kernels.options import inlined, kernel
from tethernet_sim.kernels.rows import aligned_rows, padded

SEARCH_STEPS = 20
"""Steps that a search shall serve for if the fastest node goes on as it does."""
LEAST_SKIN = 1e-6
"""Least skin [m], for a net at rest."""


FEW = 8
"""Nodes for each loose thread from which looking at all loose threads costs less than at how far the nodes moved."""
DENSE_STEPS = 10
"""Steps for which all blocks are evaluated before the taut threads are counted again."""
SLACK_M = 1e150
"""Rest length of what fills up a block where it has no thread: no distance exceeds it, and its square is finite [m]."""


class EdgeList(NamedTuple):
    """Constants of a net's threads: those in blocks, eight by eight, then the loose ones; S places in all."""

    nodes: int
    dense_from: int
    """Taut threads in blocks from which evaluating all blocks is faster."""
    block_first: np.ndarray  # (B,) node at one end of a block's first thread; the other threads begin at those after it
    block_second: np.ndarray  # (B,) node at the other end of it
    first: np.ndarray  # (S,) node at one end, unsigned
    second: np.ndarray  # (S,) node at the other end, unsigned
    rest: np.ndarray  # (S,) rest length [m]
    squared_rest: np.ndarray  # (S,) [m^2]
    stiffness: np.ndarray  # (S,) [N/m], 0 where a block has no thread
    damping: np.ndarray  # (S,) [N s/m]


class EdgeListWork(NamedTuple):
    """Work space of one scenario."""

    counts: np.ndarray  # (2,) candidates among the loose, -1 before the first search; steps for which all are evaluated
    frame: np.ndarray  # (7,) skin squared [m^2], the frame's velocity [m/s], how far it has come since the search [m]
    reference: np.ndarray  # (3, width) positions at the last search [m]
    flags: np.ndarray  # one byte for each loose thread, padded
    flag_blocks: np.ndarray  # the same bytes, eight in one
    busy: np.ndarray
    candidates: np.ndarray  # (L + 1,) loose threads that may become taut before the next search
    ends: np.ndarray  # (2, L) their ends
    squared_rest: np.ndarray  # (L,) their squared rest lengths [m^2]
    masks: np.ndarray  # (B,) which threads of a block are taut: bits
    busy_blocks: np.ndarray  # (B + 1,) the blocks with taut threads
    taut: np.ndarray  # (S + 8,) places of the taut threads
    law: np.ndarray  # (4, S)


@kernel
def workspace(net, width):
    """Work space for one scenario; ``width`` is the room of a row of node coordinates."""
    blocks, places = len(net.block_first), len(net.first)
    loose = places - lanes.COUNT * blocks
    flags = np.zeros(padded(loose), np.uint8)
    counts = np.full(2, -1, np.int64)
    counts[1] = 0
    return EdgeListWork(
        counts, np.zeros(7), aligned_rows(width), flags, flags.view(np.uint64),
        np.empty(len(flags) // 8 + 1, np.uint32), np.empty(loose + 1, np.uint32),
        np.empty((2, loose), np.uint32), np.empty(loose), np.empty(blocks, np.uint8), np.empty(blocks + 1, np.uint32),
        np.empty(places + lanes.COUNT, np.uint32), np.empty((4, places)),
    )  # fmt: skip


@inlined
def has_moved(nodes, pos, reference, frame):
    """Whether a node has left the skin round where it was at the last search."""
    x, y, z, xr, yr, zr = pos[0], pos[1], pos[2], reference[0], reference[1], reference[2]
    limit, ox, oy, oz = frame[0], frame[4], frame[5], frame[6]
    left = np.int64(0)
    for i in range(nodes):
        dx, dy, dz = x[i] - xr[i] - ox, y[i] - yr[i] - oy, z[i] - zr[i] - oz
        left += np.int64(dx * dx + dy * dy + dz * dz > limit)
    return left > 0


@inlined
def search(net, work, pos, vel, time_step):
    """List the loose threads that may become taut before a node leaves its skin."""
    frame, reference, flags = work.frame, work.reference, work.flags
    x, y, z = pos[0], pos[1], pos[2]
    nodes = net.nodes
    for axis in range(3):
        speed, place, now = vel[axis], reference[axis], pos[axis]
        total = 0.0
        for i in range(nodes):
            total += speed[i]
            place[i] = now[i]
        frame[1 + axis], frame[4 + axis] = total / nodes, 0.0
    vx, vy, vz, ux, uy, uz = vel[0], vel[1], vel[2], frame[1], frame[2], frame[3]
    fastest = 0.0
    for i in range(nodes):
        dx, dy, dz = vx[i] - ux, vy[i] - uy, vz[i] - uz
        fastest = max(fastest, dx * dx + dy * dy + dz * dz)
    skin = max(SEARCH_STEPS * time_step * math.sqrt(fastest), LEAST_SKIN)
    begin = lanes.COUNT * len(net.block_first)
    first, second, rest = net.first[begin:], net.second[begin:], net.rest[begin:]
    if FEW * len(first) < nodes:
        skin = math.inf  # all are candidates, for good
    frame[0] = skin * skin
    for t in range(len(first)):
        a, b = first[t], second[t]
        dx, dy, dz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        sure = max(rest[t] - 2.0 * skin, 0.0)
        flags[t] = dx * dx + dy * dy + dz * dz >= sure * sure
    count = compact_indices(flags, work.flag_blocks, work.busy, work.candidates)
    candidates, one, other, squared_rest = work.candidates, work.ends[0], work.ends[1], work.squared_rest
    for j in range(count):
        t = candidates[j]
        one[j], other[j] = first[t], second[t]
        squared_rest[j] = rest[t] * rest[t]
    work.counts[0] = count


@inlined
def list_loose(x, y, z, work, begin, found):
    """List the taut ones among the candidates behind the ``found`` places. Return how many are listed then.

    ``begin`` is the place of the first loose thread.
    """
    one, other, squared_rest, taut = work.ends[0], work.ends[1], work.squared_rest, work.taut
    candidates = work.candidates
    for j in range(work.counts[0]):
        a, b = one[j], other[j]
        dx, dy, dz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        taut[found] = begin + candidates[j]
        found += np.uint64(dx * dx + dy * dy + dz * dz > squared_rest[j])
    return found


@inlined
def list_blocks(net, work, x, y, z):
    """List the places of the taut threads in blocks. Return how many there are."""
    first, second, limits = net.block_first, net.block_second, net.squared_rest
    masks, busy, eight = work.masks, work.busy_blocks, np.uint64(lanes.COUNT)
    for block in range(np.uint64(len(first))):
        a, b = np.uint64(first[block]), np.uint64(second[block])
        dx, dy, dz = (
            lanes.load(x, b) - lanes.load(x, a),
            lanes.load(y, b) - lanes.load(y, a),
            lanes.load(z, b) - lanes.load(z, a),
        )
        mask = lanes.mask_greater(dx * dx + dy * dy + dz * dz, lanes.load(limits, eight * block))
        masks[block] = mask
    found = np.uint64(0)
    for j in range(list_busy(masks, busy)):
        which = np.uint64(busy[j])
        found = lanes.append_indices(work.taut, found, eight * which, np.uint64(masks[which]))
    return found


@inlined
def evaluate_blocks(net, work, x, y, z, vx, vy, vz):
    """Force of each thread in a block on its first node, 0 where it is slack."""
    first, second, rest = net.block_first, net.block_second, net.rest
    fx, fy, fz = work.law[0], work.law[1], work.law[2]
    one, tiny, eight = lanes.spread(1.0), lanes.spread(1e-300), np.uint64(lanes.COUNT)
    for block in range(np.uint64(len(first))):
        a, b, place = np.uint64(first[block]), np.uint64(second[block]), eight * block
        dx, dy, dz = (
            lanes.load(x, b) - lanes.load(x, a),
            lanes.load(y, b) - lanes.load(y, a),
            lanes.load(z, b) - lanes.load(z, a),
        )
        ux, uy, uz = (
            lanes.load(vx, b) - lanes.load(vx, a),
            lanes.load(vy, b) - lanes.load(vy, a),
            lanes.load(vz, b) - lanes.load(vz, a),
        )
        squared = dx * dx + dy * dy + dz * dz + tiny
        inverse = one / lanes.square_root(squared)
        stretch = squared * inverse - lanes.load(rest, place)
        stretching = (ux * dx + uy * dy + uz * dz) * inverse
        pull = lanes.load(net.stiffness, place) * stretch + lanes.load(net.damping, place) * stretching
        density = lanes.where_positive(stretch, lanes.where_positive(pull, pull * inverse))
        lanes.store(fx, place, density * dx)
        lanes.store(fy, place, density * dy)
        lanes.store(fz, place, density * dz)


@inlined
def pull_blocks(net, force, speed, kick):
    """Change the nodes' velocities along one axis by one step under the threads in blocks.

    All first ends, then all second ones: two blocks one after the other change different nodes in either, so that no
    load has to wait for a store.
    """
    first, second, eight = net.block_first, net.block_second, np.uint64(lanes.COUNT)
    for block in range(np.uint64(len(first))):
        a = np.uint64(first[block])
        pull = lanes.load(force, eight * block)
        lanes.store(speed, a, lanes.load(speed, a) + lanes.load(kick, a) * pull)
    for block in range(np.uint64(len(first))):
        b = np.uint64(second[block])
        pull = lanes.load(force, eight * block)
        lanes.store(speed, b, lanes.load(speed, b) - lanes.load(kick, b) * pull)


@inlined
def apply(net, work, pos, vel, kick, time_step):
    """Change the nodes' velocities by one step under the net's threads; all forces are found before any changes."""
    frame, counts = work.frame, work.counts
    x, y, z, vx, vy, vz = pos[0], pos[1], pos[2], vel[0], vel[1], vel[2]
    first, second, rest, stiffness, damping = net.first, net.second, net.rest, net.stiffness, net.damping
    in_blocks = np.uint64(lanes.COUNT * len(net.block_first))
    found = np.uint64(0)
    if counts[1] == 0:
        found = list_blocks(net, work, x, y, z)
        counts[1] = DENSE_STEPS if found > np.uint64(net.dense_from) else 0
    dense = counts[1] > 0
    if dense:
        counts[1] -= 1
        found = np.uint64(0)
        evaluate_blocks(net, work, x, y, z, vx, vy, vz)
    if in_blocks < np.uint64(len(first)):
        if counts[0] < 0 or (frame[0] < math.inf and has_moved(net.nodes, pos, work.reference, frame)):
            search(net, work, pos, vel, time_step)
        for axis in range(3):
            frame[4 + axis] += time_step * frame[1 + axis]
        found = list_loose(x, y, z, work, in_blocks, found)
    taut = work.taut
    # Behind the forces of the blocks if these have been evaluated: there are never more taut threads than loose ones.
    begin = in_blocks if dense else np.uint64(0)
    density, dx, dy, dz = work.law[3], work.law[0], work.law[1], work.law[2]
    for j in range(found):
        t = taut[j]
        a, b = first[t], second[t]
        ux, uy, uz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        squared = ux * ux + uy * uy + uz * uz
        rate = (vx[b] - vx[a]) * ux + (vy[b] - vy[a]) * uy + (vz[b] - vz[a]) * uz
        i = begin + j
        dx[i], dy[i], dz[i] = ux, uy, uz
        inverse = 1.0 / math.sqrt(squared)
        density[i] = max(stiffness[t] * (1.0 - rest[t] * inverse) + damping[t] * (rate * inverse * inverse), 0.0)
    if dense:
        pull_blocks(net, dx, vx, kick)
        pull_blocks(net, dy, vy, kick)
        pull_blocks(net, dz, vz, kick)
    for j in range(found):
        t = taut[j]
        a, b = first[t], second[t]
        i = begin + j
        ux, uy, uz, strength = dx[i], dy[i], dz[i], density[i]
        gain, opposite = kick[a] * strength, kick[b] * strength
        vx[a] += gain * ux
        vy[a] += gain * uy
        vz[a] += gain * uz
        vx[b] -= opposite * ux
        vy[b] -= opposite * uy
        vz[b] -= opposite * uz
