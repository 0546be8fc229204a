"""Where threads touch the debris: every thread, unit thread and closing thread is a straight segment with a radius.

The distance of a convex body along a segment is convex: its slope grows from end to end, and bisection finds where it
passes through zero. That point touches like a particle, see :func:`~tethernet_sim.kernels.contact.contact_forces`, and
what acts there is shared between the ends by the lever rule, so that momentum and angular momentum stay exact. Where a
segment lies flat on a face or along an edge, the deepest point is no single one: the points where the slope leaves a
band round zero, to either side, carry half each. A union of bodies is looked at part by part, a mesh span by span of
the segment.

At its ends a thread lies in the knots' balls, and those touch by themselves: there the thread's contact fades out.

Three lists, one within the other, keep the cost down: segments near the debris, for :data:`LIST_SEARCHES` searches;
points near it, found at every search and material from then to the next; of which those that touch push.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tethernet_sim.kernels import contact, debris_body
from tethernet_sim.kernels.options import inlined, kernel

LIST_SEARCHES = 10
"""Searches for points that a list of segments serves for."""
COLD_STEPS, WARM_STEPS = 10, 5
"""Bisections over a whole segment, and round the place found last: to a thousandth of its length either way."""
WARM_WIDTH = 1.0 / 64.0
"""How far round the place found last, as a share of the segment's length."""
BORDER = 1.0 / 256.0
"""As near to the border of a span a place counts as at it."""
FLAT = 0.01
"""A segment lies flat where the sine of its angle to the surface is smaller."""
APART_RADII = 4.0
"""Two points of a segment that are nearer than so many knot radii are one."""
LEAST_SHARE = 0.05
"""Contacts that have faded out to less are left to the knot."""
CHUNK = 128
"""Segments looked at together."""
ROWS = 11
"""Rows of work space for them: end and vector to the other one [m], two brackets, the limit of a flat slope [m]."""


class ThreadWork(NamedTuple):
    """Work space of one scenario, for S segments and Q parts of the debris."""

    segment: np.ndarray  # (S Q,) of each listed pair of segment and part
    part: np.ndarray  # (S Q,) likewise
    wait: np.ndarray  # (S Q,) searches for which it is too far away
    chosen: np.ndarray  # (CHUNK,) where in the list those are that are looked at together
    place: np.ndarray  # (2, S Q) where its slope leaves the band round zero, as shares of the segment's length
    block: np.ndarray  # (ROWS CHUNK,)
    ends: np.ndarray  # (2, 2 S Q) particles at the ends of each point's segment
    share: np.ndarray  # (2 S Q,) of its length, from the first end to the point
    bristle: np.ndarray  # (2 S Q,) number of the point's bristle among all
    former: np.ndarray  # (2 S Q,) the same of the points before the last search
    gap: np.ndarray  # (2 S Q,) distance of the point from the debris at the search [m]
    active: np.ndarray  # (2 S Q,) points that touch
    numbers: np.ndarray  # (3, 2 S Q) radius [m], damping [N s/m], stiffness as a share of the law's
    held: np.ndarray  # (3, 2 S Q) bristles [m]


@kernel
def workspace(segments, parts):
    """Work space for one scenario."""
    listed = segments * parts
    points = 2 * listed
    return ThreadWork(
        np.empty(listed, np.int64), np.empty(listed, np.int64), np.empty(listed, np.int64), np.empty(CHUNK, np.int64),
        np.empty((2, listed)), np.empty(ROWS * CHUNK),
        np.empty((2, points), np.int64), np.empty(points), np.empty(points, np.int64), np.empty(points, np.int64),
        np.empty(points), np.empty(points, np.int64), np.empty((3, points)), np.empty((3, points)),
    )  # fmt: skip


@inlined
def place(knot_pos, mu_pos, knots, particle):
    """Of a particle [m]."""
    if particle < knots:
        return knot_pos[0, particle], knot_pos[1, particle], knot_pos[2, particle]
    m = particle - knots
    return mu_pos[m, 0], mu_pos[m, 1], mu_pos[m, 2]


@inlined
def fill(block, j, debris, matrix, start, end):
    """Write a segment, in the debris' frame, to column ``j`` of a block."""
    px, py, pz = start[0] - debris[0], start[1] - debris[1], start[2] - debris[2]
    ux, uy, uz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    for axis in range(3):
        mx, my, mz = matrix[0, axis], matrix[1, axis], matrix[2, axis]
        block[j + axis * CHUNK] = mx * px + my * py + mz * pz
        block[j + (3 + axis) * CHUNK] = mx * ux + my * uy + mz * uz
    block[j + 10 * CHUNK] = FLAT * math.sqrt(ux * ux + uy * uy + uz * uz)


