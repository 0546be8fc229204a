"""What acts where two threads of the net touch.

Two threads touch where the points of theirs that are nearest to each other lie within both of them: a thread passes
through a thread nowhere else. There a spring and damper push them apart, along the common normal of both, and friction
holds them back across it, a spring in the tangent plane that slips at mu times the normal force.

A touching pair remembers its normal, and so which thread is on which side: the spring goes on beyond the place where
the threads meet, and pushes one that has gone through, in a step or under load, back to its own side. The normal is
followed from step to step, because the side alone, the sign of the mixed product, changes when the threads turn through
the parallel. A pair touches from where it was found on, at most at the distance of the parameters: one that comes to
lie within that distance, as when a thread slips over a knot onto the next one, is given no energy.

The normal force acts along the line of both points, so that the lever rule keeps momentum and angular momentum exact.
Friction acts across the gap between the points; its moment over the gap turns all four ends as one rigid body, whose
momenta then balance to rounding. The slip that friction works against is that without this rigid turning, which makes
its work on the knots the force times the slip.
"""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels import lanes
from tethernet_sim.kernels.crossing_work import BLOCK, MEMORY, NEAR, blocks
from tethernet_sim.kernels.crossings import LEAST_SQUARE, first_lanes, gathered, products
from tethernet_sim.kernels.options import inlined

PARALLEL = 1e-6
"""Square of the sine of the angle under which two threads have no common normal that can be followed."""
COLLINEAR = 1e-12
"""Of the cube of the mean moment of inertia: under that, the four ends lie along one line and take no moment."""


@inlined
def find(work, numbers, pos):
    """List the near pairs that touch, or did at the last step. Returns how many."""
    x, y, z, ends, remembers, near = pos[0], pos[1], pos[2], work.near_ends, work.near_remembers, work.counts[NEAR]
    squared = lanes.spread(numbers.crossing_distance * numbers.crossing_distance)
    none, parallel = lanes.spread(0.0), lanes.spread(PARALLEL)
    near, count = np.uint64(near), np.uint64(0)
    for group in range(np.uint64(blocks(near))):
        begin = np.uint64(BLOCK) * group
        ux, vx, wx = gathered(ends, begin, x)
        uy, vy, wy = gathered(ends, begin, y)
        uz, vz, wz = gathered(ends, begin, z)
        uu, uv, vv, uw, vw = products(ux, uy, uz, vx, vy, vz, wx, wy, wz)
        area = uu * vv - uv * uv
        s, t = uv * vw - uw * vv, uu * vw - uv * uw
        mixed = wx * (uy * vz - uz * vy) + wy * (uz * vx - ux * vz) + wz * (ux * vy - uy * vx)
        hits = lanes.mask_greater(s, none) & lanes.mask_greater(area, s)
        hits &= lanes.mask_greater(t, none) & lanes.mask_greater(area, t)
        hits &= lanes.mask_greater(area, parallel * uu * vv) & lanes.mask_greater(squared * area, mixed * mixed)
        hits = (hits | lanes.mask_set(remembers, begin)) & first_lanes(near - begin)
        count = lanes.append_indices(work.hits, count, begin, hits)
    return np.int64(count)


@inlined
def crossing(x, y, z, i, j, k, m):
    """Where the lines of two threads are nearest to each other.

    Returns:
        (whether that is within both, shares of both lengths, common unit normal x y z, gap from the first to the second
        x y z [m]).
    """
    ux, uy, uz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
    vx, vy, vz = x[m] - x[k], y[m] - y[k], z[m] - z[k]
    wx, wy, wz = x[i] - x[k], y[i] - y[k], z[i] - z[k]
    uu, uv, vv, uw, vw = products(ux, uy, uz, vx, vy, vz, wx, wy, wz)
    area = uu * vv - uv * uv
    inverse = 1.0 / max(area, LEAST_SQUARE * LEAST_SQUARE)
    s, t = (uv * vw - uw * vv) * inverse, (uu * vw - uv * uw) * inverse
    within = (s > 0.0) and (s < 1.0) and (t > 0.0) and (t < 1.0) and area > PARALLEL * uu * vv
    root = math.sqrt(inverse)
    return (
        within, s, t, root * (uy * vz - uz * vy), root * (uz * vx - ux * vz), root * (ux * vy - uy * vx),
        t * vx - wx - s * ux, t * vy - wy - s * uy, t * vz - wz - s * uz,
    )  # fmt: skip


