"""Units that meet each other, and knots and units that meet the chaser, while the net closes and after.

The same compliant law in the normal direction as with the debris, without friction. Units are spheres; neighbours that
dock with each other are made to meet and do not push. The chaser is its cube.
"""

from __future__ import annotations

import math

from tethernet_sim.kernels.options import inlined
from tethernet_sim.kernels.pairs import distance, particle
from tethernet_sim.kernels.shape_formulae import COMPILED

_box = COMPILED["box"]


@inlined
def relative_speed(one, other):
    """Of two bodies' centres of mass [m/s]."""
    dx, dy, dz = one[3] - other[3], one[4] - other[4], one[5] - other[5]
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@inlined
def near_pairs(arrays, knot_pos, mu_pos, knots, margin, listed):
    """List the pairs of units whose surfaces are nearer than ``margin`` [m]; numbers in ``arrays.meeting``.

    Returns:
        How many.
    """
    found = 0
    for p in range(len(arrays.meeting)):
        a, b = arrays.meeting[p, 0], arrays.meeting[p, 1]
        reach = arrays.mu_radius[a] + arrays.mu_radius[b] + margin
        listed[found] = p
        found += distance(knot_pos, mu_pos, knots, knots + a, knots + b) < reach
    return found


@inlined
def unit_push(arrays, numbers, p, mu_pos, mu_vel):
    """What pair ``p`` of ``arrays.meeting`` pushes its second unit away with.

    Returns:
        (force [N], the damper's part of it [N], depth [m], unit vector from the first to the second x, y, z).
    """
    a, b = arrays.meeting[p, 0], arrays.meeting[p, 1]
    dx, dy, dz = mu_pos[b, 0] - mu_pos[a, 0], mu_pos[b, 1] - mu_pos[a, 1], mu_pos[b, 2] - mu_pos[a, 2]
    apart = math.sqrt(dx * dx + dy * dy + dz * dz)
    inverse = 1.0 / max(apart, 1e-9)
    dx, dy, dz = dx * inverse, dy * inverse, dz * inverse
    depth = arrays.mu_radius[a] + arrays.mu_radius[b] - apart
    if depth <= 0.0:
        return 0.0, 0.0, 0.0, dx, dy, dz
    rate = (mu_vel[b, 0] - mu_vel[a, 0]) * dx + (mu_vel[b, 1] - mu_vel[a, 1]) * dy + (mu_vel[b, 2] - mu_vel[a, 2]) * dz
    # The damping of one unit's contact goes with the root of its mass, that of two with the root of the reduced one.
    share = math.sqrt(arrays.mu_mass[b] / (arrays.mu_mass[a] + arrays.mu_mass[b]))
    spring = numbers.contact_stiffness * numbers.mu_contact_share * depth
    force = max(spring - arrays.contact_damping[numbers.knots + a] * share * rate, 0.0)
    return force, force - spring, depth, dx, dy, dz


@inlined
def units(arrays, numbers, listed, count, mu_pos, mu_vel, mu_force):
    """Add what units that touch push each other with to ``mu_force`` (M, 3) [N]."""
    for entry in range(count):
        p = listed[entry]
        force, _, _, nx, ny, nz = unit_push(arrays, numbers, p, mu_pos, mu_vel)
        a, b = arrays.meeting[p, 0], arrays.meeting[p, 1]
        for m, sign in ((a, -1.0), (b, 1.0)):
            mu_force[m, 0] += sign * force * nx
            mu_force[m, 1] += sign * force * ny
            mu_force[m, 2] += sign * force * nz


@inlined
def near_chaser(knot_pos, mu_pos, knots, numbers, chaser, margin, listed):
    """List the particles that are nearer to the chaser than ``margin`` [m].

    Returns:
        How many.
    """
    reach = math.sqrt(3.0) * numbers.chaser_half_side + max(numbers.knot_radius, numbers.mu_radius) + margin
    found = 0
    for number in range(knots + len(mu_pos)):
        x, y, z = particle(knot_pos, mu_pos, knots, number)
        dx, dy, dz = x - chaser[0], y - chaser[1], z - chaser[2]
        listed[found] = number
        found += dx * dx + dy * dy + dz * dz < reach * reach
    return found


