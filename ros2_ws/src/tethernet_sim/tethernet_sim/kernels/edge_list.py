"""Tension of the threads of any net, given as a list.

Reading the two ends of a thread from all over memory costs several times what a grid's threads cost, so most of them
are left out, as neighbour lists do it (Verlet 1967, Phys. Rev. 159): threads that are shorter than their rest length by
more than twice a skin stay slack until some node has moved by the skin, in a frame that moves with the net as a whole.
Until then only the others are looked at. This is exact: no taut thread is ever missed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tethernet_sim.kernels.compaction import compact_indices
from tethernet_sim.kernels.options import inlined, kernel
from tethernet_sim.kernels.rows import aligned_rows, padded

SEARCH_STEPS = 20
"""Steps that a search shall serve for if the fastest node goes on as it does."""
LEAST_SKIN = 1e-6
"""Least skin [m], for a net at rest."""


class EdgeList(NamedTuple):
    """Constants of a net's threads."""

    nodes: int
    first: np.ndarray  # (T,) node at one end, unsigned
    second: np.ndarray  # (T,) node at the other end, unsigned
    rest: np.ndarray  # (T,) rest length [m]
    stiffness: np.ndarray  # (T,) [N/m]
    damping: np.ndarray  # (T,) [N s/m]


class EdgeListWork(NamedTuple):
    """Work space of one scenario."""

    counts: np.ndarray  # (1,) candidates; -1 before the first search
    frame: np.ndarray  # (7,) skin squared [m^2], the frame's velocity [m/s], how far it has come since the search [m]
    reference: np.ndarray  # (3, width) positions at the last search [m]
    flags: np.ndarray  # one byte each, padded
    blocks: np.ndarray  # the same bytes, eight in one
    busy: np.ndarray
    candidates: np.ndarray  # (T + 1,) threads that may become taut before the next search
    ends: np.ndarray  # (2, T) their ends
    squared_rest: np.ndarray  # (T,) their squared rest lengths [m^2]
    taut: np.ndarray  # (T + 1,) where among the candidates the taut ones are
    law: np.ndarray  # (4, T)


@kernel
def workspace(net, width):
    """Work space for one scenario; ``width`` is the room of a row of node coordinates."""
    threads = len(net.first)
    flags = np.zeros(padded(threads), np.uint8)
    counts = np.full(1, -1, np.int64)
    return EdgeListWork(
        counts, np.zeros(7), aligned_rows(width), flags, flags.view(np.uint64),
        np.empty(len(flags) // 8 + 1, np.uint32), np.empty(threads + 1, np.uint32),
        np.empty((2, threads), np.uint32), np.empty(threads), np.empty(threads + 1, np.uint32),
        np.empty((4, threads)),
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
    """List the threads that may become taut before a node leaves its skin."""
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
    frame[0] = skin * skin
    first, second, rest = net.first, net.second, net.rest
    for t in range(len(first)):
        a, b = first[t], second[t]
        dx, dy, dz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        sure = max(rest[t] - 2.0 * skin, 0.0)
        flags[t] = dx * dx + dy * dy + dz * dz >= sure * sure
    count = compact_indices(flags, work.blocks, work.busy, work.candidates)
    candidates, one, other, squared_rest = work.candidates, work.ends[0], work.ends[1], work.squared_rest
    for j in range(count):
        t = candidates[j]
        one[j], other[j] = first[t], second[t]
        squared_rest[j] = rest[t] * rest[t]
    work.counts[0] = count


@inlined
def list_taut(x, y, z, work):
    """List the taut ones among the candidates. Return how many there are."""
    one, other, squared_rest, taut = work.ends[0], work.ends[1], work.squared_rest, work.taut
    found = np.uint64(0)
    for j in range(work.counts[0]):
        a, b = one[j], other[j]
        dx, dy, dz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        taut[found] = j
        found += np.uint64(dx * dx + dy * dy + dz * dz > squared_rest[j])
    return np.int64(found)


@inlined
def apply(net, work, pos, vel, kick, time_step):
    """Change the nodes' velocities by one step under the net's threads; all forces are found before any changes."""
    frame = work.frame
    if work.counts[0] < 0 or has_moved(net.nodes, pos, work.reference, frame):
        search(net, work, pos, vel, time_step)
    for axis in range(3):
        frame[4 + axis] += time_step * frame[1 + axis]
    x, y, z, vx, vy, vz = pos[0], pos[1], pos[2], vel[0], vel[1], vel[2]
    taut, one, other, candidates = work.taut, work.ends[0], work.ends[1], work.candidates
    rest, stiffness, damping = net.rest, net.stiffness, net.damping
    density, dx, dy, dz = work.law[0], work.law[1], work.law[2], work.law[3]
    count = list_taut(x, y, z, work)
    for j in range(count):
        c = taut[j]
        a, b, t = one[c], other[c], candidates[c]
        ux, uy, uz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        squared = ux * ux + uy * uy + uz * uz
        rate = (vx[b] - vx[a]) * ux + (vy[b] - vy[a]) * uy + (vz[b] - vz[a]) * uz
        dx[j], dy[j], dz[j] = ux, uy, uz
        inverse = 1.0 / math.sqrt(squared)
        density[j] = max(stiffness[t] * (1.0 - rest[t] * inverse) + damping[t] * (rate * inverse * inverse), 0.0)
    for j in range(count):
        c = taut[j]
        a, b = one[c], other[c]
        ux, uy, uz, strength = dx[j], dy[j], dz[j], density[j]
        gain, opposite = kick[a] * strength, kick[b] * strength
        vx[a] += gain * ux
        vy[a] += gain * uy
        vz[a] += gain * uz
        vx[b] -= opposite * ux
        vy[b] -= opposite * uy
        vz[b] -= opposite * uz
