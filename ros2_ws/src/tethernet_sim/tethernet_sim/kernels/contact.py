"""Contact of knots and MUs, as small spheres, with the debris: compliant normal force, scaled-box friction."""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels import debris_body
from tethernet_sim.kernels.compaction import compact_indices
from tethernet_sim.kernels.options import inlined

SPEED_FACTOR, SPEED_MARGIN_M_S = 2.0, 2.0
"""Until the next search no particle gets faster relative to the debris than this factor times the fastest now, plus
this margin: a thread that snaps taut can at most reverse a relative velocity."""
NEAR_STEPS = 10
"""Steps between two searches while particles are near the debris."""
ROWS = 20
"""Rows of a block of work space for :func:`contact_forces`; the last four are those of threads."""
BLOCK = 544
"""Numbers in such a row. Any number of particles fits into :func:`blocks` blocks; within one the rows are a constant
apart, which is what it takes to vectorise."""
FAR_STEPS = 500
"""Steps between two searches at the most."""
LEAST_STEEPNESS = 1e-12
"""Square of the least gradient of a thread's depth that is not taken as none."""
FAR_AWAY = 1e5
"""Nothing touches the debris at this distance along each axis [m]."""


@inlined
def blocks(particles):
    """Blocks of work space in which so many particles fit."""
    return (particles + BLOCK - 1) // BLOCK


@inlined
def column(number):
    """Where in the work space the first row of a particle's block has it; the next rows follow BLOCK apart."""
    return number // BLOCK * (ROWS * BLOCK) + number % BLOCK


@inlined
def fastest(knot_vel, mu_vel, knots, debris, spin, reach, squared, ordered):
    """Bound of any particle's speed relative to the debris' material until the next search [m/s].

    Args:
        knot_vel: (3, width) [m/s].
        mu_vel: (M, 3) [m/s].
        knots: how many there are.
        debris: body state (13,).
        spin: magnitude of its angular rate [rad/s].
        reach: its farthest point from its centre [m].
        squared: work space, (width,).
        ordered: the same numbers' bits, unsigned, (width,).
    """
    vx, vy, vz = debris[3], debris[4], debris[5]
    x, y, z = knot_vel[0], knot_vel[1], knot_vel[2]
    for i in range(knots):
        dx, dy, dz = x[i] - vx, y[i] - vy, z[i] - vz
        squared[i] = dx * dx + dy * dy + dz * dz
    # Bits of numbers that are not negative are in the numbers' order, NaN last. Unlike numbers, which can be NaN, they
    # are compared vectorised.
    top = np.uint64(0)
    for i in range(knots):
        top = max(top, ordered[i])
    most = np.uint64(top).view(np.float64)
    for m in range(len(mu_vel)):
        dx, dy, dz = mu_vel[m, 0] - vx, mu_vel[m, 1] - vy, mu_vel[m, 2] - vz
        most = max(most, dx * dx + dy * dy + dz * dz)
    return SPEED_FACTOR * (math.sqrt(most) + spin * reach) + SPEED_MARGIN_M_S


@inlined
def find_candidates(
    knot_pos, mu_pos, body, debris, matrix, numbers, speed, near, squared, ordered, flags, blocks, busy
):
    """List the particles that may touch the debris before the next search.

    Args:
        knot_pos: (3, width) [m].
        mu_pos: (M, 3) [m].
        body: constants of the debris, see kernels.debris_body.
        debris: its body state (13,).
        matrix: its rotation (3, 3).
        numbers: constants of the model.
        speed: bound of any particle's relative speed until then [m/s].
        near: output, the particles, knots first.
        squared: work space, (width,).
        ordered: the same numbers' bits, unsigned, (width,).
        flags: work space, one byte for each knot, zeros beyond, (width,).
        blocks: the same bytes, eight in one, (width / 8,).
        busy: work space, (width,).

    Returns:
        (how many knots are listed, how many particles, steps until the next search is due).
    """
    # No point of a thread is nearer to the centre than its nearer end by more than half its length.
    reach = debris_body.reach(body) + max(numbers.knot_radius, numbers.mu_radius, numbers.half_longest)
    margin = speed * NEAR_STEPS * numbers.time_step
    mus, all_knots = mu_pos.shape[0], numbers.knots
    px, py, pz = debris[0], debris[1], debris[2]
    x, y, z = knot_pos[0], knot_pos[1], knot_pos[2]
    for i in range(all_knots):
        dx, dy, dz = x[i] - px, y[i] - py, z[i] - pz
        squared[i] = dx * dx + dy * dy + dz * dz
    bottom = ordered[0]
    for i in range(all_knots):
        bottom = min(bottom, ordered[i])
    nearest = np.uint64(bottom).view(np.float64)
    for m in range(mus):
        dx, dy, dz = mu_pos[m, 0] - px, mu_pos[m, 1] - py, mu_pos[m, 2] - pz
        nearest = min(nearest, dx * dx + dy * dy + dz * dz)
    if nearest > (reach + margin) * (reach + margin):
        return 0, 0, min(FAR_STEPS, int((math.sqrt(nearest) - reach) / (speed * numbers.time_step)))
    # Within the sphere round the debris: a debris that is larger all round decides.
    frame = debris_body.frame(body, matrix)
    limits = debris_body.inflated(body, numbers.knot_radius + margin)
    for i in range(all_knots):
        flags[i] = debris_body.within(body, frame, limits, x[i] - px, y[i] - py, z[i] - pz)
    knots = compact_indices(flags, blocks, busy, near)
    count = knots
    limits = debris_body.inflated(body, numbers.mu_radius + margin)
    for m in range(mus):
        if debris_body.within(body, frame, limits, mu_pos[m, 0] - px, mu_pos[m, 1] - py, mu_pos[m, 2] - pz):
            near[count] = all_knots + m
            count += 1
    return knots, count, NEAR_STEPS


