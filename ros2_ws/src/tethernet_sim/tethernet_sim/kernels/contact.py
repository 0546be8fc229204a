"""Contact of knots and MUs, as small spheres, with the debris' cylinder: compliant normal force, scaled-box
friction.
"""

from __future__ import annotations

import math

import numpy as np

from ..model import KNOTS
from .listing import listed
from .options import leaf

SPEED_FACTOR, SPEED_MARGIN_M_S = 2.0, 2.0
"""Until the next search no particle gets faster relative to the debris than this factor times the fastest now, plus
this margin: a thread that snaps taut can at most reverse a relative velocity."""
NEAR_STEPS = 10
"""Steps between two searches while particles are near the debris."""
ROOM = 536
"""Room for all knots, in whole cache lines."""
FAR_STEPS = 500
"""Steps between two searches at the most."""
FAR_AWAY = 1e3
"""Nothing touches the debris at this distance along each axis [m]."""


@leaf
def surface(rx, ry, rz, radius, half_length):
    """Signed distance of a point from a cylinder, and the outward normal there.

    Args:
        rx: x of the point in the cylinder's frame, whose z is the cylinder's axis [m].
        ry: y of the point [m].
        rz: z of the point [m].
        radius: of the cylinder [m].
        half_length: of the cylinder [m].

    Returns:
        Distance [m], negative inside; x, y, z of the unit normal.
    """
    radial = math.sqrt(rx * rx + ry * ry)
    side = radial - radius
    flat = abs(rz) - half_length
    inverse = 1.0 / radial if radial > 0.0 else 0.0
    up = 1.0 if rz >= 0.0 else -1.0
    if side > 0.0 and flat > 0.0:
        distance = math.sqrt(side * side + flat * flat)
        share = side / distance * inverse
        return distance, share * rx, share * ry, flat / distance * up
    if side > flat:
        return side, rx * inverse, ry * inverse, 0.0
    return flat, 0.0, 0.0, up


@leaf
def fastest(knot_vel, mu_vel, debris, spin, reach, squared, ordered):
    """Bound of any particle's speed relative to the debris' material until the next search [m/s].

    Args:
        knot_vel: (3, ROOM) [m/s].
        mu_vel: (M, 3) [m/s].
        debris: body state (13,).
        spin: magnitude of its angular rate [rad/s].
        reach: its farthest point from its centre [m].
        squared: work space, (ROOM,).
        ordered: the same numbers' bits, unsigned, (ROOM,).
    """
    vx, vy, vz = debris[3], debris[4], debris[5]
    x, y, z = knot_vel[0], knot_vel[1], knot_vel[2]
    for i in range(KNOTS):
        dx, dy, dz = x[i] - vx, y[i] - vy, z[i] - vz
        squared[i] = dx * dx + dy * dy + dz * dz
    # Bits of numbers that are not negative are in the numbers' order, NaN last. Unlike numbers, which can be NaN, they
    # are compared vectorised.
    top = np.uint64(0)
    for i in range(KNOTS):
        top = max(top, ordered[i])
    most = np.uint64(top).view(np.float64)
    for m in range(len(mu_vel)):
        dx, dy, dz = mu_vel[m, 0] - vx, mu_vel[m, 1] - vy, mu_vel[m, 2] - vz
        most = max(most, dx * dx + dy * dy + dz * dz)
    return SPEED_FACTOR * (math.sqrt(most) + spin * reach) + SPEED_MARGIN_M_S


