"""Where threads touch the debris: every thread, unit thread and closing thread is a straight segment with a radius.

The distance of a convex body along a segment is convex: its slope grows from end to end, and bisection finds where it
passes through zero. That point touches like a particle, see :func:`~tethernet_sim.kernels.contact.contact_forces`, and
what acts there is shared between the ends by the lever rule, so that momentum and angular momentum stay exact. Where a
segment lies flat on a face or along an edge, the deepest point is no single one: the points where the slope leaves a
band round zero, to either side, share the force. A union of bodies is looked at part by part, a mesh span by span of
the segment.

Where a segment crosses an edge the normal changes at once, and the force must be the gradient of the segment's depth
all the same: a force along the segment, or one along the edge, would drive it for ever. Two points, one on each side of
the edge, share the force so that nothing of it acts along the segment, and follow the edge at every step.

Three lists, one within the other, keep the cost down: segments near the debris, for :data:`LIST_SEARCHES` searches;
points near it, found at every search and material from then to the next; of which those that touch push.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tethernet_sim.kernels import debris_body
from tethernet_sim.kernels.options import inlined, kernel

LIST_SEARCHES = 10
"""Searches for points that a list of segments serves for."""
COLD_STEPS, WARM_STEPS = 10, 5
"""Bisections over a whole segment, and round the place found last: to a thousandth of its length either way."""
WARM_WIDTH = 1.0 / 64.0
"""How far round the place found last, as a share of the segment's length."""
BORDER = 1.0 / 1024.0
"""As near to the border of a span a place counts as at it."""
FLAT = 0.01
"""A segment lies flat where the sine of its angle to the surface is smaller."""
APART_RADII = 4.0
"""Two points of a segment that are nearer than so many knot radii are one."""
LEAST_SHARE = 0.01
"""Of a segment's force that each of its two points has."""
EDGE_M = 0.002
"""Distance between the two points of a segment that crosses an edge."""
ALONE, FLAT_END = -1, -2
"""A point without a partner: the only one of its segment, or one end of what lies flat."""
LEAST_SQUARE = 1e-12
"""Of a segment's length [m^2], so that one without length is no division by 0."""
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
    entry: np.ndarray  # (2 S Q,) number of its pair of segment and part in the list
    partner: np.ndarray  # (2 S Q,) the point on the other side of an edge that the segment crosses; or ALONE, FLAT_END
    weight: np.ndarray  # (2 S Q,) share of the segment's force
    bristle: np.ndarray  # (2 S Q,) number of the point's bristle among all
    former: np.ndarray  # (2 S Q,) the same of the points before the last search
    gap: np.ndarray  # (2 S Q,) distance of the point from the debris at the search [m]
    active: np.ndarray  # (2 S Q,) points that touch
    numbers: np.ndarray  # (3, 2 S Q) of its segment: radius [m], damping [N s/m], stiffness as a share of the law's
    held: np.ndarray  # (3, 2 S Q) bristles [m]
    found: np.ndarray  # (2, 2 S Q) at this step: slope of the distance along the segment [m], depth [m]