@inlined
def chaser_push(arrays, numbers, number, place, speed, chaser, matrix, rate):
    """What the chaser pushes one particle away with.

    Args:
        arrays: constants of the model.
        numbers: likewise.
        number: of the particle.
        place: of it, x y z [m].
        speed: of it, x y z [m/s].
        chaser: body state (13,).
        matrix: its rotation (3, 3).
        rate: its angular rate, launch frame [rad/s].

    Returns:
        (force [N], the damper's part of it [N], depth [m], stiffness [N/m], outward normal, launch frame, x, y, z).
    """
    dx, dy, dz = place[0] - chaser[0], place[1] - chaser[1], place[2] - chaser[2]
    half = numbers.chaser_half_side
    gap, ux, uy, uz = _box(
        (half, half, half),
        matrix[0, 0] * dx + matrix[1, 0] * dy + matrix[2, 0] * dz,
        matrix[0, 1] * dx + matrix[1, 1] * dy + matrix[2, 1] * dz,
        matrix[0, 2] * dx + matrix[1, 2] * dy + matrix[2, 2] * dz,
    )
    nx, ny, nz = (
        matrix[0, 0] * ux + matrix[0, 1] * uy + matrix[0, 2] * uz,
        matrix[1, 0] * ux + matrix[1, 1] * uy + matrix[1, 2] * uz,
        matrix[2, 0] * ux + matrix[2, 1] * uy + matrix[2, 2] * uz,
    )
    radius, stiffness = numbers.knot_radius, numbers.contact_stiffness
    if number >= numbers.knots:
        radius, stiffness = arrays.mu_radius[number - numbers.knots], stiffness * numbers.mu_contact_share
    depth = radius - gap
    if depth <= 0.0:
        return 0.0, 0.0, 0.0, stiffness, nx, ny, nz
    vx = speed[0] - chaser[3] - (rate[1] * dz - rate[2] * dy)
    vy = speed[1] - chaser[4] - (rate[2] * dx - rate[0] * dz)
    vz = speed[2] - chaser[5] - (rate[0] * dy - rate[1] * dx)
    spring = stiffness * depth
    force = max(spring - arrays.contact_damping[number] * (vx * nx + vy * ny + vz * nz), 0.0)
    return force, force - spring, depth, stiffness, nx, ny, nz


@inlined
def on_chaser(
    arrays, numbers, listed, count, knot_pos, knot_vel, mu_pos, mu_vel, chaser, matrix, rate, pushes, force, torque
):  # fmt: skip
    """Find what the chaser pushes the listed particles with, and what they push it with.

    Args:
        arrays: constants of the model.
        numbers: likewise.
        listed: the particles.
        count: how many.
        knot_pos, knot_vel, mu_pos, mu_vel: of all.
        chaser: body state (13,).
        matrix: its rotation (3, 3).
        rate: its angular rate, launch frame [rad/s].
        pushes: output, force on each listed particle [N], (., 3).
        force: output, on the chaser [N], (3,).
        torque: output, on the chaser about its centre [N m], (3,).
    """
    for axis in range(3):
        force[axis], torque[axis] = 0.0, 0.0
    for entry in range(count):
        number = listed[entry]
        place = particle(knot_pos, mu_pos, numbers.knots, number)
        speed = particle(knot_vel, mu_vel, numbers.knots, number)
        push, _, _, _, nx, ny, nz = chaser_push(arrays, numbers, number, place, speed, chaser, matrix, rate)
        fx, fy, fz = push * nx, push * ny, push * nz
        pushes[entry, 0], pushes[entry, 1], pushes[entry, 2] = fx, fy, fz
        dx, dy, dz = place[0] - chaser[0], place[1] - chaser[1], place[2] - chaser[2]
        force[0], force[1], force[2] = force[0] - fx, force[1] - fy, force[2] - fz
        torque[0] -= dy * fz - dz * fy
        torque[1] -= dz * fx - dx * fz
        torque[2] -= dx * fy - dy * fx


@inlined
def react(listed, count, pushes, kick, knots, knot_vel, mu_force):
    """Kick the listed knots by one step, add to the force on the listed units."""
    for entry in range(count):
        number = listed[entry]
        for axis in range(3):
            if number < knots:
                knot_vel[axis, number] += kick[number] * pushes[entry, axis]
            else:
                mu_force[number - knots, axis] += pushes[entry, axis]