@inlined
def bracket(block, j, low, high):
    """Begin the search for both places of column ``j`` between two shares each."""
    block[j + 6 * CHUNK], block[j + 7 * CHUNK] = low[0], high[0]
    block[j + 8 * CHUNK], block[j + 9 * CHUNK] = low[1], high[1]


@inlined
def slope(body, part, block, j, share):
    """Of the distance along the segment of column ``j`` [m], a change over its whole length."""
    dx, dy, dz = block[j + 3 * CHUNK], block[j + 4 * CHUNK], block[j + 5 * CHUNK]
    _, nx, ny, nz = debris_body.part_surface(
        body, part, block[j] + share * dx, block[j + CHUNK] + share * dy, block[j + 2 * CHUNK] + share * dz
    )
    return nx * dx + ny * dy + nz * dz


@inlined
def bisect(body, part, block, count, steps):
    """Narrow the brackets down; the inner loop has no branches where the body's distance has none, and vectorises."""
    for _ in range(steps):
        for j in range(count):
            limit = block[j + 10 * CHUNK]
            low, high = block[j + 6 * CHUNK], block[j + 7 * CHUNK]
            middle = 0.5 * (low + high)
            beyond = slope(body, part, block, j, middle) >= -limit
            block[j + 6 * CHUNK], block[j + 7 * CHUNK] = low if beyond else middle, middle if beyond else high
            low, high = block[j + 8 * CHUNK], block[j + 9 * CHUNK]
            middle = 0.5 * (low + high)
            beyond = slope(body, part, block, j, middle) > limit
            block[j + 8 * CHUNK], block[j + 9 * CHUNK] = low if beyond else middle, middle if beyond else high


@inlined
def distance_at(body, part, block, j, share):
    """Of the point of a segment from a part [m]; infinite where another part of the body is nearer."""
    x = block[j] + share * block[j + 3 * CHUNK]
    y = block[j + CHUNK] + share * block[j + 4 * CHUNK]
    z = block[j + 2 * CHUNK] + share * block[j + 5 * CHUNK]
    distance = debris_body.part_surface(body, part, x, y, z)[0]
    return distance if debris_body.decides(body, part, x, y, z, distance) else np.inf


@inlined
def list_segments(work, arrays, count, knot_pos, mu_pos, body, debris, matrix, numbers, margin):
    """List pairs of a segment and a part of the debris that may touch while ``margin`` [m] is not used up.

    ``count`` is how many of the segments are there: those of closing threads, at the end, only while they close.

    Returns:
        How many pairs are listed.
    """
    segments, radius, block = arrays.segments, arrays.segment_radius, work.block
    knots = numbers.knots
    frame = debris_body.frame(body, matrix)
    near = 0
    # First those whose middle is near the whole body; the room of the points' bristles is free until points are found.
    for s in range(count):
        ax, ay, az = place(knot_pos, mu_pos, knots, segments[s, 0])
        bx, by, bz = place(knot_pos, mu_pos, knots, segments[s, 1])
        dx, dy, dz = bx - ax, by - ay, bz - az
        half = 0.5 * math.sqrt(dx * dx + dy * dy + dz * dz)
        limits = debris_body.inflated(body, half + radius[s] + margin)
        work.bristle[near] = s
        near += debris_body.within(
            body, frame, limits, 0.5 * (ax + bx) - debris[0], 0.5 * (ay + by) - debris[1], 0.5 * (az + bz) - debris[2]
        )
    listed = 0
    for part in range(debris_body.parts(body)):
        low, high = debris_body.span(body, part)
        for begin in range(0, near, CHUNK):
            size = min(CHUNK, near - begin)
            for j in range(size):
                s = work.bristle[begin + j]
                fill(
                    block, j, debris, matrix, place(knot_pos, mu_pos, knots, segments[s, 0]),
                    place(knot_pos, mu_pos, knots, segments[s, 1]),
                )  # fmt: skip
                bracket(block, j, (low, low), (high, high))
            bisect(body, part, block, size, COLD_STEPS)
            for j in range(size):
                left, right = (
                    0.5 * (block[j + 6 * CHUNK] + block[j + 7 * CHUNK]),
                    0.5 * (block[j + 8 * CHUNK] + block[j + 9 * CHUNK]),
                )
                s = work.bristle[begin + j]
                nearest = min(_part_distance(body, part, block, j, left), _part_distance(body, part, block, j, right))
                work.segment[listed], work.part[listed] = s, part
                work.place[0, listed], work.place[1, listed], work.wait[listed] = left, right, 0
                listed += nearest - radius[s] < margin
    return listed


