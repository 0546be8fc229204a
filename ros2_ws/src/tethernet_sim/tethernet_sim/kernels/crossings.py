"""Which threads of the net are near each other: what the contact of net with net looks at.

Threads are straight segments between knots; two that share a knot do not touch. There are half a million pairs of
threads in a net of 529 knots, of which some hundred are near each other. Neighbour lists (Verlet 1967, Phys. Rev. 159),
one within the other, find them: the listed pairs, near enough to touch within :data:`LIST_S`, by boxes round blocks of
threads and round single ones, then by distance; of these the near ones, for :data:`NEAR_S`. Each knot has a leave of
its own, by its speed relative to the net as a whole, because a few knots fly fast while most hardly move; when any knot
has used its leave up, the list is made anew. Knots are looked at every :data:`LOOK_STEPS` steps: contact is felt so
much too late at the most, where a knot was jerked away in between, and never wrongly.

What a touching pair remembers, see :mod:`~tethernet_sim.kernels.crossing_law`, stays with it from list to list.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tethernet_sim.kernels import lanes
from tethernet_sim.kernels.compaction import compact_indices
from tethernet_sim.kernels.options import inlined, kernel
from tethernet_sim.kernels.rows import padded

LOOK_STEPS = 5
"""Steps between two looks at how far the knots have come."""
LIST_S, NEAR_S = 0.01, 0.002
"""For how long each list serves if all knots go on as they do [s]."""
LIST_LEAVE_M, NEAR_LEAVE_M = 0.004, 0.0005
"""What a knot may come away in any case [m]."""
LEAVE_SHARE = 1.25
"""Of what a knot would come away at its present speed: it may become faster."""
BLOCK = lanes.COUNT
"""Threads in a block."""
PAIRS_PER_THREAD = 12
"""Listed pairs that there is room for at first: a net that unfolds has up to 10 a thread (measured)."""
LEAST_SQUARE = 1e-18
"""Of a thread's length [m^2], so that one without length is no division by 0."""
LISTED, NEAR, MADE, LOOK_IN, TOUCHING, RECORDS = range(6)
"""Entries of the counts: listed pairs, near pairs, whether there are lists; steps until the next look, pairs that touch
in this step, records of touching pairs that are not in the lists yet."""
MEMORY = 7
"""Numbers that a touching pair remembers: its normal, x y z; the distance at which it touches [m], then the bristle of
its friction, x y z [m], launch frame."""
RECORD = 2 + MEMORY
"""Numbers of a touching pair in a state: its two threads and what it remembers."""


class CrossingWork(NamedTuple):
    """Work space of one scenario, for X threads and room for P pairs; two lists: 0 the listed, 1 the near pairs."""

    counts: np.ndarray  # (6,) see LISTED
    frame: np.ndarray  # (2, 6) velocity of the net when each list was made [m/s], how far it has come since [m]
    place: np.ndarray  # (2, 3, width) where the knots were then [m]
    leave: np.ndarray  # (2, width) how far from there, in that frame, each may come [m]
    thread_leave: np.ndarray  # (2, X) that of the thread's faster end [m]
    box: np.ndarray  # (6, blocks BLOCK) least and largest x, y, z of each thread, its leave included [m]
    block_box: np.ndarray  # (6, .) of each block; what fills up both overlaps with nothing
    limits: np.ndarray  # (6,) of the box that is looked at
    close: np.ndarray  # (blocks + BLOCK,) blocks that overlap with it
    found: np.ndarray  # (blocks BLOCK + BLOCK,) threads that do
    head: np.ndarray  # (X,) first record of each thread that is the first of its pair, -1: none
    threads: np.ndarray  # (2, P) of each listed pair
    ends: np.ndarray  # (4, P) its knots: of the first thread, then of the second
    memory: np.ndarray  # (MEMORY, P)
    remembers: np.ndarray  # (P,) whether it touches
    near: np.ndarray  # (P + 1,) listed pairs that are near
    near_ends: np.ndarray  # (4, P) their knots
    near_remembers: np.ndarray  # (P,) whether they touch
    flags: np.ndarray  # (P,) of near pairs, of listed ones while the near are searched for
    flag_blocks: np.ndarray  # the same bytes, eight in one
    busy: np.ndarray
    hits: np.ndarray  # (P + 1,) near pairs that touch
    push: np.ndarray  # (12, P) velocity that each end of these gains in one step [m/s], x y z of each
    records: np.ndarray  # (P, RECORD) touching pairs while the lists are made
    next: np.ndarray  # (P,) record of the same first thread, -1: none


