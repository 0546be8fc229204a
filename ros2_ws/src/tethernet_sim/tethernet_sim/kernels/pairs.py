"""Closing: winch segments, docking and locked joints between neighbours round the mouth."""

from __future__ import annotations

import math

from .options import kernel


@kernel
def pair_force(dx, dy, dz, vx, vy, vz, length, locked, model, force):
    """Force on the first of a pair, towards the second.

    An unlocked pair is a segment of the winch's thread: tension only, limited. A locked pair is a joint: an unlimited tension-only
    spring towards its shrinking rest length, with a damper in all directions, because two docked units do not orbit each other.

    Args:
        dx, dy, dz: from the first to the second [m].
        vx, vy, vz: velocity of the second relative to the first [m/s].
        length: rest length [m].
        locked: whether it is a joint.
        model: constants.
        force: output [N], (3,).
    """
    length_now = math.sqrt(dx * dx + dy * dy + dz * dz)
    inverse = 1.0 / length_now if length_now > 0.0 else 0.0
    stretch = length_now - length
    if locked:
        pull = model.joint_stiffness * max(stretch, 0.0) * inverse
        force[0] = pull * dx + model.joint_damping * vx
        force[1] = pull * dy + model.joint_damping * vy
        force[2] = pull * dz + model.joint_damping * vz
        return
    pull = 0.0
    if stretch > 0.0 and model.winch_speed > 0.0:
        stretching = (vx * dx + vy * dy + vz * dz) * inverse
        pull = model.winch_stiffness * stretch + model.winch_damping * stretching
        pull = min(max(pull, 0.0), model.winch_tension) * inverse
    force[0] = pull * dx
    force[1] = pull * dy
    force[2] = pull * dz


@kernel
def reel_in(length_now, length, locked, model, duration):
    """Rest length after ``duration`` [s], and whether the pair is locked now.

    Args:
        length_now: distance of the pair [m].
        length: rest length [m].
        locked: whether it was locked.
        model: constants.
        duration: [s].
    """
    if not locked and length_now < model.docking_distance:
        locked = True
        length = length_now
    speed = model.joint_draw_in if locked else model.winch_speed
    return max(length - speed * duration, 0.0), locked