@leaf
def find_candidates(
    knot_pos, mu_pos, debris, matrix, numbers, speed, side, others, squared, ordered, along, flags, blocks, busy
):
    """List the particles that may touch the debris before the next search.

    Args:
        knot_pos: (3, ROOM) [m].
        mu_pos: (M, 3) [m].
        debris: body state (13,).
        matrix: its rotation (3, 3).
        numbers: constants of the model.
        speed: bound of any particle's relative speed until then [m/s].
        side: output, knots that can touch nothing but the cylinder's side until then.
        others: output, all other particles: MUs, knots near the flat ends.
        squared: work space, (ROOM,).
        ordered: the same numbers' bits, unsigned, (ROOM,).
        along: work space, (ROOM,).
        flags: work space, one byte for each knot, zeros beyond, (ROOM,).
        blocks: the same bytes, eight in one, (ROOM / 8,).
        busy: work space, (ROOM,).

    Returns:
        (how many are listed in ``side``, in ``others``, steps until the next search is due).
    """
    radius, half_length = numbers.debris_radius, numbers.debris_half_length
    reach = math.sqrt(radius * radius + half_length * half_length) + max(numbers.knot_radius, numbers.mu_radius)
    margin = speed * NEAR_STEPS * numbers.time_step
    mus = mu_pos.shape[0]
    px, py, pz = debris[0], debris[1], debris[2]
    ax, ay, az = matrix[0, 2], matrix[1, 2], matrix[2, 2]
    x, y, z = knot_pos[0], knot_pos[1], knot_pos[2]
    for i in range(KNOTS):
        dx, dy, dz = x[i] - px, y[i] - py, z[i] - pz
        squared[i] = dx * dx + dy * dy + dz * dz
        along[i] = ax * dx + ay * dy + az * dz
    bottom = ordered[0]
    for i in range(KNOTS):
        bottom = min(bottom, ordered[i])
    nearest = np.uint64(bottom).view(np.float64)
    for m in range(mus):
        dx, dy, dz = mu_pos[m, 0] - px, mu_pos[m, 1] - py, mu_pos[m, 2] - pz
        nearest = min(nearest, dx * dx + dy * dy + dz * dz)
    if nearest > (reach + margin) * (reach + margin):
        return 0, 0, min(FAR_STEPS, int((math.sqrt(nearest) - reach) / (speed * numbers.time_step)))
    # Within the sphere round the debris: a cylinder that is larger all round decides, without roots.
    size = numbers.knot_radius
    wide, long = (radius + size + margin) * (radius + size + margin), half_length + size + margin
    for i in range(KNOTS):
        flags[i] = (squared[i] - along[i] * along[i] < wide) & (abs(along[i]) < long)
    count = listed(flags, blocks, busy, side)
    side_count, others_count = 0, 0
    for j in range(count):
        i = side[j]
        if abs(along[i]) < half_length - size - margin:
            side[side_count] = i
            side_count += 1
        else:
            others[others_count] = i
            others_count += 1
    size = numbers.mu_radius
    wide, long = (radius + size + margin) * (radius + size + margin), half_length + size + margin
    for m in range(mus):
        dx, dy, dz = mu_pos[m, 0] - px, mu_pos[m, 1] - py, mu_pos[m, 2] - pz
        axial = ax * dx + ay * dy + az * dz
        if dx * dx + dy * dy + dz * dz - axial * axial < wide and abs(axial) < long:
            others[others_count] = KNOTS + m
            others_count += 1
    return side_count, others_count, NEAR_STEPS


@leaf
def fetch_bristles(bristles, side, count, held):
    """Copy the bristles of the ``side`` knots to ``held`` (3, ROOM)."""
    for j in range(count):
        for axis in range(3):
            held[axis, j] = bristles[side[j], axis]


@leaf
def store_bristles(bristles, side, count, held):
    """Copy the bristles of the ``side`` knots back."""
    for j in range(count):
        for axis in range(3):
            bristles[side[j], axis] = held[axis, j]


@leaf
def find_touching(knot_pos, debris, matrix, numbers, side, count, held, kept, touching):
    """List which of the ``side`` knots touch: most of them only hover. The others' bristles are forgotten.

    Args:
        knot_pos: (3, ROOM) [m].
        debris: body state (13,).
        matrix: its rotation (3, 3).
        numbers: constants of the model.
        side: knots to look at.
        count: how many.
        held: their bristles [m], (3, ROOM); updated.
        kept: work space, (ROOM,).
        touching: output, where in ``side`` the touching ones are, (ROOM + 1,).

    Returns:
        How many touch.
    """
    size = numbers.debris_radius + numbers.knot_radius
    size_squared = size * size
    px, py, pz = debris[0], debris[1], debris[2]
    m00, m10, m20 = matrix[0, 0], matrix[1, 0], matrix[2, 0]
    m01, m11, m21 = matrix[0, 1], matrix[1, 1], matrix[2, 1]
    x, y, z = knot_pos[0], knot_pos[1], knot_pos[2]
    found = np.uint64(0)
    for j in range(count):
        i = side[j]
        dx, dy, dz = x[i] - px, y[i] - py, z[i] - pz
        rx, ry = m00 * dx + m10 * dy + m20 * dz, m01 * dx + m11 * dy + m21 * dz
        touches = rx * rx + ry * ry < size_squared
        touching[found] = j
        found += np.uint64(touches)
        kept[j] = touches
    for axis in range(3):
        bristle = held[axis]
        for j in range(count):
            bristle[j] *= kept[j]
    return np.int64(found)


