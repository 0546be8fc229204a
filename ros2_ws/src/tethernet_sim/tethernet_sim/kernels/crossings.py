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

import numpy as np

from tethernet_sim.kernels import lanes
from tethernet_sim.kernels.crossing_work import (
    BLOCK,
    LISTED,
    MADE,
    MEMORY,
    NEAR,
    RECORDS,
    blocks,
    fill_up,
    store,
)
from tethernet_sim.kernels.options import inlined

LOOK_STEPS = 5
"""Steps between two looks at how far the knots have come."""
LIST_S, NEAR_S = 0.01, 0.002
"""For how long each list serves if all knots go on as they do [s]."""
LIST_LEAVE_M, NEAR_LEAVE_M = 0.01, 0.0005
"""What a knot may come away in any case [m]."""
LEAVE_SHARE = 1.25
"""Of what a knot would come away at its present speed: it may become faster."""
LEAST_SQUARE = 1e-18
"""Of a thread's length [m^2], so that one without length is no division by 0."""


@inlined
def products(ux, uy, uz, vx, vy, vz, wx, wy, wz):
    """Of two threads u and v, and of w from the first knot of v to that of u: u.u, u.v, v.v, u.w, v.w [m^2]."""
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    return uu, uv, vv, ux * wx + uy * wy + uz * wz, vx * wx + vy * wy + vz * wz


@inlined
def squared_distance(ux, uy, uz, vx, vy, vz, wx, wy, wz):
    """Of eight pairs of segments u and v, w from the start of v to that of u [m^2] (Ericson, Real-Time Collision
    Detection, 5.1.9, without branches).
    """
    none, all_of_it, small = lanes.spread(0.0), lanes.spread(1.0), lanes.spread(LEAST_SQUARE)
    uu, uv, vv, uw, vw = products(ux, uy, uz, vx, vy, vz, wx, wy, wz)
    uu, vv = lanes.greatest(uu, small), lanes.greatest(vv, small)
    s = (uv * vw - uw * vv) / lanes.greatest(uu * vv - uv * uv, small * uu * vv)
    s = lanes.least(lanes.greatest(s, none), all_of_it)
    t = lanes.least(lanes.greatest((uv * s + vw) / vv, none), all_of_it)
    s = lanes.least(lanes.greatest((uv * t - uw) / uu, none), all_of_it)
    dx, dy, dz = wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz
    return dx * dx + dy * dy + dz * dz


@inlined
def gathered(ends, begin, row):
    """One coordinate of eight pairs from ``begin`` on: u, v and w, see :func:`products`."""
    i, j = lanes.gather(row, ends[0], begin), lanes.gather(row, ends[1], begin)
    k, m = lanes.gather(row, ends[2], begin), lanes.gather(row, ends[3], begin)
    return j - i, m - k, i - k


@inlined
def first_lanes(count):
    """Bits of the first lanes, so many, or of all."""
    return (np.uint64(1) << min(count, np.uint64(BLOCK))) - np.uint64(1)


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
def spread_box(box, one):
    """Least and largest x, y, z of one box, each in eight lanes."""
    return (
        lanes.spread(box[0, one]), lanes.spread(box[1, one]), lanes.spread(box[2, one]), lanes.spread(box[3, one]),
        lanes.spread(box[4, one]), lanes.spread(box[5, one]),
    )  # fmt: skip


@inlined
def overlapping(box, limits, begin):
    """Which of eight boxes from ``begin`` on overlap with one, see :func:`spread_box`: bits."""
    low_x, high_x, low_y, high_y, low_z, high_z = limits
    apart = lanes.mask_greater(lanes.load(box[0], begin), high_x)
    apart |= lanes.mask_greater(low_x, lanes.load(box[1], begin))
    apart |= lanes.mask_greater(lanes.load(box[2], begin), high_y)
    apart |= lanes.mask_greater(low_y, lanes.load(box[3], begin))
    apart |= lanes.mask_greater(lanes.load(box[4], begin), high_z)
    apart |= lanes.mask_greater(low_z, lanes.load(box[5], begin))
    return apart ^ np.uint64(255)


@inlined
def may_touch(pairs, ends, leave, distance, pos, begin):
    """Which of eight pairs from ``begin`` on may touch before a knot of theirs has used up its leave: bits."""
    ux, vx, wx = gathered(ends, begin, pos[0])
    uy, vy, wy = gathered(ends, begin, pos[1])
    uz, vz, wz = gathered(ends, begin, pos[2])
    reach = lanes.spread(distance) + lanes.gather(leave, pairs[0], begin) + lanes.gather(leave, pairs[1], begin)
    return lanes.mask_greater(reach * reach, squared_distance(ux, uy, uz, vx, vy, vz, wx, wy, wz))