@inlined
def blocks(count):
    """Blocks that hold so many."""
    return (count + (BLOCK - 1)) // BLOCK


@inlined
def room(threads, records):
    """Pairs to begin with room for."""
    return PAIRS_PER_THREAD * threads + records


@kernel
def workspace(threads, width, pairs):
    """Work space for one scenario: so many threads and ``pairs``; ``width`` is the room of a row of coordinates."""
    count, room = blocks(threads), padded(pairs)
    box, block_box = np.full((6, count * BLOCK), -np.inf), np.full((6, blocks(count) * BLOCK), -np.inf)
    box[::2], block_box[::2] = np.inf, np.inf
    flags = np.zeros(room, np.uint8)
    return CrossingWork(
        np.zeros(6, np.int64), np.zeros((2, 6)), np.zeros((2, 3, width)), np.zeros((2, width)), np.zeros((2, threads)),
        box, block_box, np.zeros(6), np.empty(count + BLOCK, np.uint32), np.empty(count * BLOCK + BLOCK, np.uint32),
        np.full(threads, -1, np.int64), np.empty((2, room), np.uint32), np.empty((4, room), np.uint32),
        np.empty((MEMORY, room)), np.empty(room, np.uint8), np.empty(room + 1, np.uint32),
        np.empty((4, room), np.uint32), np.empty(room, np.uint8), flags, flags.view(np.uint64),
        np.empty(room // 8 + 1, np.uint32), np.empty(room + 1, np.uint32), np.empty((12, room)),
        np.empty((room, RECORD)), np.empty(room, np.int64),
    )  # fmt: skip


@kernel
def with_room(work, pairs):
    """Work space with more room; the records are kept, lists have to be made."""
    width, threads, records = work.place.shape[2], len(work.head), work.counts[RECORDS]
    larger = workspace(threads, width, pairs)
    larger.counts[RECORDS] = records
    larger.records[:records] = work.records[:records]
    return larger


@inlined
def store(work, records):
    """Write the pairs that remember something to ``records`` (., RECORD), as many as there is room for.

    Returns:
        How many there are.
    """
    count, room = 0, len(records)
    for n in range(work.counts[NEAR]):
        if work.near_remembers[n]:
            if count < room:
                p = work.near[n]
                records[count, 0], records[count, 1] = work.threads[0, p], work.threads[1, p]
                for number in range(MEMORY):
                    records[count, 2 + number] = work.memory[number, p]
            count += 1
    return count


@inlined
def two_threads(x, y, z, i, j, k, m):
    """Two threads, between knots i and j and between k and m.

    Returns:
        (u from i to j, x y z, v from k to m, x y z, w from k to i, x y z [m]; u.u, u.v, v.v, u.w, v.w [m^2]).
    """
    ux, uy, uz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
    vx, vy, vz = x[m] - x[k], y[m] - y[k], z[m] - z[k]
    wx, wy, wz = x[i] - x[k], y[i] - y[k], z[i] - z[k]
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    uw, vw = ux * wx + uy * wy + uz * wz, vx * wx + vy * wy + vz * wz
    return ux, uy, uz, vx, vy, vz, wx, wy, wz, uu, uv, vv, uw, vw


@inlined
def squared_distance(x, y, z, i, j, k, m):
    """Of the segments between knots i and j and between k and m [m^2] (Ericson, Real-Time Collision Detection, 5.1.9,
    without branches).
    """
    ux, uy, uz, vx, vy, vz, wx, wy, wz, uu, uv, vv, uw, vw = two_threads(x, y, z, i, j, k, m)
    uu, vv = max(uu, LEAST_SQUARE), max(vv, LEAST_SQUARE)
    s = min(max((uv * vw - uw * vv) / max(uu * vv - uv * uv, LEAST_SQUARE * uu * vv), 0.0), 1.0)
    t = min(max((uv * s + vw) / vv, 0.0), 1.0)
    s = min(max((uv * t - uw) / uu, 0.0), 1.0)
    dx, dy, dz = wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz
    return dx * dx + dy * dy + dz * dz


@inlined
def begin_list(work, which, knots, pos, vel, duration, least):
    """Note where the knots are and how far they may go while a list serves."""
    frame, leave = work.frame[which], work.leave[which]
    for axis in range(3):
        place, now, speed = work.place[which, axis], pos[axis], vel[axis]
        total = 0.0
        for i in range(knots):
            place[i] = now[i]
            total += speed[i]
        frame[axis], frame[3 + axis] = total / knots, 0.0
    vx, vy, vz, ux, uy, uz = vel[0], vel[1], vel[2], frame[0], frame[1], frame[2]
    scale = LEAVE_SHARE * duration
    for i in range(knots):
        dx, dy, dz = vx[i] - ux, vy[i] - uy, vz[i] - uz
        leave[i] = least + scale * math.sqrt(dx * dx + dy * dy + dz * dz)


@inlined
def used_up(work, which, knots, pos, reserve):
    """Whether a knot has come farther than its leave, or would with ``reserve`` times that of the near pairs."""
    frame, leave, near_leave = work.frame[which], work.leave[which], work.leave[1]
    x, y, z = pos[0], pos[1], pos[2]
    px, py, pz = work.place[which, 0], work.place[which, 1], work.place[which, 2]
    ox, oy, oz = frame[3], frame[4], frame[5]
    beyond = np.int64(0)
    for i in range(knots):
        dx, dy, dz = x[i] - px[i] - ox, y[i] - py[i] - oy, z[i] - pz[i] - oz
        left = leave[i] - reserve * near_leave[i]
        beyond += np.int64((left < 0.0) | (dx * dx + dy * dy + dz * dz > left * left))
    return beyond > 0


@inlined
def spread_leave(work, which, threads):
    """Find each thread's leave from those of its knots."""
    leave, of_thread = work.leave[which], work.thread_leave[which]
    for t in range(len(threads)):
        of_thread[t] = max(leave[threads[t, 0]], leave[threads[t, 1]])


@inlined
def make_boxes(work, threads, pos, distance):
    """Boxes round all threads and blocks, with leave and half the ``distance`` at which they touch [m]."""
    box, block_box, leave = work.box, work.block_box, work.thread_leave[0]
    for axis in range(3):
        place, low, high = pos[axis], box[2 * axis], box[2 * axis + 1]
        for t in range(len(threads)):
            a, b = place[threads[t, 0]], place[threads[t, 1]]
            margin = 0.5 * distance + leave[t]
            low[t], high[t] = min(a, b) - margin, max(a, b) + margin
        for block in range(blocks(len(threads))):
            least, most = np.inf, -np.inf
            for t in range(BLOCK * block, BLOCK * block + BLOCK):
                least, most = min(least, low[t]), max(most, high[t])
            block_box[2 * axis, block], block_box[2 * axis + 1, block] = least, most


@inlined
def cover(work, a, b):
    """Let the box of thread a, and of its block, hold that of b."""
    for axis in range(3):
        for boxes, one, other in ((work.box, a, b), (work.block_box, a // BLOCK, b // BLOCK)):
            low, high = boxes[2 * axis], boxes[2 * axis + 1]
            low[one], high[one] = min(low[one], low[other]), max(high[one], high[other])


@inlined
def overlapping(box, limits, begin):
    """Which of eight boxes from ``begin`` on overlap with ``limits``, least and largest x, y, z: bits."""
    apart = np.uint64(0)
    for axis in range(3):
        low, high = box[2 * axis], box[2 * axis + 1]
        apart |= lanes.mask_greater(lanes.load(low, begin), lanes.spread(limits[2 * axis + 1]))
        apart |= lanes.mask_greater(lanes.spread(limits[2 * axis]), lanes.load(high, begin))
    return apart ^ np.uint64(255)


@inlined
def append_pair(work, threads, a, b, pos, distance, count):
    """List the threads a and b if they may touch. Returns how many pairs there are then; those beyond the room are
    counted only.
    """
    i, j, k, m = threads[a, 0], threads[a, 1], threads[b, 0], threads[b, 1]
    if (i == k) | (i == m) | (j == k) | (j == m):
        return count
    record = work.head[a]
    while record >= 0 and work.records[record, 1] != b:
        record = work.next[record]
    reach = distance + work.thread_leave[0, a] + work.thread_leave[0, b]
    if record < 0 and squared_distance(pos[0], pos[1], pos[2], i, j, k, m) > reach * reach:
        return count
    if count < len(work.remembers):
        work.threads[0, count], work.threads[1, count] = a, b
        work.ends[0, count], work.ends[1, count], work.ends[2, count], work.ends[3, count] = i, j, k, m
        work.remembers[count] = record >= 0
        if record >= 0:
            for number in range(MEMORY):
                work.memory[number, count] = work.records[record, 2 + number]
    return count + 1


@inlined
def list_pairs(work, threads, numbers, knots, pos, vel):
    """List all pairs that may touch soon; the records are of those that do.

    Returns:
        How many there are: when that is more than there is room for, there are no lists.
    """
    begin_list(work, 0, knots, pos, vel, LIST_S, LIST_LEAVE_M)
    spread_leave(work, 0, threads)
    distance = numbers.crossing_distance
    make_boxes(work, threads, pos, distance)
    for t in range(len(threads)):
        work.head[t] = -1
    for r in range(work.counts[RECORDS]):
        of = np.int64(work.records[r, 0])
        work.next[r] = work.head[of]
        work.head[of] = r
        # One that has gone through may be farther apart than its boxes say.
        cover(work, of, np.int64(work.records[r, 1]))
    count, box, block_box, limits, close = 0, work.box, work.block_box, work.limits, work.close
    last, most = np.uint64(blocks(len(threads))), np.uint64(len(threads))
    eight = np.uint64(BLOCK)
    for one in range(last):
        for side in range(6):
            limits[side] = block_box[side, one]
        some = np.uint64(0)
        for group in range(one // eight, np.uint64(blocks(last))):
            some = lanes.append_indices(close, some, eight * group, overlapping(block_box, limits, eight * group))
        for a in range(eight * one, min(eight * one + eight, most)):
            for side in range(6):
                limits[side] = box[side, a]
            found = np.uint64(0)
            for c in range(some):
                if close[c] >= one:
                    begin = eight * np.uint64(close[c])
                    found = lanes.append_indices(work.found, found, begin, overlapping(box, limits, begin))
            for f in range(found):
                if work.found[f] > a:
                    count = append_pair(work, threads, np.int64(a), np.int64(work.found[f]), pos, distance, count)
    work.counts[LISTED], work.counts[NEAR] = count, 0
    work.counts[MADE] = count <= len(work.remembers)
    return count


@inlined
def list_near(work, numbers, pos):
    """List the pairs that may touch until a knot has used up its leave, and those that do."""
    x, y, z, ends, leave = pos[0], pos[1], pos[2], work.ends, work.thread_leave[1]
    one, other, i, j, k, m = work.threads[0], work.threads[1], ends[0], ends[1], ends[2], ends[3]
    flags, remembers, listed = work.flags, work.remembers, work.counts[LISTED]
    distance = numbers.crossing_distance
    for p in range(listed):
        reach = distance + leave[one[p]] + leave[other[p]]
        close = squared_distance(x, y, z, i[p], j[p], k[p], m[p]) < reach * reach
        flags[p] = np.uint8(close) | remembers[p]
    for p in range(listed, min(padded(listed), len(flags))):
        flags[p] = 0
    near = compact_indices(flags, work.flag_blocks[: (listed + 7) // 8], work.busy, work.near)
    for n in range(near):
        p = work.near[n]
        for end in range(4):
            work.near_ends[end, n] = ends[end, p]
        work.near_remembers[n] = remembers[p]
    work.counts[NEAR] = near


@inlined
def look(work, threads, numbers, knots, pos, vel):
    """Make the lists anew whose knots have used up their leave.

    Returns:
        Pairs that there must be room for, see :func:`with_room`; 0 where there is.
    """
    made = work.counts[MADE] > 0
    if made:
        elapsed = LOOK_STEPS * numbers.time_step
        for which in range(2):
            for axis in range(3):
                work.frame[which, 3 + axis] += elapsed * work.frame[which, axis]
        if not used_up(work, 1, knots, pos, 0.0):
            return 0
        begin_list(work, 1, knots, pos, vel, NEAR_S, NEAR_LEAVE_M)
    else:
        begin_list(work, 1, knots, pos, vel, NEAR_S, NEAR_LEAVE_M)
    if not made or used_up(work, 0, knots, pos, 1.0):
        if made:
            work.counts[RECORDS] = store(work, work.records)
        needed = list_pairs(work, threads, numbers, knots, pos, vel)
        if needed > len(work.remembers):
            return needed
    spread_leave(work, 1, threads)
    list_near(work, numbers, pos)
    return 0