@inlined
def fetch_bristles(bristles, near, count, held):
    """Copy the bristles of the ``near`` particles to ``held`` (3, width)."""
    for j in range(count):
        for axis in range(3):
            held[axis, j] = bristles[near[j], axis]


@inlined
def store_bristles(bristles, near, count, held):
    """Copy the bristles of the ``near`` particles back."""
    for j in range(count):
        for axis in range(3):
            bristles[near[j], axis] = held[axis, j]


@inlined
def find_touching(knot_pos, mu_pos, body, debris, matrix, numbers, near, knots, count, held, kept, touching):
    """List which of the ``near`` particles touch: most of them only hover. Their bristles are forgotten.

    Args:
        knot_pos: (3, width) [m].
        mu_pos: (M, 3) [m].
        body: constants of the debris, see kernels.debris_body.
        debris: its body state (13,).
        matrix: its rotation (3, 3).
        numbers: constants of the model.
        near: particles to look at, knots first.
        knots: how many knots.
        count: how many particles.
        held: their bristles [m], (3, width); updated.
        kept: work space, (width,).
        touching: output, where in ``near`` the touching ones are, (width,); also a few that miss an edge.

    Returns:
        (how many knots are listed, how many particles).
    """
    all_knots = numbers.knots
    px, py, pz = debris[0], debris[1], debris[2]
    x, y, z = knot_pos[0], knot_pos[1], knot_pos[2]
    frame = debris_body.frame(body, matrix)
    limits = debris_body.inflated(body, numbers.knot_radius)
    found = np.uint64(0)
    for j in range(knots):
        i = near[j]
        touches = debris_body.within(body, frame, limits, x[i] - px, y[i] - py, z[i] - pz)
        touching[found] = j
        found += np.uint64(touches)
        kept[j] = touches
    touching_knots = np.int64(found)
    limits = debris_body.inflated(body, numbers.mu_radius)
    for j in range(knots, count):
        m = near[j] - all_knots
        touches = debris_body.within(body, frame, limits, mu_pos[m, 0] - px, mu_pos[m, 1] - py, mu_pos[m, 2] - pz)
        touching[found] = j
        found += np.uint64(touches)
        kept[j] = touches
    for axis in range(3):
        bristle = held[axis]
        for j in range(count):
            bristle[j] *= kept[j]
    return touching_knots, np.int64(found)


@inlined
def gather(
    knot_pos, knot_vel, mu_pos, mu_vel, debris, damping, mu_radius, numbers, near, held, touching, knots, count, work
):  # fmt: skip
    """Copy what :func:`contact_forces` needs of the touching particles to ``work``; ``damping`` (N + M,) is that of
    each particle [N s/m], ``mu_radius`` (M,) that of each MU [m].
    """
    all_knots = numbers.knots
    px, py, pz = debris[0], debris[1], debris[2]
    for begin in range(0, count, BLOCK):
        block = work[begin * ROWS :]
        for k in range(min(BLOCK, count - begin)):
            j = touching[begin + k]
            particle = near[j]
            if begin + k < knots:
                block[k] = knot_pos[0, particle] - px
                block[k + BLOCK] = knot_pos[1, particle] - py
                block[k + 2 * BLOCK] = knot_pos[2, particle] - pz
                for axis in range(3):
                    block[k + (3 + axis) * BLOCK] = knot_vel[axis, particle]
                block[k + 12 * BLOCK] = numbers.knot_radius
                block[k + 14 * BLOCK], block[k + 15 * BLOCK] = 1.0, 1.0
            else:
                m = particle - all_knots
                block[k] = mu_pos[m, 0] - px
                block[k + BLOCK] = mu_pos[m, 1] - py
                block[k + 2 * BLOCK] = mu_pos[m, 2] - pz
                for axis in range(3):
                    block[k + (3 + axis) * BLOCK] = mu_vel[m, axis]
                block[k + 12 * BLOCK] = mu_radius[m]
                block[k + 14 * BLOCK] = numbers.mu_contact_share
                block[k + 15 * BLOCK] = 1.0 / numbers.mu_contact_share
            block[k + 13 * BLOCK] = damping[particle]
            for axis in range(3):
                block[k + (6 + axis) * BLOCK] = held[axis, j]


