"""Closing: winch segments, docking and locked joints between neighbours round the mouth."""

from __future__ import annotations

import math

from tethernet_sim.model import KNOTS

from .options import kernel


@kernel
def particle(knots, mus, number):
    """Position or velocity of a particle, as a tuple."""
    if number < KNOTS:
        return knots[0, number], knots[1, number], knots[2, number]
    return mus[number - KNOTS, 0], mus[number - KNOTS, 1], mus[number - KNOTS, 2]


@kernel
def distance(knot_pos, mu_pos, first, second):
    """Distance of two particles [m]."""
    ax, ay, az = particle(knot_pos, mu_pos, first)
    bx, by, bz = particle(knot_pos, mu_pos, second)
    return math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay) + (bz - az) * (bz - az))


@kernel
def pair_forces(knot_pos, knot_vel, mu_pos, mu_vel, pairs, lengths, locked, numbers, forces):
    """Force on the first of each pair, towards the second.

    An unlocked pair is a segment of the winch's thread: tension only, limited. A locked pair is a joint: a tension-only
    spring towards its shrinking rest length, without limit, and a damper in all directions, because two docked units do
    not orbit each other.

    Args:
        knot_pos: (3, 529) [m].
        knot_vel: (3, 529) [m/s].
        mu_pos: (M, 3) [m].
        mu_vel: (M, 3) [m/s].
        pairs: particles of each pair, (R, 2).
        lengths: rest lengths [m], (R,).
        locked: which are joints, (R,).
        numbers: constants of the model.
        forces: output [N], (R, 3).
    """
    for r in range(len(pairs)):
        ax, ay, az = particle(knot_pos, mu_pos, pairs[r, 0])
        bx, by, bz = particle(knot_pos, mu_pos, pairs[r, 1])
        ux, uy, uz = particle(knot_vel, mu_vel, pairs[r, 0])
        vx, vy, vz = particle(knot_vel, mu_vel, pairs[r, 1])
        dx, dy, dz = bx - ax, by - ay, bz - az
        vx, vy, vz = vx - ux, vy - uy, vz - uz
        apart = math.sqrt(dx * dx + dy * dy + dz * dz)
        inverse = 1.0 / apart if apart > 0.0 else 0.0
        stretch = apart - lengths[r]
        pull, drag = 0.0, 0.0
        if locked[r]:
            pull = numbers.joint_stiffness * max(stretch, 0.0) * inverse
            drag = numbers.joint_damping
        elif stretch > 0.0 and numbers.winch_speed > 0.0:
            stretching = (vx * dx + vy * dy + vz * dz) * inverse
            pull = numbers.winch_stiffness * stretch + numbers.winch_damping * stretching
            pull = min(max(pull, 0.0), numbers.winch_tension) * inverse
        forces[r, 0] = pull * dx + drag * vx
        forces[r, 1] = pull * dy + drag * vy
        forces[r, 2] = pull * dz + drag * vz


@kernel
def apply(pairs, forces, kick, knot_vel, mu_force):
    """Kick the knots of each pair by one step, or add to the force on its MUs."""
    for r in range(len(pairs)):
        a, b = pairs[r, 0], pairs[r, 1]
        for axis in range(3):
            if a >= KNOTS:
                mu_force[a - KNOTS, axis] += forces[r, axis]
                mu_force[b - KNOTS, axis] -= forces[r, axis]
            else:
                knot_vel[axis, a] += kick[a] * forces[r, axis]
                knot_vel[axis, b] -= kick[b] * forces[r, axis]


@kernel
def reel_in(knot_pos, mu_pos, pairs, lengths, locked, numbers):
    """Shorten the rest lengths by one step; lock the pairs that have come near enough."""
    for r in range(len(pairs)):
        if not locked[r]:
            apart = distance(knot_pos, mu_pos, pairs[r, 0], pairs[r, 1])
            if apart < numbers.docking_distance:
                locked[r] = True
                lengths[r] = apart
        speed = numbers.joint_draw_in if locked[r] else numbers.winch_speed
        lengths[r] = max(lengths[r] - speed * numbers.time_step, 0.0)
