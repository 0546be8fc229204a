"""What acts where threads touch the debris: the law of contact at the points that
:mod:`~tethernet_sim.kernels.thread_points` finds.
"""

from __future__ import annotations

import math

from tethernet_sim.kernels import contact, debris_body
from tethernet_sim.kernels.options import inlined
from tethernet_sim.kernels.thread_points import ALONE, EDGE_M, FLAT, LEAST_SQUARE, place, share_at_edge


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
def forget_bristles(bristles, begin):
    """Set those of all threads back, which begin at ``begin``."""
    for number in range(begin, len(bristles)):
        for axis in range(3):
            bristles[number, axis] = 0.0


@inlined
def gather(
    work, points, knot_pos, knot_vel, mu_pos, mu_vel, body, debris, matrix, knots, within_reach, contact_work
):  # fmt: skip
    """Copy what the law of contact needs of the points that touch to ``contact_work``; the others' bristles are
    forgotten. Points farther away than ``within_reach`` [m] at the search cannot touch yet.

    Returns:
        How many touch.
    """
    px, py, pz = debris[0], debris[1], debris[2]
    frame = debris_body.frame(body, matrix)
    active = 0
    for p in range(points):
        work.found[1, p] = 0.0
        if work.gap[p] > within_reach:
            continue
        share, i, j = work.share[p], work.ends[0, p], work.ends[1, p]
        other = 1.0 - share
        ax, ay, az = place(knot_pos, mu_pos, knots, i)
        bx, by, bz = place(knot_pos, mu_pos, knots, j)
        lx, ly, lz = bx - ax, by - ay, bz - az
        dx, dy, dz = other * ax + share * bx - px, other * ay + share * by - py, other * az + share * bz - pz
        if not debris_body.within(body, frame, debris_body.inflated(body, work.numbers[0, p]), dx, dy, dz):
            for axis in range(3):
                work.held[axis, p] = 0.0
            continue
        k = contact.column(active)
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
        weight = work.weight[p]
        stiffness = weight * work.numbers[2, p]
        contact_work[k + 12 * contact.BLOCK] = work.numbers[0, p]
        contact_work[k + 13 * contact.BLOCK] = weight * work.numbers[1, p]
        contact_work[k + 14 * contact.BLOCK] = stiffness
        contact_work[k + 15 * contact.BLOCK] = 1.0 / stiffness
        # At its end a segment touches like the particle there.
        between = 1.0 if 0.0 < share < 1.0 else 0.0
        contact_work[k + 16 * contact.BLOCK] = between * lx
        contact_work[k + 17 * contact.BLOCK] = between * ly
        contact_work[k + 18 * contact.BLOCK] = between * lz
        contact_work[k + 19 * contact.BLOCK] = 1.0 / max(lx * lx + ly * ly + lz * lz, LEAST_SQUARE)
    return active


@inlined
def follow_edge(work, first, second, length):
    """Move the two points of a segment so that the edge stays between them; ``length`` of the segment [m].

    Both depths are as good as straight lines, which cross where the edge is. Where both points are on the same side of
    it, they go on by their distance.
    """
    left, right = work.share[first], work.share[second]
    left_slope, right_slope = work.found[0, first], work.found[0, second]
    half = 0.5 * EDGE_M / max(length, EDGE_M)
    if left_slope >= 0.0:
        middle = left - half
    elif right_slope <= 0.0:
        middle = right + half
    else:
        middle = work.found[1, first] - work.found[1, second] + left_slope * left - right_slope * right
        middle = min(max(middle / (left_slope - right_slope), left), right)
    share = share_at_edge(left_slope, right_slope, FLAT * length)
    work.weight[first], work.weight[second] = share, 1.0 - share
    left, right = max(middle - half, 0.0), min(middle + half, 1.0)
    work.share[first], work.share[second] = left, right
    work.place[0, work.entry[first]], work.place[1, work.entry[first]] = left, right


@inlined
def react(work, active, contact_work, kick, knots, knot_vel, mu_force, time_step):
    """Kick the ends of the touching segments by one step, keep the bristles. The points stay where they are in space
    while their threads slide along themselves through them: a thread touches an edge where the edge is.
    """
    for a in range(active):
        k, p = contact.column(a), work.active[a]
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
        share = min(max(share - time_step * contact_work[k + 16 * contact.BLOCK], 0.0), 1.0)
        work.share[p] = share
        work.found[0, p] = contact_work[k + 17 * contact.BLOCK]
        work.found[1, p] = contact_work[k + 18 * contact.BLOCK]
        other = work.partner[p]
        if other >= 0:
            # The first of both is gathered first.
            if other < p and work.found[1, p] > 0.0 and work.found[1, other] > 0.0:
                follow_edge(work, other, p, 1.0 / math.sqrt(contact_work[k + 19 * contact.BLOCK]))
        elif other == ALONE:
            work.place[0, work.entry[p]] = work.place[1, work.entry[p]] = share