@inlined
def _part_distance(body, part, block, j, share):
    x = block[j] + share * block[j + 3 * CHUNK]
    y = block[j + CHUNK] + share * block[j + 4 * CHUNK]
    z = block[j + 2 * CHUNK] + share * block[j + 5 * CHUNK]
    return debris_body.part_surface(body, part, x, y, z)[0]


@inlined
def find_points(work, arrays, listed, knot_pos, mu_pos, body, debris, matrix, numbers, margin):
    """List the points of the listed segments that may touch before the next search, ``margin`` [m] away.

    Returns:
        How many points.
    """
    segments, radius, block = arrays.segments, arrays.segment_radius, work.block
    knots, parts = numbers.knots, debris_body.parts(body)
    first_bristle = knots + len(mu_pos)
    chosen = work.chosen
    points, begin = 0, 0
    while begin < listed:
        part, size = work.part[begin], 0
        while size < CHUNK and begin < listed and work.part[begin] == part:
            chosen[size] = begin
            size += work.wait[begin] == 0
            work.wait[begin] = max(work.wait[begin] - 1, 0)
            begin += 1
        low, high = debris_body.span(body, part)
        for j in range(size):
            e = chosen[j]
            s, left, right = work.segment[e], work.place[0, e], work.place[1, e]
            fill(
                block, j, debris, matrix, place(knot_pos, mu_pos, knots, segments[s, 0]),
                place(knot_pos, mu_pos, knots, segments[s, 1]),
            )  # fmt: skip
            bracket(
                block, j, (max(left - WARM_WIDTH, low), max(right - WARM_WIDTH, low)),
                (min(left + WARM_WIDTH, high), min(right + WARM_WIDTH, high)),
            )  # fmt: skip
        bisect(body, part, block, size, WARM_STEPS)
        for j in range(size):
            e = chosen[j]
            s = work.segment[e]
            left = 0.5 * (block[j + 6 * CHUNK] + block[j + 7 * CHUNK])
            right = 0.5 * (block[j + 8 * CHUNK] + block[j + 9 * CHUNK])
            work.place[0, e], work.place[1, e] = left, right
            length = block[j + 10 * CHUNK] / FLAT
            ends = segments[s, 0], segments[s, 1]
            first = numbers.knot_radius if ends[0] < knots else numbers.mu_radius
            second = numbers.knot_radius if ends[1] < knots else numbers.mu_radius
            if (right - left) * length < APART_RADII * numbers.knot_radius:
                left = right = 0.5 * (left + right)
                shares = _faded(left, low, high, length, first, second), 0.0
            else:
                shares = _faded(left, low, high, length, first, second), _faded(right, low, high, length, first, second)
            sum_of_shares = max(shares[0] + shares[1], 1.0)
            nearest = _part_distance(body, part, block, j, left)
            if right != left:
                nearest = min(nearest, _part_distance(body, part, block, j, right))
            if nearest - radius[s] >= margin:
                # Nothing touches before so many searches.
                work.wait[e] = np.int64(min((nearest - radius[s]) / margin, 1e6)) - 1
                continue
            for side in range(2):
                at, share = (left, shares[0]) if side == 0 else (right, shares[1])
                share /= sum_of_shares
                if share < LEAST_SHARE:
                    continue
                gap = distance_at(body, part, block, j, at) - radius[s]
                if gap >= margin:
                    continue
                work.ends[0, points], work.ends[1, points] = ends
                work.share[points], work.gap[points] = at, gap
                work.bristle[points] = first_bristle + 2 * (s * parts + part) + side
                inverse_mass = (1.0 - at) * (1.0 - at) * arrays.inverse_mass[ends[0]]
                inverse_mass += at * at * arrays.inverse_mass[ends[1]]
                stiffness = share * arrays.segment_stiffness[s]
                work.numbers[0, points] = radius[s]
                work.numbers[1, points] = 2.0 * numbers.contact_damping_ratio * math.sqrt(stiffness / inverse_mass)
                work.numbers[2, points] = stiffness / numbers.contact_stiffness
                points += 1
    return points