@inlined
def rigid_turn(mass, ends, pos, vel, work, a):
    """Write the places of four ends from their common centre of mass to a column of ``work.push``, x y z of each [m].

    Returns:
        (their inverse tensor of inertia xx yy zz xy xz yz [1/(kg m^2)], zeros where they lie along one line; the
        angular rate that has their angular momentum x y z [rad/s]).
    """
    total, cx, cy, cz, ux, uy, uz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for end in range(4):
        m, i = mass[ends[end]], ends[end]
        total += m
        cx, cy, cz = cx + m * pos[0, i], cy + m * pos[1, i], cz + m * pos[2, i]
        ux, uy, uz = ux + m * vel[0, i], uy + m * vel[1, i], uz + m * vel[2, i]
    share = 1.0 / total
    cx, cy, cz, ux, uy, uz = share * cx, share * cy, share * cz, share * ux, share * uy, share * uz
    xx, yy, zz, xy, xz, yz, lx, ly, lz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for end in range(4):
        m, i = mass[ends[end]], ends[end]
        rx, ry, rz = pos[0, i] - cx, pos[1, i] - cy, pos[2, i] - cz
        vx, vy, vz = vel[0, i] - ux, vel[1, i] - uy, vel[2, i] - uz
        work.push[3 * end, a], work.push[3 * end + 1, a], work.push[3 * end + 2, a] = rx, ry, rz
        xx += m * (ry * ry + rz * rz)
        yy += m * (rx * rx + rz * rz)
        zz += m * (rx * rx + ry * ry)
        xy, xz, yz = xy - m * rx * ry, xz - m * rx * rz, yz - m * ry * rz
        lx += m * (ry * vz - rz * vy)
        ly += m * (rz * vx - rx * vz)
        lz += m * (rx * vy - ry * vx)
    axx, axy, axz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    ayy, ayz, azz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    determinant = xx * axx + xy * axy + xz * axz
    mean = (xx + yy + zz) / 3.0
    scale = 1.0 / determinant if determinant > COLLINEAR * mean * mean * mean else 0.0
    axx, ayy, azz, axy, axz, ayz = scale * axx, scale * ayy, scale * azz, scale * axy, scale * axz, scale * ayz
    return (
        axx, ayy, azz, axy, axz, ayz,
        axx * lx + axy * ly + axz * lz, axy * lx + ayy * ly + ayz * lz, axz * lx + ayz * ly + azz * lz,
    )  # fmt: skip