@leaf
def gather(knot_pos, knot_vel, debris, side, held, touching, count, work):
    """Copy what :func:`side_forces` needs of the touching ``side`` knots to ``work``, and fill up a whole vector.

    Returns:
        How many ``work`` holds; those beyond ``count`` touch nothing.
    """
    px, py, pz = debris[0], debris[1], debris[2]
    for k in range(count):
        j = touching[k]
        i = side[j]
        work[k], work[k + ROOM], work[k + 2 * ROOM] = knot_pos[0, i] - px, knot_pos[1, i] - py, knot_pos[2, i] - pz
        work[k + 3 * ROOM], work[k + 4 * ROOM] = knot_vel[0, i], knot_vel[1, i]
        work[k + 5 * ROOM] = knot_vel[2, i]
        work[k + 6 * ROOM], work[k + 7 * ROOM], work[k + 8 * ROOM] = held[0, j], held[1, j], held[2, j]
    filled = (count + 7) // 8 * 8
    for k in range(count, filled):
        for row in range(3):
            work[k + row * ROOM] = FAR_AWAY
        for row in range(3, 9):
            work[k + row * ROOM] = 0.0
    return filled


@leaf
def side_forces(work, count, debris, matrix, rate, numbers, force, torque):
    """What :func:`contact_forces` does, for knots that touch the cylinder's side only; without branches, so that it
    vectorises.

    Args:
        work: one row of ROOM numbers for each of: position relative to the debris' centre [m], velocity [m/s], bristle
            in the debris frame [m] (updated), force on the knot [N] (output); each x, y, z.
        count: how many knots.
        debris: body state (13,).
        matrix: its rotation (3, 3).
        rate: its angular rate, launch frame [rad/s].
        numbers: constants of the model.
        force: on the debris [N], (3,); added to.
        torque: on the debris about its centre of mass [N m], (3,); added to.
    """
    size, damping = numbers.debris_radius + numbers.knot_radius, numbers.knot_contact_damping
    stiffness, softness, dt = numbers.contact_stiffness, 1.0 / numbers.contact_stiffness, numbers.time_step
    friction = numbers.friction
    qx, qy, qz = debris[3], debris[4], debris[5]
    wx, wy, wz = rate[0], rate[1], rate[2]
    m00, m01, m02 = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    m10, m11, m12 = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    m20, m21, m22 = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    sx, sy, sz, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(count):
        dx, dy, dz = work[j], work[j + ROOM], work[j + 2 * ROOM]
        vx = work[j + 3 * ROOM] - qx - (wy * dz - wz * dy)
        vy = work[j + 4 * ROOM] - qy - (wz * dx - wx * dz)
        vz = work[j + 5 * ROOM] - qz - (wx * dy - wy * dx)
        rx, ry = m00 * dx + m10 * dy + m20 * dz, m01 * dx + m11 * dy + m21 * dz
        ux, uy, uz = m00 * vx + m10 * vy + m20 * vz, m01 * vx + m11 * vy + m21 * vz, m02 * vx + m12 * vy + m22 * vz
        squared = rx * rx + ry * ry
        inverse = 1.0 / math.sqrt(max(squared, 1e-300))
        nx, ny = rx * inverse, ry * inverse
        depth = size - squared * inverse
        pressing = max(stiffness * depth - damping * (ux * nx + uy * ny), 0.0)
        pressing = pressing if depth > 0.0 else 0.0
        limit = friction * pressing
        most = limit * softness
        slide = ux * ny - uy * nx
        along = work[j + 8 * ROOM] + dt * uz
        round_ = work[j + 6 * ROOM] * ny - work[j + 7 * ROOM] * nx + dt * slide
        force_along = min(max(-stiffness * along - damping * uz, -limit), limit)
        force_round = min(max(-stiffness * round_ - damping * slide, -limit), limit)
        along, round_ = min(max(along, -most), most), min(max(round_, -most), most)
        work[j + 6 * ROOM], work[j + 7 * ROOM], work[j + 8 * ROOM] = round_ * ny, -round_ * nx, along
        bx, by, bz = pressing * nx + force_round * ny, pressing * ny - force_round * nx, force_along
        fx, fy, fz = m00 * bx + m01 * by + m02 * bz, m10 * bx + m11 * by + m12 * bz, m20 * bx + m21 * by + m22 * bz
        work[j + 9 * ROOM], work[j + 10 * ROOM], work[j + 11 * ROOM] = fx, fy, fz
        sx, sy, sz = sx + fx, sy + fy, sz + fz
        tx, ty, tz = tx + (dy * fz - dz * fy), ty + (dz * fx - dx * fz), tz + (dx * fy - dy * fx)
    force[0], force[1], force[2] = force[0] - sx, force[1] - sy, force[2] - sz
    torque[0], torque[1], torque[2] = torque[0] - tx, torque[1] - ty, torque[2] - tz


