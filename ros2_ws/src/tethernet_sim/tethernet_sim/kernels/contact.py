"""Contact of knots and MUs, as small spheres, with the debris' cylinder: compliant normal force, scaled-box friction."""

from __future__ import annotations

import math

from .options import kernel

FASTEST_M_S = 50.0
"""No particle moves faster relative to the debris; bounds how far it can come before the next search for contacts [m/s]."""
NEAR_STEPS = 10
"""Steps between two searches while particles are near the debris."""
FAR_STEPS = 500
"""Steps between two searches at the most."""


@kernel
def surface(rx, ry, rz, radius, half_length, normal):
    """Signed distance of a point from a cylinder, and the outward normal there.

    Args:
        rx, ry, rz: the point in the cylinder's frame, axis z [m].
        radius: of the cylinder [m].
        half_length: of the cylinder [m].
        normal: output, unit vector in the cylinder's frame.

    Returns:
        Distance [m], negative inside.
    """
    radial = math.sqrt(rx * rx + ry * ry)
    side = radial - radius
    flat = abs(rz) - half_length
    inverse = 1.0 / radial if radial > 0.0 else 0.0
    up = 1.0 if rz >= 0.0 else -1.0
    if side > 0.0 and flat > 0.0:
        distance = math.sqrt(side * side + flat * flat)
        normal[0], normal[1], normal[2] = (
            side / distance * rx * inverse,
            side / distance * ry * inverse,
            flat / distance * up,
        )
        return distance
    if side > flat:
        normal[0], normal[1], normal[2] = rx * inverse, ry * inverse, 0.0
        return side
    normal[0], normal[1], normal[2] = 0.0, 0.0, up
    return flat


@kernel
def find_candidates(knot_pos, mu_pos, debris, matrix, model, candidates, normal):
    """List the particles that may touch the debris before the next search.

    Returns:
        (how many are listed, steps until the next search is due).
    """
    reach = math.sqrt(model.debris_radius * model.debris_radius + model.debris_half_length * model.debris_half_length)
    margin = FASTEST_M_S * NEAR_STEPS * model.time_step
    nearest = 1e9
    count = 0
    knots = knot_pos.shape[1]
    size = model.knot_radius
    for i in range(knots + mu_pos.shape[0]):
        if i < knots:
            dx, dy, dz = knot_pos[0, i] - debris[0], knot_pos[1, i] - debris[1], knot_pos[2, i] - debris[2]
        else:
            size = model.mu_radius
            m = i - knots
            dx, dy, dz = mu_pos[m, 0] - debris[0], mu_pos[m, 1] - debris[1], mu_pos[m, 2] - debris[2]
        gap = math.sqrt(dx * dx + dy * dy + dz * dz) - reach - size
        if gap < margin:
            rx = matrix[0, 0] * dx + matrix[1, 0] * dy + matrix[2, 0] * dz
            ry = matrix[0, 1] * dx + matrix[1, 1] * dy + matrix[2, 1] * dz
            rz = matrix[0, 2] * dx + matrix[1, 2] * dy + matrix[2, 2] * dz
            gap = surface(rx, ry, rz, model.debris_radius, model.debris_half_length, normal) - size
            if gap < margin:
                candidates[count] = i
                count += 1
        nearest = min(nearest, gap)
    if count:
        return count, NEAR_STEPS
    return 0, min(FAR_STEPS, int(nearest / (FASTEST_M_S * model.time_step)))


@kernel
def box_friction(stuck, sliding, normal_force, friction, stiffness, damping):
    """Friction in one tangential direction of the scaled-box model: spring and damper, limited by mu times the normal force.

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
def contact_force(position, velocity, bristle, size, damping, debris, matrix, rate, model, force, work):
    """Force on one particle from the debris.

    Args:
        position: of the particle [m], (3,).
        velocity: of the particle [m/s], (3,).
        bristle: its tangential displacement, debris frame [m], (3,); updated.
        size: radius of its sphere [m].
        damping: of the normal contact [N s/m].
        debris: body state (13,).
        matrix: its rotation (3, 3).
        rate: its angular rate, launch frame [rad/s].
        model: constants.
        force: output [N], (3,).
        work: (5, 3) work space.

    Returns:
        True when they touch.
    """
    local, normal_body, normal, first, second = work[0], work[1], work[2], work[3], work[4]
    dx, dy, dz = position[0] - debris[0], position[1] - debris[1], position[2] - debris[2]
    for axis in range(3):
        local[axis] = matrix[0, axis] * dx + matrix[1, axis] * dy + matrix[2, axis] * dz
    depth = size - surface(local[0], local[1], local[2], model.debris_radius, model.debris_half_length, normal_body)
    if depth <= 0.0:
        for axis in range(3):
            force[axis] = 0.0
            bristle[axis] = 0.0
        return False
    # Velocity of the particle relative to the debris' material at the particle, in the debris frame. Forces act on both at the same
    # point, so that angular momentum is conserved exactly.
    vx = velocity[0] - debris[3] - (rate[1] * dz - rate[2] * dy)
    vy = velocity[1] - debris[4] - (rate[2] * dx - rate[0] * dz)
    vz = velocity[2] - debris[5] - (rate[0] * dy - rate[1] * dx)
    for axis in range(3):
        normal[axis] = matrix[0, axis] * vx + matrix[1, axis] * vy + matrix[2, axis] * vz
    relative = normal
    approach = -(relative[0] * normal_body[0] + relative[1] * normal_body[1] + relative[2] * normal_body[2])
    pressing = max(model.contact_stiffness * depth + damping * approach, 0.0)
    # The box' directions: along the cylinder's axis and round it; on the flat ends the body's x and y.
    if abs(normal_body[2]) < 0.8:
        first[0], first[1], first[2] = (
            -normal_body[2] * normal_body[0],
            -normal_body[2] * normal_body[1],
            1.0 - normal_body[2] * normal_body[2],
        )
    else:
        first[0], first[1], first[2] = (
            1.0 - normal_body[0] * normal_body[0],
            -normal_body[0] * normal_body[1],
            -normal_body[0] * normal_body[2],
        )
    inverse = 1.0 / math.sqrt(first[0] * first[0] + first[1] * first[1] + first[2] * first[2])
    for axis in range(3):
        first[axis] *= inverse
    second[0] = normal_body[1] * first[2] - normal_body[2] * first[1]
    second[1] = normal_body[2] * first[0] - normal_body[0] * first[2]
    second[2] = normal_body[0] * first[1] - normal_body[1] * first[0]
    slide_1 = relative[0] * first[0] + relative[1] * first[1] + relative[2] * first[2]
    slide_2 = relative[0] * second[0] + relative[1] * second[1] + relative[2] * second[2]
    stuck_1 = bristle[0] * first[0] + bristle[1] * first[1] + bristle[2] * first[2] + model.time_step * slide_1
    stuck_2 = bristle[0] * second[0] + bristle[1] * second[1] + bristle[2] * second[2] + model.time_step * slide_2
    force_1, stuck_1 = box_friction(stuck_1, slide_1, pressing, model.friction, model.contact_stiffness, damping)
    force_2, stuck_2 = box_friction(stuck_2, slide_2, pressing, model.friction, model.contact_stiffness, damping)
    for axis in range(3):
        bristle[axis] = stuck_1 * first[axis] + stuck_2 * second[axis]
        local[axis] = pressing * normal_body[axis] + force_1 * first[axis] + force_2 * second[axis]
    for axis in range(3):
        force[axis] = matrix[axis, 0] * local[0] + matrix[axis, 1] * local[1] + matrix[axis, 2] * local[2]
    return True
