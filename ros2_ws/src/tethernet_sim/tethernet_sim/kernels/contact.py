"""Contact of knots and MUs, as small spheres, with the debris' cylinder: compliant normal force, scaled-box
friction.
"""

from __future__ import annotations

import math

from .options import kernel

SPEED_FACTOR, SPEED_MARGIN_M_S = 2.0, 2.0
"""Until the next search no particle gets faster relative to the debris than this factor times the fastest now, plus
this margin: a thread that snaps taut can at most reverse a relative velocity."""
NEAR_STEPS = 10
"""Steps between two searches while particles are near the debris."""
FAR_STEPS = 500
"""Steps between two searches at the most."""


@kernel
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


@kernel
def fastest(knot_vel, mu_vel, debris, spin, reach):
    """Bound of any particle's speed relative to the debris' material until the next search [m/s].

    Args:
        knot_vel: (3, 529) [m/s].
        mu_vel: (M, 3) [m/s].
        debris: body state (13,).
        spin: magnitude of its angular rate [rad/s].
        reach: its farthest point from its centre [m].
    """
    vx, vy, vz = debris[3], debris[4], debris[5]
    x, y, z = knot_vel[0], knot_vel[1], knot_vel[2]
    most = 0.0
    for i in range(len(x)):
        most = max(most, (x[i] - vx) * (x[i] - vx) + (y[i] - vy) * (y[i] - vy) + (z[i] - vz) * (z[i] - vz))
    for m in range(len(mu_vel)):
        dx, dy, dz = mu_vel[m, 0] - vx, mu_vel[m, 1] - vy, mu_vel[m, 2] - vz
        most = max(most, dx * dx + dy * dy + dz * dz)
    return SPEED_FACTOR * (math.sqrt(most) + spin * reach) + SPEED_MARGIN_M_S


@kernel
def find_candidates(knot_pos, mu_pos, debris, matrix, numbers, speed, candidates):
    """List the particles that may touch the debris before the next search.

    Args:
        knot_pos: (3, 529) [m].
        mu_pos: (M, 3) [m].
        debris: body state (13,).
        matrix: its rotation (3, 3).
        numbers: constants of the model.
        speed: bound of any particle's relative speed until then [m/s].
        candidates: output.

    Returns:
        (how many are listed, steps until the next search is due).
    """
    reach = math.sqrt(
        numbers.debris_radius * numbers.debris_radius + numbers.debris_half_length * numbers.debris_half_length
    )
    margin = speed * NEAR_STEPS * numbers.time_step
    nearest = 1e9
    count = 0
    knots = knot_pos.shape[1]
    size = numbers.knot_radius
    for i in range(knots + mu_pos.shape[0]):
        if i < knots:
            dx, dy, dz = knot_pos[0, i] - debris[0], knot_pos[1, i] - debris[1], knot_pos[2, i] - debris[2]
        else:
            size = numbers.mu_radius
            m = i - knots
            dx, dy, dz = mu_pos[m, 0] - debris[0], mu_pos[m, 1] - debris[1], mu_pos[m, 2] - debris[2]
        gap = math.sqrt(dx * dx + dy * dy + dz * dz) - reach - size
        if gap < margin:
            rx = matrix[0, 0] * dx + matrix[1, 0] * dy + matrix[2, 0] * dz
            ry = matrix[0, 1] * dx + matrix[1, 1] * dy + matrix[2, 1] * dz
            rz = matrix[0, 2] * dx + matrix[1, 2] * dy + matrix[2, 2] * dz
            gap = surface(rx, ry, rz, numbers.debris_radius, numbers.debris_half_length)[0] - size
            if gap < margin:
                candidates[count] = i
                count += 1
        nearest = min(nearest, gap)
    if count:
        return count, NEAR_STEPS
    return 0, min(FAR_STEPS, int(nearest / (speed * numbers.time_step)))


@kernel
def box_friction(stuck, sliding, normal_force, friction, stiffness, damping):
    """Friction in one tangential direction of the scaled-box model: spring and damper, limited by mu times the
    normal force.

    Args:
        stuck: displacement since the contact stuck [m].
        sliding: velocity [m/s].
        normal_force: [N], not negative.
        friction: mu.
        stiffness: of the spring [N/m].
        damping: of the damper [N s/m].

    Returns:
        (force [N], displacement that the spring may keep [m]).
    """
    limit = friction * normal_force
    force = -stiffness * stuck - damping * sliding
    force = min(max(force, -limit), limit)
    # The spring must not hold more than friction can: what is beyond has slid.
    most = limit / stiffness
    return force, min(max(stuck, -most), most)


