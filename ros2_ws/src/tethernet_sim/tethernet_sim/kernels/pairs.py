"""Closing: the winches' threads, and the joints of docked or locked neighbours round the mouth."""

from __future__ import annotations

import math

from tethernet_sim.kernels.options import leaf
from tethernet_sim.model import KNOTS


@leaf
def particle(knots, mus, number):
    """Position or velocity of a particle, as a tuple."""
    if number < KNOTS:
        return knots[0, number], knots[1, number], knots[2, number]
    return mus[number - KNOTS, 0], mus[number - KNOTS, 1], mus[number - KNOTS, 2]


@leaf
def distance(knot_pos, mu_pos, first, second):
    """Distance of two particles [m]."""
    ax, ay, az = particle(knot_pos, mu_pos, first)
    bx, by, bz = particle(knot_pos, mu_pos, second)
    return math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay) + (bz - az) * (bz - az))


@leaf
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


@leaf
def measure(knot_pos, knot_vel, mu_pos, mu_vel, pairs, span):
    """Find what lies between the particles of each pair: ``span`` (R, 5) is offset x y z from the first to the second
    [m], distance [m], rate of the distance [m/s].
    """
    for r in range(len(pairs)):
        ax, ay, az = particle(knot_pos, mu_pos, pairs[r, 0])
        bx, by, bz = particle(knot_pos, mu_pos, pairs[r, 1])
        dx, dy, dz = bx - ax, by - ay, bz - az
        ax, ay, az = particle(knot_vel, mu_vel, pairs[r, 0])
        bx, by, bz = particle(knot_vel, mu_vel, pairs[r, 1])
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        rate = ((bx - ax) * dx + (by - ay) * dy + (bz - az) * dz) / max(length, 1e-9)
        span[r, 0], span[r, 1], span[r, 2], span[r, 3], span[r, 4] = dx, dy, dz, length, rate


@leaf
def lock_near(span, segments, lengths, locked, winch_length, numbers):
    """Lock the pairs that have come near enough, at the distance they have: a joint begins without tension, and takes
    its part out of the winch's thread without changing the thread's.

    Args:
        span: of each pair, see :func:`measure`.
        segments: pairs that one winch's thread runs through; 0 where MUs dock.
        lengths: rest lengths of the joints [m], (R,); updated.
        locked: which are joints, (R,); updated.
        winch_length: rest lengths of the threads [m], (S,); updated.
        numbers: constants of the model.
    """
    for r in range(len(span)):
        if not locked[r]:
            lengths[r] = span[r, 3]
            if span[r, 3] < numbers.docking_distance:
                locked[r] = True
                if segments:
                    thread = r // segments
                    winch_length[thread] = max(winch_length[thread] - span[r, 3], 0.0)


@leaf
def pair_forces(
    knot_pos, knot_vel, mu_pos, mu_vel, pairs, lengths, locked, winch_length, joint_damping, numbers, span, forces
):  # fmt: skip
    """Move the winches and the joints' motors by one step, lock the pairs that have come near enough, find the force on
    the first of each pair, towards the second.

    A winch's thread slides through its closing nodes: one tension in all its segments that are not locked. The winch
    takes it in at a given speed; at its largest tension it slips, so that the thread is never shorter than that tension
    stretches it. A joint pulls only, and dampens along the line of its pair: angular momentum stays exact.

    Args:
        knot_pos: (3, 529) [m].
        knot_vel: (3, 529) [m/s].
        mu_pos: (M, 3) [m].
        mu_vel: (M, 3) [m/s].
        pairs: particles of each pair, all knots or all MUs, (R, 2); along each winch's thread in their order.
        lengths: rest lengths of the joints [m], present distances of pairs that are not locked, (R,); updated.
        locked: which are joints, (R,); updated.
        winch_length: rest length of the part of each winch's thread that is not locked [m], (S,), empty where MUs dock;
            updated.
        joint_damping: of each pair [N s/m], (R,).
        numbers: constants of the model.
        span: work space, (R, 5).
        forces: output [N], (R, 3).
    """
    threads = len(winch_length)
    segments = len(pairs) // threads if threads else 0
    measure(knot_pos, knot_vel, mu_pos, mu_vel, pairs, span)
    lock_near(span, segments, lengths, locked, winch_length, numbers)
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
    for thread in range(threads):
        length = 0.0
        for r in range(thread * segments, (thread + 1) * segments):
            if not locked[r]:
                length += span[r, 3]
        taken_in = winch_length[thread] - numbers.winch_speed * numbers.time_step
        rest = max(taken_in, length - numbers.winch_tension / numbers.winch_stiffness, 0.0)
        winch_length[thread] = rest
        if length > rest:
            tension = numbers.winch_stiffness * (length - rest)
            for r in range(thread * segments, (thread + 1) * segments):
                if not locked[r]:
                    scale = tension / span[r, 3]
                    forces[r, 0], forces[r, 1], forces[r, 2] = (
                        scale * span[r, 0], scale * span[r, 1], scale * span[r, 2],
                    )  # fmt: skip


@leaf
def apply(pairs, forces, kick, knot_vel, mu_force):
    """Kick the knots of each pair by one step, or add to the force on its MUs."""
    docks = pairs[0, 0] >= KNOTS
    for r in range(len(pairs)):
        a, b = pairs[r, 0], pairs[r, 1]
        for axis in range(3):
            if docks:
                mu_force[a - KNOTS, axis] += forces[r, axis]
                mu_force[b - KNOTS, axis] -= forces[r, axis]
            else:
                knot_vel[axis, a] += kick[a] * forces[r, axis]
                knot_vel[axis, b] -= kick[b] * forces[r, axis]