@inlined
def push(work, numbers, mass, kick, pos, vel, found):
    """What the ``found`` pairs do: writes by how much their ends' velocities change in one step to ``work.push``, and
    what they remember to ``work.memory``; ``work.hits`` are then those that touch.

    Returns:
        How many.
    """
    x, y, z = pos[0], pos[1], pos[2]
    stiffness, distance = numbers.crossing_stiffness, numbers.crossing_distance
    damping, grip = stiffness * numbers.crossing_viscosity, numbers.crossing_grip
    slide, step, memory = grip * numbers.crossing_viscosity, numbers.time_step, work.memory
    active = 0
    for hit in range(found):
        n = work.hits[hit]
        p, ends = work.near[n], work.near_ends[:, n]
        i, j, k, m = ends[0], ends[1], ends[2], ends[3]
        within, s, t, nx, ny, nz, gx, gy, gz = crossing(x, y, z, i, j, k, m)
        known = work.near_remembers[n] > 0
        side = nx * gx + ny * gy + nz * gz
        if known:
            side = nx * memory[0, p] + ny * memory[1, p] + nz * memory[2, p]
        if side < 0.0:
            nx, ny, nz = -nx, -ny, -nz
        apart = nx * gx + ny * gy + nz * gz
        if not within or apart >= distance:
            work.near_remembers[n], work.remembers[p] = 0, 0
            continue
        if not known:
            work.near_remembers[n], work.remembers[p] = 1, 1
            for number in range(3, MEMORY):
                memory[number, p] = 0.0
        touch = max(memory[3, p], apart) if known else apart
        memory[0, p], memory[1, p], memory[2, p], memory[3, p] = nx, ny, nz, touch
        shares = (s - 1.0, -s, 1.0 - t, t)
        rx, ry, rz = 0.0, 0.0, 0.0
        for end in range(4):
            e = ends[end]
            rx, ry, rz = rx + shares[end] * vel[0, e], ry + shares[end] * vel[1, e], rz + shares[end] * vel[2, e]
        depth = touch - apart
        pressing = 0.0
        if depth > 0.0:
            pressing = max(stiffness * depth - damping * (rx * nx + ry * ny + rz * nz), 0.0)
        fx, fy, fz = pressing * nx, pressing * ny, pressing * nz
        tx, ty, tz = 0.0, 0.0, 0.0
        if pressing > 0.0 and grip > 0.0:
            xx, yy, zz, xy, xz, yz, ox, oy, oz = rigid_turn(mass, ends, pos, vel, work, active)
            if xx > 0.0:
                rx, ry, rz = rx - (oy * gz - oz * gy), ry - (oz * gx - ox * gz), rz - (ox * gy - oy * gx)
                along = rx * nx + ry * ny + rz * nz
                rx, ry, rz = rx - along * nx, ry - along * ny, rz - along * nz
                bx, by, bz = memory[4, p], memory[5, p], memory[6, p]
                # The bristle turns with the pair.
                bx, by, bz = (
                    bx + step * (oy * bz - oz * by), by + step * (oz * bx - ox * bz), bz + step * (ox * by - oy * bx),
                )  # fmt: skip
                along = bx * nx + by * ny + bz * nz
                bx, by, bz = bx - along * nx + step * rx, by - along * ny + step * ry, bz - along * nz + step * rz
                qx, qy, qz = -grip * bx - slide * rx, -grip * by - slide * ry, -grip * bz - slide * rz
                limit = numbers.friction * pressing
                scale = min(1.0, limit / math.sqrt(max(qx * qx + qy * qy + qz * qz, LEAST_SQUARE)))
                qx, qy, qz = scale * qx, scale * qy, scale * qz
                scale = min(1.0, limit / (grip * math.sqrt(max(bx * bx + by * by + bz * bz, LEAST_SQUARE))))
                memory[4, p], memory[5, p], memory[6, p] = scale * bx, scale * by, scale * bz
                fx, fy, fz = fx + qx, fy + qy, fz + qz
                # Against the moment of the pair of forces over the gap.
                mx, my, mz = gz * qy - gy * qz, gx * qz - gz * qx, gy * qx - gx * qy
                tx, ty, tz = (
                    xx * mx + xy * my + xz * mz, xy * mx + yy * my + yz * mz, xz * mx + yz * my + zz * mz,
                )  # fmt: skip
        else:
            memory[4, p], memory[5, p], memory[6, p] = 0.0, 0.0, 0.0
        gains = work.push[:, active]
        for end in range(4):
            e = ends[end]
            gain = kick[e] * shares[end]
            px, py, pz = 0.0, 0.0, 0.0
            if tx != 0.0 or ty != 0.0 or tz != 0.0:
                px, py, pz = gains[3 * end], gains[3 * end + 1], gains[3 * end + 2]
            gains[3 * end] = gain * fx + step * (ty * pz - tz * py)
            gains[3 * end + 1] = gain * fy + step * (tz * px - tx * pz)
            gains[3 * end + 2] = gain * fz + step * (tx * py - ty * px)
        work.hits[active] = n
        active += 1
    return active


@inlined
def react(work, active, vel):
    """Change the velocities of the ends of the ``active`` pairs."""
    for a in range(active):
        n = work.hits[a]
        for end in range(4):
            e = work.near_ends[end, n]
            for axis in range(3):
                vel[axis, e] += work.push[3 * end + axis, a]