@kernel
def contact_forces(
    knot_pos, knot_vel, mu_pos, mu_vel, candidates, count, bristles, debris, matrix, rate, numbers, forces, touched
):
    """Forces of the debris on the particles that touch it.

    The hot spot of a capture: one loop of scalars, because a call with arrays costs more than a contact.

    Args:
        knot_pos: (3, 529) [m].
        knot_vel: (3, 529) [m/s].
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
    knots = knot_pos.shape[1]
    for j in range(count):
        particle = candidates[j]
        if particle < knots:
            size, damping = numbers.knot_radius, numbers.knot_contact_damping
            x, y, z = knot_pos[0, particle], knot_pos[1, particle], knot_pos[2, particle]
            vx, vy, vz = knot_vel[0, particle], knot_vel[1, particle], knot_vel[2, particle]
        else:
            m = particle - knots
            size, damping = numbers.mu_radius, numbers.mu_contact_damping
            x, y, z = mu_pos[m, 0], mu_pos[m, 1], mu_pos[m, 2]
            vx, vy, vz = mu_vel[m, 0], mu_vel[m, 1], mu_vel[m, 2]
        dx, dy, dz = x - debris[0], y - debris[1], z - debris[2]
        rx = matrix[0, 0] * dx + matrix[1, 0] * dy + matrix[2, 0] * dz
        ry = matrix[0, 1] * dx + matrix[1, 1] * dy + matrix[2, 1] * dz
        rz = matrix[0, 2] * dx + matrix[1, 2] * dy + matrix[2, 2] * dz
        distance, nx, ny, nz = surface(rx, ry, rz, numbers.debris_radius, numbers.debris_half_length)
        depth = size - distance
        if depth <= 0.0:
            bristles[particle, 0], bristles[particle, 1], bristles[particle, 2] = 0.0, 0.0, 0.0
            continue
        # Velocity of the particle relative to the debris' material at the particle, in the debris frame. Forces act
        # on both at the same point, so that angular momentum is conserved exactly.
        wx = vx - debris[3] - (rate[1] * dz - rate[2] * dy)
        wy = vy - debris[4] - (rate[2] * dx - rate[0] * dz)
        wz = vz - debris[5] - (rate[0] * dy - rate[1] * dx)
        ux = matrix[0, 0] * wx + matrix[1, 0] * wy + matrix[2, 0] * wz
        uy = matrix[0, 1] * wx + matrix[1, 1] * wy + matrix[2, 1] * wz
        uz = matrix[0, 2] * wx + matrix[1, 2] * wy + matrix[2, 2] * wz
        approach = -(ux * nx + uy * ny + uz * nz)
        pressing = max(numbers.contact_stiffness * depth + damping * approach, 0.0)
        # The box' directions: along the cylinder's axis and round it; on the flat ends the body's x and y.
        if abs(nz) < 0.8:
            ax, ay, az = -nz * nx, -nz * ny, 1.0 - nz * nz
        else:
            ax, ay, az = 1.0 - nx * nx, -nx * ny, -nx * nz
        inverse = 1.0 / math.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax * inverse, ay * inverse, az * inverse
        bx, by, bz = ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax
        slide_1 = ux * ax + uy * ay + uz * az
        slide_2 = ux * bx + uy * by + uz * bz
        stuck_1 = (
            bristles[particle, 0] * ax
            + bristles[particle, 1] * ay
            + bristles[particle, 2] * az
            + numbers.time_step * slide_1
        )
        stuck_2 = (
            bristles[particle, 0] * bx
            + bristles[particle, 1] * by
            + bristles[particle, 2] * bz
            + numbers.time_step * slide_2
        )
        force_1, stuck_1 = box_friction(
            stuck_1, slide_1, pressing, numbers.friction, numbers.contact_stiffness, damping
        )
        force_2, stuck_2 = box_friction(
            stuck_2, slide_2, pressing, numbers.friction, numbers.contact_stiffness, damping
        )
        bristles[particle, 0] = stuck_1 * ax + stuck_2 * bx
        bristles[particle, 1] = stuck_1 * ay + stuck_2 * by
        bristles[particle, 2] = stuck_1 * az + stuck_2 * bz
        fx = pressing * nx + force_1 * ax + force_2 * bx
        fy = pressing * ny + force_1 * ay + force_2 * by
        fz = pressing * nz + force_1 * az + force_2 * bz
        forces[touching, 0] = matrix[0, 0] * fx + matrix[0, 1] * fy + matrix[0, 2] * fz
        forces[touching, 1] = matrix[1, 0] * fx + matrix[1, 1] * fy + matrix[1, 2] * fz
        forces[touching, 2] = matrix[2, 0] * fx + matrix[2, 1] * fy + matrix[2, 2] * fz
        touched[touching] = particle
        touching += 1
    return touching


@kernel
def react(touched, forces, count, kick, knot_pos, knot_vel, mu_pos, mu_force, debris, force, torque):
    """Apply contact forces to the particles; sum up what the debris gets back.

    Args:
        touched: the touching particles.
        forces: on them [N], (..., 3).
        count: how many.
        kick: velocity per force in one step of each knot [s/kg], (529,).
        knot_pos: (3, 529) [m].
        knot_vel: (3, 529) [m/s]; updated.
        mu_pos: (M, 3) [m].
        mu_force: (M, 3) [N]; updated.
        debris: body state (13,).
        force: output, on the debris [N], (3,).
        torque: output, on the debris about its centre of mass [N m], (3,).
    """
    knots = knot_pos.shape[1]
    sx, sy, sz, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(count):
        i = touched[j]
        fx, fy, fz = forces[j, 0], forces[j, 1], forces[j, 2]
        if i < knots:
            knot_vel[0, i] += kick[i] * fx
            knot_vel[1, i] += kick[i] * fy
            knot_vel[2, i] += kick[i] * fz
            dx, dy, dz = knot_pos[0, i] - debris[0], knot_pos[1, i] - debris[1], knot_pos[2, i] - debris[2]
        else:
            m = i - knots
            mu_force[m, 0] += fx
            mu_force[m, 1] += fy
            mu_force[m, 2] += fz
            dx, dy, dz = mu_pos[m, 0] - debris[0], mu_pos[m, 1] - debris[1], mu_pos[m, 2] - debris[2]
        sx, sy, sz = sx - fx, sy - fy, sz - fz
        tx, ty, tz = tx - dy * fz + dz * fy, ty - dz * fx + dx * fz, tz - dx * fy + dy * fx
    force[0], force[1], force[2] = sx, sy, sz
    torque[0], torque[1], torque[2] = tx, ty, tz
