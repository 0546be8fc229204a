"""Closing: the winches' threads, and the joints of docked or locked neighbours round the mouth."""

from __future__ import annotations

import math

from tethernet_sim.kernels.options import inlined


@inlined
def particle(knots, mus, count, number):
    """Position or velocity of a particle, as a tuple: of one of ``count`` knots, or of a MU."""
    if number < count:
        return knots[0, number], knots[1, number], knots[2, number]
    return mus[number - count, 0], mus[number - count, 1], mus[number - count, 2]


@inlined
def distance(knot_pos, mu_pos, count, first, second):
    """Distance of two particles [m]."""
    ax, ay, az = particle(knot_pos, mu_pos, count, first)
    bx, by, bz = particle(knot_pos, mu_pos, count, second)
    return math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay) + (bz - az) * (bz - az))


@inlined
def drawn_in(rest, length, speed, pull, stiffness, time_step):
    """The rest length [m] of a spring after one step of a motor that draws it in with a limited force.

    Where the spring pulls as hard as the motor can, the motor stands still; it never works beyond its force.

    Args:
        rest: before [m].
        length: present distance of the spring's ends [m].
        speed: of the motor [m/s].
        pull: the motor's largest force [N].
        stiffness: of the spring [N/m].
        time_step: [s].
    """
    return min(rest, max(rest - speed * time_step, length - pull / stiffness, 0.0))


@inlined
def measure(knot_pos, knot_vel, mu_pos, mu_vel, count, pairs, span):
    """Find what lies between the particles of each pair: ``span`` (R, 5) is offset x y z from the first to the second
    [m], distance [m], rate of the distance [m/s].
    """
    for r in range(len(pairs)):
        ax, ay, az = particle(knot_pos, mu_pos, count, pairs[r, 0])
        bx, by, bz = particle(knot_pos, mu_pos, count, pairs[r, 1])
        dx, dy, dz = bx - ax, by - ay, bz - az
        ax, ay, az = particle(knot_vel, mu_vel, count, pairs[r, 0])
        bx, by, bz = particle(knot_vel, mu_vel, count, pairs[r, 1])
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        rate = ((bx - ax) * dx + (by - ay) * dy + (bz - az) * dz) / max(length, 1e-9)
        span[r, 0], span[r, 1], span[r, 2], span[r, 3], span[r, 4] = dx, dy, dz, length, rate


@inlined
def lock_near(span, winch, lengths, locked, winch_length, docking_distance):
    """Lock the pairs that have come near enough, at the distance they have: a joint begins without tension, and takes
    its part out of the winch's thread without changing the thread's.

    Args:
        span: of each pair, see :func:`measure`.
        winch: thread that each pair is a segment of, -1 for a pair that docks, (R,).
        lengths: rest lengths of the joints [m], (R,); updated.
        locked: which are joints, (R,); updated.
        winch_length: rest lengths of the threads [m], (S,); updated.
        docking_distance: [m].
    """
    for r in range(len(span)):
        if not locked[r]:
            lengths[r] = span[r, 3]
            if span[r, 3] < docking_distance:
                locked[r] = True
                thread = winch[r]
                if thread >= 0:
                    winch_length[thread] = max(winch_length[thread] - span[r, 3], 0.0)


@inlined
def pair_forces(
    knot_pos, knot_vel, mu_pos, mu_vel, pairs, winch, winch_begin, lengths, locked, winch_length, joint_damping,
    numbers, span, forces,
):  # fmt: skip
    """Move the winches and the joints' motors by one step, lock the pairs that have come near enough, find the force on
    the first of each pair, towards the second.

    A winch's thread slides through its closing nodes: one tension in all its segments that are not locked. The winch
    takes it in at a given speed; at its largest tension it slips, so that the thread is never shorter than that tension
    stretches it. A joint pulls only, and dampens along the line of its pair: angular momentum stays exact.

    Args:
        knot_pos: (3, width) [m].
        knot_vel: (3, width) [m/s].
        mu_pos: (M, 3) [m].
        mu_vel: (M, 3) [m/s].
        pairs: particles of each pair, (R, 2); along each winch's thread in their order.
        winch: thread that each pair is a segment of, -1 for a pair that docks, (R,).
        winch_begin: first pair of each winch's thread, and the end of the last thread, (S + 1,).
        lengths: rest lengths of the joints [m], present distances of pairs that are not locked, (R,); updated.
        locked: which are joints, (R,); updated.
        winch_length: rest length of the part of each winch's thread that is not locked [m], (S,); updated.
        joint_damping: of each pair [N s/m], (R,).
        numbers: constants of the model.
        span: work space, (R, 5).
        forces: output [N], (R, 3).
    """
    measure(knot_pos, knot_vel, mu_pos, mu_vel, numbers.knots, pairs, span)
    lock_near(span, winch, lengths, locked, winch_length, numbers.docking_distance)
    for r in range(len(pairs)):
        pull = 0.0
        if locked[r]:
            length = span[r, 3]
            lengths[r] = drawn_in(
                lengths[r], length, numbers.joint_draw_in, numbers.joint_pull, numbers.joint_stiffness,
                numbers.time_step,
            )  # fmt: skip
            pull = numbers.joint_stiffness * max(length - lengths[r], 0.0) + joint_damping[r] * span[r, 4]
            pull /= max(length, 1e-9)
        forces[r, 0], forces[r, 1], forces[r, 2] = pull * span[r, 0], pull * span[r, 1], pull * span[r, 2]
    for thread in range(len(winch_length)):
        length = 0.0
        for r in range(winch_begin[thread], winch_begin[thread + 1]):
            if not locked[r]:
                length += span[r, 3]
        taken_in = winch_length[thread] - numbers.winch_speed * numbers.time_step
        rest = max(taken_in, length - numbers.winch_tension / numbers.winch_stiffness, 0.0)
        winch_length[thread] = rest
        if length > rest:
            tension = numbers.winch_stiffness * (length - rest)
            for r in range(winch_begin[thread], winch_begin[thread + 1]):
                if not locked[r]:
                    scale = tension / span[r, 3]
                    forces[r, 0], forces[r, 1], forces[r, 2] = (
                        scale * span[r, 0], scale * span[r, 1], scale * span[r, 2],
                    )  # fmt: skip


@inlined
def apply(pairs, forces, kick, count, knot_vel, mu_force):
    """Kick the knots of each pair by one step, or add to the force on its MUs."""
    for r in range(len(pairs)):
        a, b = pairs[r, 0], pairs[r, 1]
        for axis in range(3):
            force = forces[r, axis]
            if a < count:
                knot_vel[axis, a] += kick[a] * force
            else:
                mu_force[a - count, axis] += force
            if b < count:
                knot_vel[axis, b] -= kick[b] * force
            else:
                mu_force[b - count, axis] -= force