@leaf
def kick_side(side, held, touching, count, work, kick, knot_vel):
    """Kick the touching ``side`` knots by one step under their forces, keep their bristles."""
    for k in range(count):
        j = touching[k]
        i = side[j]
        gain = kick[i]
        for axis in range(3):
            knot_vel[axis, i] += gain * work[k + (9 + axis) * ROOM]
            held[axis, j] = work[k + (6 + axis) * ROOM]


@leaf
def contact_forces(
    knot_pos, knot_vel, mu_pos, mu_vel, candidates, count, bristles, debris, matrix, rate, numbers, forces, touched
):
    """Forces of the debris on the particles that touch it.

    Friction is the scaled box: in each of two tangential directions a spring and a damper, limited by mu times the
    normal force; the spring never holds more than friction can, what is beyond has slid.

    Args:
        knot_pos: (3, ROOM) [m].
        knot_vel: (3, ROOM) [m/s].
        mu_pos: (M, 3) [m].
        mu_vel: (M, 3) [m/s].
        candidates: particles to look at.
        count: how many.
        bristles: tangential displacements, debris frame [m], (529 + M, 3); updated.
        debris: body state (13,).
        matrix: its rotation (3, 3).
        rate: its angular rate, launch frame [rad/s].
        numbers: constants of the model.
        forces: output, one row for each touching particle [N], (..., 3).
        touched: output, the touching particles.

    Returns:
        How many particles touch.
    """
    touching = 0
    radius, half_length = numbers.debris_radius, numbers.debris_half_length
    stiffness, softness, dt = numbers.contact_stiffness, 1.0 / numbers.contact_stiffness, numbers.time_step
    friction = numbers.friction
    px, py, pz, qx, qy, qz = debris[0], debris[1], debris[2], debris[3], debris[4], debris[5]
    wx, wy, wz = rate[0], rate[1], rate[2]
    m00, m01, m02 = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    m10, m11, m12 = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    m20, m21, m22 = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    for j in range(count):
        particle = candidates[j]
        if particle < KNOTS:
            size, damping = numbers.knot_radius, numbers.knot_contact_damping
            dx, dy, dz = knot_pos[0, particle] - px, knot_pos[1, particle] - py, knot_pos[2, particle] - pz
        else:
            m = particle - KNOTS
            size, damping = numbers.mu_radius, numbers.mu_contact_damping
            dx, dy, dz = mu_pos[m, 0] - px, mu_pos[m, 1] - py, mu_pos[m, 2] - pz
        rz = m02 * dx + m12 * dy + m22 * dz
        across = dx * dx + dy * dy + dz * dz - rz * rz
        if across >= (radius + size) * (radius + size) or abs(rz) >= half_length + size:
            bristles[particle, 0], bristles[particle, 1], bristles[particle, 2] = 0.0, 0.0, 0.0
            continue
        rx = m00 * dx + m10 * dy + m20 * dz
        ry = m01 * dx + m11 * dy + m21 * dz
        distance, nx, ny, nz = surface(rx, ry, rz, radius, half_length)
        depth = size - distance
        if depth <= 0.0:
            bristles[particle, 0], bristles[particle, 1], bristles[particle, 2] = 0.0, 0.0, 0.0
            continue
        # Velocity of the particle relative to the debris' material at the particle, in the debris frame. Forces act
        # on both at the same point, so that angular momentum is conserved exactly.
        if particle < KNOTS:
            vx, vy, vz = knot_vel[0, particle], knot_vel[1, particle], knot_vel[2, particle]
        else:
            m = particle - KNOTS
            vx, vy, vz = mu_vel[m, 0], mu_vel[m, 1], mu_vel[m, 2]
        vx = vx - qx - (wy * dz - wz * dy)
        vy = vy - qy - (wz * dx - wx * dz)
        vz = vz - qz - (wx * dy - wy * dx)
        ux = m00 * vx + m10 * vy + m20 * vz
        uy = m01 * vx + m11 * vy + m21 * vz
        uz = m02 * vx + m12 * vy + m22 * vz
        pressing = max(stiffness * depth - damping * (ux * nx + uy * ny + uz * nz), 0.0)
        # The box' directions: along the cylinder's axis and round it; on the flat ends the body's x and y.
        if nz == 0.0:
            ax, ay, az, bx, by, bz = 0.0, 0.0, 1.0, ny, -nx, 0.0
        else:
            if abs(nz) < 0.8:
                ax, ay, az = -nz * nx, -nz * ny, 1.0 - nz * nz
            else:
                ax, ay, az = 1.0 - nx * nx, -nx * ny, -nx * nz
            inverse = 1.0 / math.sqrt(ax * ax + ay * ay + az * az)
            ax, ay, az = ax * inverse, ay * inverse, az * inverse
            bx, by, bz = ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax
        slide_1 = ux * ax + uy * ay + uz * az
        slide_2 = ux * bx + uy * by + uz * bz
        kx, ky, kz = bristles[particle, 0], bristles[particle, 1], bristles[particle, 2]
        stuck_1 = kx * ax + ky * ay + kz * az + dt * slide_1
        stuck_2 = kx * bx + ky * by + kz * bz + dt * slide_2
        limit = friction * pressing
        most = limit * softness
        force_1 = min(max(-stiffness * stuck_1 - damping * slide_1, -limit), limit)
        force_2 = min(max(-stiffness * stuck_2 - damping * slide_2, -limit), limit)
        stuck_1, stuck_2 = min(max(stuck_1, -most), most), min(max(stuck_2, -most), most)
        bristles[particle, 0] = stuck_1 * ax + stuck_2 * bx
        bristles[particle, 1] = stuck_1 * ay + stuck_2 * by
        bristles[particle, 2] = stuck_1 * az + stuck_2 * bz
        fx = pressing * nx + force_1 * ax + force_2 * bx
        fy = pressing * ny + force_1 * ay + force_2 * by
        fz = pressing * nz + force_1 * az + force_2 * bz
        forces[touching, 0] = m00 * fx + m01 * fy + m02 * fz
        forces[touching, 1] = m10 * fx + m11 * fy + m12 * fz
        forces[touching, 2] = m20 * fx + m21 * fy + m22 * fz
        touched[touching] = particle
        touching += 1
    return touching