@inlined
def fill_up(work, count):
    """Fill up a whole vector of :func:`contact_forces` with what touches nothing.

    Returns:
        How many ``work`` holds then.
    """
    filled = (count + 7) // 8 * 8
    for k in range(count, filled):
        for row in range(ROWS):
            work[column(k) + row * BLOCK] = FAR_AWAY if row < 3 else (1.0 if 13 < row < 16 else 0.0)
    return filled


@inlined
def contact_forces(work, count, body, debris, matrix, rate, numbers, on_threads, force, torque):
    """Forces of the debris on the particles, or points of threads, that touch it; without branches, so that it
    vectorises.

    Friction is the scaled box: in each of two tangential directions a spring and a damper, limited by mu times the
    normal force; the spring never holds more than friction can, what is beyond has slid.

    A thread touches where its distance is smallest, so that only the part of the surface's normal across the thread
    changes that distance: it is the gradient of the depth, not of unit length where the thread crosses an edge, and
    force along it is conservative. A force along the thread would drive it round an edge for ever.

    Args:
        work: blocks, see :data:`BLOCK`, with a row for each of: position relative to the debris' centre [m], velocity
            [m/s], bristle in the debris frame [m] (updated), force on the particle [N] (output), each x, y, z; radius
            [m], damping [N s/m], stiffness as a share of the law's and its inverse; of a point of a thread also the
            vector from the first to the second end, x, y, z [m], and one over its squared length [1/m^2]. Instead of
            the vector are put out: the speed of sliding through the point, as a share of its length [1/s], the slope of
            the distance along it [m], the depth [m].
        count: how many particles.
        body: constants of the debris, see kernels.debris_body.
        debris: its body state (13,).
        matrix: its rotation (3, 3).
        rate: its angular rate, launch frame [rad/s].
        numbers: constants of the model.
        on_threads: whether they are points of threads; a literal, so that there is no branch.
        force: on the debris [N], (3,); added to.
        torque: on the debris about its centre of mass [N m], (3,); added to.

    Returns:
        How many particles touch.
    """
    stiffness, softness, dt = numbers.contact_stiffness, 1.0 / numbers.contact_stiffness, numbers.time_step
    friction = numbers.friction
    qx, qy, qz = debris[3], debris[4], debris[5]
    wx, wy, wz = rate[0], rate[1], rate[2]
    m00, m01, m02 = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    m10, m11, m12 = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    m20, m21, m22 = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    sx, sy, sz, tx, ty, tz, touching = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0
    for begin in range(0, count, BLOCK):
        block = work[begin * ROWS :]
        for j in range(min(BLOCK, count - begin)):
            dx, dy, dz = block[j], block[j + BLOCK], block[j + 2 * BLOCK]
            damping, hard = block[j + 13 * BLOCK], stiffness * block[j + 14 * BLOCK]
            # Velocity of the particle relative to the debris' material at the particle, in the debris frame. Forces act
            # on both at the same point, so that angular momentum is conserved exactly.
            vx = block[j + 3 * BLOCK] - qx - (wy * dz - wz * dy)
            vy = block[j + 4 * BLOCK] - qy - (wz * dx - wx * dz)
            vz = block[j + 5 * BLOCK] - qz - (wx * dy - wy * dx)
            rx, ry, rz = m00 * dx + m10 * dy + m20 * dz, m01 * dx + m11 * dy + m21 * dz, m02 * dx + m12 * dy + m22 * dz
            ux, uy, uz = m00 * vx + m10 * vy + m20 * vz, m01 * vx + m11 * vy + m21 * vz, m02 * vx + m12 * vy + m22 * vz
            distance, nx, ny, nz = debris_body.surface(body, rx, ry, rz)
            depth = block[j + 12 * BLOCK] - distance
            if on_threads:
                lx, ly, lz = block[j + 16 * BLOCK], block[j + 17 * BLOCK], block[j + 18 * BLOCK]
                ex, ey, ez = (
                    m00 * lx + m10 * ly + m20 * lz, m01 * lx + m11 * ly + m21 * lz, m02 * lx + m12 * ly + m22 * lz,
                )  # fmt: skip
                slope = nx * ex + ny * ey + nz * ez
                along = slope * block[j + 19 * BLOCK]
                nx, ny, nz = nx - along * ex, ny - along * ey, nz - along * ez
                steepness = math.sqrt(max(nx * nx + ny * ny + nz * nz, LEAST_STEEPNESS))
                nx, ny, nz = nx / steepness, ny / steepness, nz / steepness
                pressing = hard * depth - damping * steepness * (ux * nx + uy * ny + uz * nz)
                pressing = max(steepness * pressing, 0.0)
                block[j + 16 * BLOCK] = (ux * ex + uy * ey + uz * ez) * block[j + 19 * BLOCK]
                block[j + 17 * BLOCK], block[j + 18 * BLOCK] = slope, depth
            else:
                pressing = max(hard * depth - damping * (ux * nx + uy * ny + uz * nz), 0.0)
            pressing = pressing if depth > 0.0 else 0.0
            # The box' directions: a along the body's z as far as the surface allows, where that is steep along its x;
            # b across both. No choice is smooth all round a body; where it changes, the bristle stays what it is.
            steep = abs(nz) < 0.8
            lean = nz if steep else nx
            inverse = 1.0 / math.sqrt(1.0 - lean * lean)
            ax, ay, az = (0.0 if steep else 1.0) - lean * nx, -lean * ny, (1.0 if steep else 0.0) - lean * nz
            ax, ay, az = ax * inverse, ay * inverse, az * inverse
            bx, by, bz = ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax
            slide_1, slide_2 = ux * ax + uy * ay + uz * az, ux * bx + uy * by + uz * bz
            kx, ky, kz = block[j + 6 * BLOCK], block[j + 7 * BLOCK], block[j + 8 * BLOCK]
            stuck_1 = kx * ax + ky * ay + kz * az + dt * slide_1
            stuck_2 = kx * bx + ky * by + kz * bz + dt * slide_2
            limit = friction * pressing
            most = limit * (softness * block[j + 15 * BLOCK])
            force_1 = min(max(-hard * stuck_1 - damping * slide_1, -limit), limit)
            force_2 = min(max(-hard * stuck_2 - damping * slide_2, -limit), limit)
            stuck_1, stuck_2 = min(max(stuck_1, -most), most), min(max(stuck_2, -most), most)
            block[j + 6 * BLOCK] = stuck_1 * ax + stuck_2 * bx
            block[j + 7 * BLOCK] = stuck_1 * ay + stuck_2 * by
            block[j + 8 * BLOCK] = stuck_1 * az + stuck_2 * bz
            px = pressing * nx + force_1 * ax + force_2 * bx
            py = pressing * ny + force_1 * ay + force_2 * by
            pz = pressing * nz + force_1 * az + force_2 * bz
            fx, fy, fz = m00 * px + m01 * py + m02 * pz, m10 * px + m11 * py + m12 * pz, m20 * px + m21 * py + m22 * pz
            block[j + 9 * BLOCK], block[j + 10 * BLOCK], block[j + 11 * BLOCK] = fx, fy, fz
            sx, sy, sz = sx + fx, sy + fy, sz + fz
            tx, ty, tz = tx + (dy * fz - dz * fy), ty + (dz * fx - dx * fz), tz + (dx * fy - dy * fx)
            touching += 1 if depth > 0.0 else 0
    force[0], force[1], force[2] = force[0] - sx, force[1] - sy, force[2] - sz
    torque[0], torque[1], torque[2] = torque[0] - tx, torque[1] - ty, torque[2] - tz
    return touching


@inlined
def react(near, held, touching, knots, count, work, kick, all_knots, knot_vel, mu_force):
    """Kick the touching knots by one step, add to the force on the touching MUs, keep the bristles."""
    for begin in range(0, count, BLOCK):
        block = work[begin * ROWS :]
        for k in range(min(BLOCK, count - begin)):
            j = touching[begin + k]
            particle = near[j]
            if begin + k < knots:
                gain = kick[particle]
                for axis in range(3):
                    knot_vel[axis, particle] += gain * block[k + (9 + axis) * BLOCK]
            else:
                for axis in range(3):
                    mu_force[particle - all_knots, axis] += block[k + (9 + axis) * BLOCK]
            for axis in range(3):
                held[axis, j] = block[k + (6 + axis) * BLOCK]