@inlined
def _faded(at, low, high, length, first, second):
    """Share of a contact that the knots' balls at the ends do not take over: 0 at an end, 1 outside of the balls. None
    is left where a span of a segment ends within it: the next span has what is there.
    """
    share = 1.0
    if (low > 0.0 and at < low + BORDER) or (high < 1.0 and at > high - BORDER):
        return 0.0
    if first > 0.0:
        share = min(share, at * length / first)
    if second > 0.0:
        share = min(share, (1.0 - at) * length / second)
    return share


@inlined
def store_bristles(bristles, work, count):
    """Copy the points' bristles back, and remember which they are."""
    for p in range(count):
        work.former[p] = work.bristle[p]
        for axis in range(3):
            bristles[work.bristle[p], axis] = work.held[axis, p]


@inlined
def fetch_bristles(bristles, work, count, former):
    """Copy the bristles of the points to look at, and forget those of the ``former`` ones: what is not looked at
    touches nothing.
    """
    for p in range(count):
        for axis in range(3):
            work.held[axis, p] = bristles[work.bristle[p], axis]
    for p in range(former):
        for axis in range(3):
            bristles[work.former[p], axis] = 0.0


@inlined
def gather(
    work, points, knot_pos, knot_vel, mu_pos, mu_vel, body, debris, matrix, knots, within_reach, begin, contact_work
):  # fmt: skip
    """Copy what the law of contact needs of the points that touch to ``contact_work``, behind the ``begin`` particles
    there; the others' bristles are forgotten. Points farther away than ``within_reach`` [m] at the search cannot touch
    yet.

    Returns:
        How many touch.
    """
    px, py, pz = debris[0], debris[1], debris[2]
    frame = debris_body.frame(body, matrix)
    active = 0
    for p in range(points):
        if work.gap[p] > within_reach:
            continue
        share, i, j = work.share[p], work.ends[0, p], work.ends[1, p]
        other = 1.0 - share
        ax, ay, az = place(knot_pos, mu_pos, knots, i)
        bx, by, bz = place(knot_pos, mu_pos, knots, j)
        dx, dy, dz = other * ax + share * bx - px, other * ay + share * by - py, other * az + share * bz - pz
        if not debris_body.within(body, frame, debris_body.inflated(body, work.numbers[0, p]), dx, dy, dz):
            for axis in range(3):
                work.held[axis, p] = 0.0
            continue
        k = contact.column(begin + active)
        work.active[active] = p
        active += 1
        contact_work[k] = dx
        contact_work[k + contact.BLOCK] = dy
        contact_work[k + 2 * contact.BLOCK] = dz
        ax, ay, az = place(knot_vel, mu_vel, knots, i)
        bx, by, bz = place(knot_vel, mu_vel, knots, j)
        contact_work[k + 3 * contact.BLOCK] = other * ax + share * bx
        contact_work[k + 4 * contact.BLOCK] = other * ay + share * by
        contact_work[k + 5 * contact.BLOCK] = other * az + share * bz
        for axis in range(3):
            contact_work[k + (6 + axis) * contact.BLOCK] = work.held[axis, p]
        for row in range(3):
            contact_work[k + (12 + row) * contact.BLOCK] = work.numbers[row, p]
        contact_work[k + 15 * contact.BLOCK] = 1.0 / work.numbers[2, p]
    return active


@inlined
def react(work, active, begin, contact_work, kick, knots, knot_vel, mu_force):
    """Kick the ends of the touching segments by one step, keep the bristles."""
    for a in range(active):
        k, p = contact.column(begin + a), work.active[a]
        share = work.share[p]
        for axis in range(3):
            work.held[axis, p] = contact_work[k + (6 + axis) * contact.BLOCK]
        fx, fy = contact_work[k + 9 * contact.BLOCK], contact_work[k + 10 * contact.BLOCK]
        fz = contact_work[k + 11 * contact.BLOCK]
        for end in range(2):
            particle = work.ends[end, p]
            part = share if end else 1.0 - share
            if particle < knots:
                gain = kick[particle] * part
                knot_vel[0, particle] += gain * fx
                knot_vel[1, particle] += gain * fy
                knot_vel[2, particle] += gain * fz
            else:
                m = particle - knots
                mu_force[m, 0] += part * fx
                mu_force[m, 1] += part * fy
                mu_force[m, 2] += part * fz