@kernel
def workspace(segments, parts):
    """Work space for one scenario."""
    listed = segments * parts
    points = 2 * listed
    return ThreadWork(
        np.empty(listed, np.int64), np.empty(listed, np.int64), np.empty(listed, np.int64), np.empty(CHUNK, np.int64),
        np.empty((2, listed)), np.empty(ROWS * CHUNK),
        np.empty((2, points), np.int64), np.empty(points), np.empty(points, np.int64), np.empty(points, np.int64),
        np.empty(points), np.empty(points, np.int64), np.empty(points, np.int64), np.empty(points),
        np.empty(points, np.int64), np.empty((3, points)), np.empty((3, points)), np.empty((2, points)),
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
    x, y, z = _point(block, j, share)
    _, nx, ny, nz = debris_body.part_surface(body, part, x, y, z)
    return nx * block[j + 3 * CHUNK] + ny * block[j + 4 * CHUNK] + nz * block[j + 5 * CHUNK]


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
def touching_places(body, part, block, j, apart):
    """Where a segment touches a part, once its brackets are narrow.

    Where the slope leaves the band round zero at once, the segment crosses an edge: the two points are those on both
    sides of it, see :func:`share_at_edge`. Otherwise they are the ends of what lies flat, and one point where these are
    nearer than ``apart`` [m].

    Returns:
        (places of the two points as shares of the length, share of the force at the first, ALONE or FLAT_END or 0 for
        an edge).
    """
    limit = block[j + 10 * CHUNK]
    length = limit / FLAT
    left, right = block[j + 7 * CHUNK], block[j + 8 * CHUNK]
    left_slope, right_slope = slope(body, part, block, j, left), slope(body, part, block, j, right)
    near = (right - left) * length < apart
    if near and abs(left_slope) <= limit and abs(right_slope) <= limit:
        return 0.5 * (left + right), 0.5 * (left + right), 1.0, ALONE
    if not near:
        return left, right, share_at_edge(left_slope, right_slope, limit), FLAT_END
    middle, half = 0.5 * (left + right), 0.5 * EDGE_M / max(length, EDGE_M)
    left, right = max(middle - half, 0.0), min(middle + half, 1.0)
    left_slope, right_slope = slope(body, part, block, j, left), slope(body, part, block, j, right)
    return left, right, share_at_edge(left_slope, right_slope, limit), 0


@inlined
def share_at_edge(left_slope, right_slope, limit):
    """Share of the force at the first of two points of a segment: such that nothing of it acts along the segment.

    On both sides of an edge the nearest surface is another. Between its two normals lies the one across the segment,
    the gradient of its depth; the slopes [m] are their parts along the segment. ``limit``: of a flat slope [m].
    """
    share = (right_slope + limit) / max(right_slope - left_slope + 2.0 * limit, limit)
    return min(max(share, LEAST_SHARE), 1.0 - LEAST_SHARE)


@inlined
def distance_at(body, part, block, j, share):
    """Of the point of a segment from a part [m]; infinite where another part of the body is nearer."""
    x, y, z = _point(block, j, share)
    distance = _part_distance(body, part, block, j, share)
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
def _point(block, j, share):
    """Of the segment of column ``j`` [m]."""
    dx, dy, dz = block[j + 3 * CHUNK], block[j + 4 * CHUNK], block[j + 5 * CHUNK]
    return block[j] + share * dx, block[j + CHUNK] + share * dy, block[j + 2 * CHUNK] + share * dz


@inlined
def _part_distance(body, part, block, j, share):
    x, y, z = _point(block, j, share)
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
            nearest = _part_distance(body, part, block, j, 0.5 * (left + right))
            if nearest - radius[s] >= margin:
                # Nothing touches before so many searches.
                work.wait[e] = np.int64(min((nearest - radius[s]) / margin, 1e6)) - 1
                continue
            left, right, share_of_left, kind = touching_places(
                body, part, block, j, APART_RADII * numbers.knot_radius
            )  # fmt: skip
            ends = segments[s, 0], segments[s, 1]
            former = points
            for side in range(1 if kind == ALONE else 2):
                at, weight = (left, share_of_left) if side == 0 else (right, 1.0 - share_of_left)
                # Where a span of a segment ends within it, the next span has what is there.
                if (low > 0.0 and at < low + BORDER) or (high < 1.0 and at > high - BORDER):
                    continue
                gap = distance_at(body, part, block, j, at) - radius[s]
                if gap >= margin:
                    continue
                work.ends[0, points], work.ends[1, points] = ends
                work.share[points], work.gap[points], work.weight[points] = at, gap, weight
                work.entry[points], work.partner[points] = e, kind if kind == ALONE else FLAT_END
                work.bristle[points] = first_bristle + 2 * (s * parts + part) + side
                inverse_mass = (1.0 - at) * (1.0 - at) * arrays.inverse_mass[ends[0]]
                inverse_mass += at * at * arrays.inverse_mass[ends[1]]
                stiffness = arrays.segment_stiffness[s]
                work.numbers[0, points] = radius[s]
                work.numbers[1, points] = 2.0 * numbers.contact_damping_ratio * math.sqrt(stiffness / inverse_mass)
                work.numbers[2, points] = stiffness / numbers.contact_stiffness
                points += 1
            if kind >= 0 and points == former + 2:
                work.partner[former], work.partner[former + 1] = former + 1, former
    return points