@leaf
def react(touched, forces, count, kick, knot_pos, knot_vel, mu_pos, mu_force, debris, force, torque):
    """Apply contact forces to the particles; sum up what the debris gets back.

    Args:
        touched: the touching particles.
        forces: on them [N], (..., 3).
        count: how many.
        kick: velocity per force in one step of each knot [s/kg], (529,).
        knot_pos: (3, ROOM) [m].
        knot_vel: (3, ROOM) [m/s]; updated.
        mu_pos: (M, 3) [m].
        mu_force: (M, 3) [N]; updated.
        debris: body state (13,).
        force: on the debris [N], (3,); added to.
        torque: on the debris about its centre of mass [N m], (3,); added to.
    """
    sx, sy, sz, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(count):
        i = touched[j]
        fx, fy, fz = forces[j, 0], forces[j, 1], forces[j, 2]
        if i < KNOTS:
            knot_vel[0, i] += kick[i] * fx
            knot_vel[1, i] += kick[i] * fy
            knot_vel[2, i] += kick[i] * fz
            dx, dy, dz = knot_pos[0, i] - debris[0], knot_pos[1, i] - debris[1], knot_pos[2, i] - debris[2]
        else:
            m = i - KNOTS
            mu_force[m, 0] += fx
            mu_force[m, 1] += fy
            mu_force[m, 2] += fz
            dx, dy, dz = mu_pos[m, 0] - debris[0], mu_pos[m, 1] - debris[1], mu_pos[m, 2] - debris[2]
        sx, sy, sz = sx - fx, sy - fy, sz - fz
        tx, ty, tz = tx - dy * fz + dz * fy, ty - dz * fx + dx * fz, tz - dx * fy + dy * fx
    force[0], force[1], force[2] = force[0] + sx, force[1] + sy, force[2] + sz
    torque[0], torque[1], torque[2] = torque[0] + tx, torque[1] + ty, torque[2] + tz