@inlined
def add_candidates(work, threads, a, found, count):
    """Add thread a with each of the ``found`` that it shares no knot with to the ``count`` candidates. Returns how many
    there are then.
    """
    pairs, ends, of, listed = work.candidates, work.candidate_ends, work.candidate_record, work.found
    i, j, begin = threads[a, 0], threads[a, 1], count
    for f in range(found):
        b = listed[f]
        k, m = threads[b, 0], threads[b, 1]
        pairs[0, count], pairs[1, count], of[count] = a, b, -1.0
        ends[0, count], ends[1, count], ends[2, count], ends[3, count] = i, j, k, m
        count += np.uint64((i != k) & (i != m) & (j != k) & (j != m))
    record = work.head[a]
    while record >= 0:
        for c in range(begin, count):
            if pairs[1, c] == work.records[record, 1]:
                of[c] = record
        record = work.next[record]
    return count


@inlined
def list_candidates(work, distance, pos, candidates, count):
    """List those of the candidates that may touch, or do by a record, after the ``count`` listed pairs.

    Returns:
        How many are listed then; those beyond the room are counted only.
    """
    pairs, ends, of = work.candidates, work.candidate_ends, work.candidate_record
    fill_up(pairs, candidates)
    fill_up(ends, candidates)
    for group in range(np.uint64(blocks(candidates))):
        begin = np.uint64(BLOCK) * group
        chosen = may_touch(pairs, ends, work.thread_leave[0], distance, pos, begin)
        chosen |= lanes.mask_greater(lanes.load(of, begin), lanes.spread(-0.5))
        chosen &= first_lanes(candidates - begin)
        some = lanes.append_indices(work.found, np.uint64(0), begin, chosen)
        for f in range(some):
            if count < len(work.remembers):
                c = work.found[f]
                for one in range(2):
                    work.threads[one, count] = pairs[one, c]
                for end in range(4):
                    work.ends[end, count] = ends[end, c]
                record = np.int64(of[c])
                work.remembers[count] = record >= 0
                if record >= 0:
                    for number in range(MEMORY):
                        work.memory[number, count] = work.records[record, 2 + number]
            count += 1
    return count


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
    count, box, block_box, close = 0, work.box, work.block_box, work.close
    last, most = np.uint64(blocks(len(threads))), np.uint64(len(threads))
    eight, candidates = np.uint64(BLOCK), np.uint64(0)
    for one in range(last):
        limits, some = spread_box(block_box, one), np.uint64(0)
        for group in range(one // eight, np.uint64(blocks(last))):
            begin = eight * group
            overlap = overlapping(block_box, limits, begin)
            if begin < one:  # not those before itself
                overlap &= ~first_lanes(one - begin)
            some = lanes.append_indices(close, some, begin, overlap)
        for a in range(eight * one, min(eight * one + eight, most)):
            if candidates > most:  # there is room for as many more: while work.found is free
                count = list_candidates(work, distance, pos, candidates, count)
                candidates = np.uint64(0)
            limits, found = spread_box(box, a), np.uint64(0)
            for c in range(some):
                begin = eight * np.uint64(close[c])
                overlap = overlapping(box, limits, begin)
                if close[c] == one:  # those behind a itself
                    overlap &= ~first_lanes(a - begin + np.uint64(1))
                found = lanes.append_indices(work.found, found, begin, overlap)
            candidates = add_candidates(work, threads, a, found, candidates)
    count = list_candidates(work, distance, pos, candidates, count)
    work.counts[LISTED], work.counts[NEAR] = count, 0
    work.counts[MADE] = count <= len(work.remembers)
    if work.counts[MADE]:
        fill_up(work.threads, count)
        fill_up(work.ends, count)
    return count


@inlined
def list_near(work, numbers, pos):
    """List the pairs that may touch until a knot has used up its leave, and those that do."""
    remembers, listed, count = work.remembers, np.uint64(work.counts[LISTED]), np.uint64(0)
    for group in range(np.uint64(blocks(listed))):
        begin = np.uint64(BLOCK) * group
        near = may_touch(work.threads, work.ends, work.thread_leave[1], numbers.crossing_distance, pos, begin)
        near = (near | lanes.mask_set(remembers, begin)) & first_lanes(listed - begin)
        count = lanes.append_indices(work.near, count, begin, near)
    for n in range(count):
        p = work.near[n]
        for end in range(4):
            work.near_ends[end, n] = work.ends[end, p]
        work.near_remembers[n] = remembers[p]
    fill_up(work.near_ends, count)
    work.counts[NEAR] = count


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
