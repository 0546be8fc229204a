"""Closing: winch segments, docking and locked joints between neighbours round the mouth."""

from __future__ import annotations

import math

from tethernet_sim.model import KNOTS

from .options import leaf


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
def pair_forces(knot_pos, knot_vel, mu_pos, mu_vel, pairs, lengths, locked, numbers, forces):
    """Shorten the pairs' rest lengths by one step, lock those that have come near enough, find the force on the first
    of each pair, towards the second.

    An unlocked pair is a segment of the winch's thread: tension only, limited. A locked pair is a joint: a tension-only
    spring towards its shrinking rest length, without limit, and a damper in all directions, because two docked units do
    not orbit each other.

    Args:
        knot_pos: (3, 529) [m].
        knot_vel: (3, 529) [m/s].
        mu_pos: (M, 3) [m].
        mu_vel: (M, 3) [m/s].
        pairs: particles of each pair, all knots or all MUs, (R, 2).
        lengths: rest lengths [m], (R,); updated.
        locked: which are joints, (R,); updated.
        numbers: constants of the model.
        forces: output [N], (R, 3).
    """
    docking_squared = numbers.docking_distance * numbers.docking_distance
    docks = pairs[0, 0] >= KNOTS
    for r in range(len(pairs)):
        a, b = pairs[r, 0], pairs[r, 1]
        if docks:
            a, b = a - KNOTS, b - KNOTS
            dx, dy, dz = mu_pos[b, 0] - mu_pos[a, 0], mu_pos[b, 1] - mu_pos[a, 1], mu_pos[b, 2] - mu_pos[a, 2]
            vx, vy, vz = mu_vel[b, 0] - mu_vel[a, 0], mu_vel[b, 1] - mu_vel[a, 1], mu_vel[b, 2] - mu_vel[a, 2]
        else:
            dx, dy, dz = (
                knot_pos[0, b] - knot_pos[0, a],
                knot_pos[1, b] - knot_pos[1, a],
                knot_pos[2, b] - knot_pos[2, a],
            )
            vx, vy, vz = (
                knot_vel[0, b] - knot_vel[0, a],
                knot_vel[1, b] - knot_vel[1, a],
                knot_vel[2, b] - knot_vel[2, a],
            )
        squared = dx * dx + dy * dy + dz * dz
        if not locked[r] and squared < docking_squared:
            locked[r] = True
            lengths[r] = math.sqrt(squared)
        speed = numbers.joint_draw_in if locked[r] else numbers.winch_speed
        rest = max(lengths[r] - speed * numbers.time_step, 0.0)
        lengths[r] = rest
        pull, drag = 0.0, 0.0
        if locked[r]:
            drag = numbers.joint_damping
            if squared > rest * rest:
                pull = numbers.joint_stiffness * (1.0 - rest / math.sqrt(squared))
        elif numbers.winch_speed > 0.0 and squared > rest * rest:
            inverse = 1.0 / math.sqrt(squared)
            stretching = (vx * dx + vy * dy + vz * dz) * inverse
            pull = numbers.winch_stiffness * (squared * inverse - rest) + numbers.winch_damping * stretching
            pull = min(max(pull, 0.0), numbers.winch_tension) * inverse
        forces[r, 0], forces[r, 1], forces[r, 2] = pull * dx + drag * vx, pull * dy + drag * vy, pull * dz + drag * vz


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
