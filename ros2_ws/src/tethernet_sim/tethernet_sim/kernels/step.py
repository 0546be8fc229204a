"""The integration of one scenario, and of one after the other, over many steps."""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels import (
    collisions,
    contact,
    debris_body,
    net,
    net_contact,
    pairs,
    rigid_body,
    thread_contact,
    thread_points,
)
from tethernet_sim.kernels.options import entry_point, inlined, inlined_once, kernel
from tethernet_sim.kernels.rows import aligned_rows, padded, row_width


@inlined
def mu_threads(knot_pos, knot_vel, mu_pos, mu_vel, knots, lengths, stiffness, damping, mu_force, pulls):
    """Pull of the threads between MUs and knots: adds to ``mu_force`` (M, 3), written to ``pulls`` (M, 3) for the
    knots [N].
    """
    for m in range(len(knots)):
        k = knots[m]
        dx, dy, dz = mu_pos[m, 0] - knot_pos[0, k], mu_pos[m, 1] - knot_pos[1, k], mu_pos[m, 2] - knot_pos[2, k]
        squared = dx * dx + dy * dy + dz * dz
        rest = lengths[m]
        pull = 0.0
        if squared > rest * rest:
            inverse = 1.0 / math.sqrt(squared)
            rate = (
                (mu_vel[m, 0] - knot_vel[0, k]) * dx
                + (mu_vel[m, 1] - knot_vel[1, k]) * dy
                + (mu_vel[m, 2] - knot_vel[2, k]) * dz
            ) * inverse
            tension = stiffness[m] * (squared * inverse - rest) + damping[m] * rate
            pull = max(tension, 0.0) * inverse
        pulls[m, 0], pulls[m, 1], pulls[m, 2] = pull * dx, pull * dy, pull * dz
        for axis in range(3):
            mu_force[m, axis] -= pulls[m, axis]


@inlined
def follow_targets(stiffness, damping, external, ahead, target_pos, target_vel, mu_pos, mu_vel, mu_force):
    """Draw the stand-ins of external MUs after their targets, ``ahead`` [s] of the last measurement: overwrites their
    ``mu_force``.
    """
    for m in range(len(external)):
        if external[m]:
            for axis in range(3):
                target = target_pos[m, axis] + target_vel[m, axis] * ahead
                mu_force[m, axis] = stiffness[m] * (target - mu_pos[m, axis]) + damping[m] * (
                    target_vel[m, axis] - mu_vel[m, axis]
                )


@inlined
def tether_force(knot_pos, knot_vel, chaser, matrix, rate, numbers, rest, force, torque):
    """Pull of the locked main tether on the node that it hangs on.

    Args:
        knot_pos, knot_vel: of the knots.
        chaser: body state (13,).
        matrix: its rotation.
        rate: its angular rate [rad/s].
        numbers: constants of the model.
        rest: locked length [m].
        force: output, force on the knot [N]; the chaser gets the opposite at its anchor.
        torque: output, torque on the chaser [N m].

    Returns:
        Tension [N].
    """
    anchor, center = numbers.tether_anchor, numbers.center_node
    ax, ay, az = anchor * matrix[0, 2], anchor * matrix[1, 2], anchor * matrix[2, 2]
    dx = chaser[0] + ax - knot_pos[0, center]
    dy = chaser[1] + ay - knot_pos[1, center]
    dz = chaser[2] + az - knot_pos[2, center]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    tension = 0.0
    if length > rest:
        vx = chaser[3] + rate[1] * az - rate[2] * ay - knot_vel[0, center]
        vy = chaser[4] + rate[2] * ax - rate[0] * az - knot_vel[1, center]
        vz = chaser[5] + rate[0] * ay - rate[1] * ax - knot_vel[2, center]
        tension = (
            numbers.tether_stiffness * (length - rest) + numbers.tether_damping * (vx * dx + vy * dy + vz * dz) / length
        )
        tension = max(tension, 0.0)
    scale = tension / length if length > 0.0 else 0.0
    force[0], force[1], force[2] = scale * dx, scale * dy, scale * dz
    torque[0] = -(ay * force[2] - az * force[1])
    torque[1] = -(az * force[0] - ax * force[2])
    torque[2] = -(ax * force[1] - ay * force[0])
    return tension


@inlined
def drift(pos, vel, knots, time_step):
    """Move the knots with their new velocities; what fills up the rows stays 0."""
    for axis in range(3):
        place, speed = pos[axis], vel[axis]
        for i in range(padded(knots)):
            place[i] += time_step * speed[i]


@inlined_once
def advance_scenario(
    numbers, arrays, threads, body, steps, thrust, external, target_pos, target_vel, chaser_force,
    all_knot_pos, all_knot_vel, mu_pos, mu_vel, bodies, bristle, crossed, crossed_count, closing, pair_length, locked,
    winch_length, tether_length,
):  # fmt: skip
    """Fly one scenario for ``steps`` steps under constant thrust.

    Args:
        numbers: scalar constants.
        arrays: constant arrays.
        threads: the net's threads, see kernels.net.
        body: constants of the debris, see kernels.debris_body.
        steps: number of steps.
        thrust: per MU [N], (M, 3).
        external: per MU, whether its stand-in follows a target (M,).
        target_pos: the target at the first step [m], (M, 3).
        target_vel: its velocity [m/s], (M, 3).
        chaser_force: thrust on the chaser's centre of mass [N], (3,); felt once closing has begun.
        all_knot_pos, all_knot_vel, mu_pos, mu_vel, bodies, bristle, crossed, pair_length, locked, winch_length: the
            scenario's state, see State; updated.
        crossed_count: how many pairs of threads touch (1,); updated. More than ``crossed`` has room for means that the
            steps have to be flown again with more.
        closing: closing has begun.
        tether_length: locked length of the main tether [m].

    Returns:
        Contacts with the debris at the last step: particles, and points of threads.
    """
    all_pairs = arrays.pairs
    mu_knot, mu_thread, mu_inverse_mass = arrays.mu_knot, arrays.mu_thread, arrays.mu_inverse_mass
    mu_stiffness, mu_damping = arrays.mu_stiffness, arrays.mu_damping
    joint_damping, contact_damping = arrays.joint_damping, arrays.contact_damping
    dt, knots, center = numbers.time_step, numbers.knots, numbers.center_node
    mus = len(mu_knot)
    width = row_width(knots, mus)
    thread_work = net.workspace(threads, width)
    kick = np.zeros(width)
    kick[:knots] = arrays.kick
    mu_force = np.zeros((mus, 3))
    pulls = np.zeros((mus + 1, 3))  # on the MUs' knots, then on the knot that the main tether hangs on
    pair_forces, pair_span = np.zeros((len(all_pairs), 3)), np.zeros((len(all_pairs), 5))
    near, touching = np.empty(width, np.uint32), np.empty(width, np.uint32)
    busy, near_flags = np.empty(width, np.uint32), np.zeros(width, np.uint8)
    near_blocks = near_flags.view(np.uint64)
    segments = len(arrays.segments)
    points_of_threads = thread_points.workspace(segments, debris_body.parts(body))
    most_points = len(points_of_threads.share)
    net_threads, mass = arrays.crossing_threads, arrays.knot_mass
    crossing_work = net_contact.begin(net_threads, width, crossed, crossed_count)
    work = np.empty(contact.blocks(knots + mus) * contact.ROWS * contact.BLOCK)
    work_of_threads = np.empty(contact.blocks(most_points) * contact.ROWS * contact.BLOCK)
    held, kept = np.empty((3, width)), np.empty(width)
    squared = np.empty(width)
    ordered = squared.view(np.uint64)
    debris_matrix, chaser_matrix = np.zeros((3, 3)), np.zeros((3, 3))
    rate, force, torque = np.zeros(3), np.zeros(3), np.zeros(3)
    debris_force, debris_torque = np.zeros(3), np.zeros(3)
    meeting, near_meeting = np.empty(len(arrays.meeting) + 1, np.int64), 0
    at_chaser, near_chaser = np.empty(knots + mus + 1, np.int64), 0
    pushes, chaser_push, chaser_twist = np.zeros((knots + mus, 3)), np.zeros(3), np.zeros(3)
    debris, chaser = bodies[0], bodies[1]
    any_external = external.any()
    tether_pull = pulls[mus]
    rigid_body.rotation_matrix(debris, debris_matrix)
    rigid_body.rotation_matrix(chaser, chaser_matrix)
    near_knots, near_count, touching_knots, touching_count, contacts = 0, 0, 0, 0, 0
    search_in, coasted = 0, 0
    listed, searches_left, points, active, step_reach = 0, 0, 0, 0, 0.0
    knot_pos, knot_vel = aligned_rows(width), aligned_rows(width)
    knot_pos[:, :knots], knot_vel[:, :knots] = all_knot_pos, all_knot_vel

    # A name that changes from step to step would have its arrays' references counted in each.
    flown, needed = 0, 0
    while flown < steps:
        if needed:
            crossing_work = net_contact.with_room(net_threads, crossing_work, 2 * needed)
        for step in range(flown, steps):
            needed = net_contact.look(net_threads, crossing_work, numbers, knots, knot_pos, knot_vel)
            if needed:
                break
            flown += 1

            # 1. Contact search. Debris without candidates coasts; it is moved just before the next search.
            if search_in == 0:
                if coasted:
                    debris_body.drift(body, debris, debris_matrix, coasted * dt)
                    coasted = 0
                debris_body.rate(body, debris, debris_matrix, rate)
                spin = math.sqrt(rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2])
                farthest = debris_body.farthest(body)
                speed = contact.fastest(knot_vel, mu_vel, knots, debris, spin, farthest, squared, ordered)
                contact.store_bristles(bristle, near, near_count, held)
                near_knots, near_count, search_in = contact.find_candidates(
                    knot_pos, mu_pos, body, debris, debris_matrix, numbers, speed, near, squared, ordered, near_flags,
                    near_blocks, busy,
                )  # fmt: skip
                contact.fetch_bristles(bristle, near, near_count, held)
                if segments:
                    former = points
                    thread_contact.store_bristles(bristle, points_of_threads, former)
                    points = 0
                    if search_in > contact.NEAR_STEPS:
                        searches_left = 0
                    else:
                        if searches_left == 0:
                            searches_left = thread_points.LIST_SEARCHES
                            listed = thread_points.list_segments(
                                points_of_threads, arrays, segments if closing else numbers.open_segments, knot_pos,
                                mu_pos, body, debris, debris_matrix, numbers,
                                speed * searches_left * contact.NEAR_STEPS * dt,
                            )  # fmt: skip
                        searches_left -= 1
                        step_reach = speed * dt
                        points = thread_points.find_points(
                            points_of_threads, arrays, listed, knot_pos, mu_pos, body, debris, debris_matrix, numbers,
                            speed * contact.NEAR_STEPS * dt,
                        )  # fmt: skip
                    thread_contact.fetch_bristles(bristle, points_of_threads, points, former)
                    if step == 0:  # the points of the steps flown before are not known any more
                        thread_contact.forget_bristles(bristle, knots + mus)
                search_in = max(search_in, 1)
                if closing:
                    # Each of two particles may be as fast as that, and the chaser as it is.
                    margin = 2.0 * search_in * dt * speed
                    near_meeting = collisions.near_pairs(arrays, knot_pos, mu_pos, knots, margin, meeting)
                    margin += search_in * dt * collisions.relative_speed(chaser, debris)
                    near_chaser = collisions.near_chaser(knot_pos, mu_pos, knots, numbers, chaser, margin, at_chaser)
            search_in -= 1

            # 2. Forces, all from the state at the beginning of the step.
            for m in range(mus):
                for axis in range(3):
                    mu_force[m, axis] = thrust[m, axis]
            if any_external:
                follow_targets(
                    arrays.coupling_stiffness, arrays.coupling_damping, external, step * dt, target_pos, target_vel,
                    mu_pos, mu_vel, mu_force,
                )  # fmt: skip
            mu_threads(
                knot_pos, knot_vel, mu_pos, mu_vel, mu_knot, mu_thread, mu_stiffness, mu_damping, mu_force, pulls
            )
            if closing:
                if center >= 0:
                    rigid_body.angular_rate(chaser, chaser_matrix, numbers.chaser_inertia, numbers.chaser_inertia, rate)
                    tether_force(
                        knot_pos, knot_vel, chaser, chaser_matrix, rate, numbers, tether_length, tether_pull, torque
                    )
                pairs.pair_forces(
                    knot_pos, knot_vel, mu_pos, mu_vel, all_pairs, arrays.pair_winch, arrays.winch_begin, pair_length,
                    locked, winch_length, joint_damping, numbers, pair_span, pair_forces,
                )  # fmt: skip
                collisions.units(arrays, numbers, meeting, near_meeting, mu_pos, mu_vel, mu_force)
                if near_chaser:
                    rigid_body.angular_rate(chaser, chaser_matrix, numbers.chaser_inertia, numbers.chaser_inertia, rate)
                collisions.on_chaser(
                    arrays, numbers, at_chaser, near_chaser, knot_pos, knot_vel, mu_pos, mu_vel, chaser, chaser_matrix,
                    rate, pushes, chaser_push, chaser_twist,
                )  # fmt: skip
            net_contact.push(net_threads, crossing_work, numbers, mass, kick, knot_pos, knot_vel)
            contacts = 0
            if near_count + points:
                for axis in range(3):
                    debris_force[axis], debris_torque[axis] = 0.0, 0.0
                debris_body.rate(body, debris, debris_matrix, rate)
                touching_knots, touching_count = contact.find_touching(
                    knot_pos, mu_pos, body, debris, debris_matrix, numbers, near, near_knots, near_count, held, kept,
                    touching,
                )  # fmt: skip
                contact.gather(
                    knot_pos, knot_vel, mu_pos, mu_vel, debris, contact_damping, arrays.mu_radius, numbers, near, held,
                    touching, touching_knots, touching_count, work,
                )  # fmt: skip
                filled = contact.fill_up(work, touching_count)
                contacts = contact.contact_forces(
                    work, filled, body, debris, debris_matrix, rate, numbers, False, debris_force, debris_torque
                )
                if points:
                    active = thread_contact.gather(
                        points_of_threads, points, knot_pos, knot_vel, mu_pos, mu_vel, body, debris, debris_matrix,
                        knots, step_reach * (contact.NEAR_STEPS - search_in), work_of_threads,
                    )  # fmt: skip
                    filled = contact.fill_up(work_of_threads, active)
                    contacts += contact.contact_forces(
                        work_of_threads, filled, body, debris, debris_matrix, rate, numbers, True, debris_force,
                        debris_torque,
                    )  # fmt: skip

            # 3. Velocities. The net's threads come first, because they find their forces themselves.
            net.apply(threads, thread_work, knot_pos, knot_vel, kick, dt)
            net_contact.react(net_threads, crossing_work, knot_vel)
            for m in range(mus):
                knot = mu_knot[m]
                for axis in range(3):
                    knot_vel[axis, knot] += kick[knot] * pulls[m, axis]
            if closing:
                for axis in range(3):
                    force[axis] = chaser_force[axis] + chaser_push[axis]
                    chaser_twist[axis] += torque[axis]
                if center >= 0:
                    for axis in range(3):
                        knot_vel[axis, center] += kick[center] * pulls[mus, axis]
                        force[axis] -= pulls[mus, axis]
                rigid_body.kick(chaser, numbers.chaser_mass, force, chaser_twist, dt)
                collisions.react(at_chaser, near_chaser, pushes, kick, knots, knot_vel, mu_force)
                pairs.apply(all_pairs, pair_forces, kick, knots, knot_vel, mu_force)
            if near_count + points:
                contact.react(
                    near, held, touching, touching_knots, touching_count, work, kick, knots, knot_vel, mu_force
                )
                if points:
                    thread_contact.react(
                        points_of_threads, active, work_of_threads, kick, knots, knot_vel, mu_force, dt
                    )  # fmt: skip
                rigid_body.kick(debris, body.mass, debris_force, debris_torque, dt)

            # 4. Positions.
            drift(knot_pos, knot_vel, knots, dt)
            for m in range(mus):
                for axis in range(3):
                    mu_vel[m, axis] += dt * mu_force[m, axis] * mu_inverse_mass[m]
                    mu_pos[m, axis] += dt * mu_vel[m, axis]
            if near_count + points:
                debris_body.step(body, debris, debris_matrix, dt)
            else:
                coasted += 1
            if closing:
                rigid_body.small_rotation_step(
                    chaser, chaser_matrix, numbers.chaser_inertia, numbers.chaser_inertia, dt
                )

    contact.store_bristles(bristle, near, near_count, held)
    thread_contact.store_bristles(bristle, points_of_threads, points)
    net_contact.end(net_threads, crossing_work, crossed, crossed_count)
    all_knot_pos[:], all_knot_vel[:] = knot_pos[:, :knots], knot_vel[:, :knots]
    if coasted:
        debris_body.drift(body, debris, debris_matrix, coasted * dt)
    if not closing:
        rigid_body.drift_body(chaser, chaser_matrix, numbers.chaser_inertia, numbers.chaser_inertia, steps * dt)
    return contacts


@kernel
def begin_closing(numbers, arrays, knot_pos, mu_pos, chaser, pair_length, locked, winch_length):
    """Lock the main tether at its present length, and the winches' threads. Returns the tether's length [m], 0 where
    there is none.
    """
    winch_length[:] = 0.0
    all_pairs, center = arrays.pairs, numbers.center_node
    for r in range(len(all_pairs)):
        pair_length[r] = pairs.distance(knot_pos, mu_pos, numbers.knots, all_pairs[r, 0], all_pairs[r, 1])
        locked[r] = False
        if arrays.pair_winch[r] >= 0:
            winch_length[arrays.pair_winch[r]] += pair_length[r]
    if center < 0:
        return 0.0
    matrix = np.zeros((3, 3))
    rigid_body.rotation_matrix(chaser, matrix)
    squared = 0.0
    for axis in range(3):
        anchor = chaser[axis] + matrix[axis, 2] * numbers.tether_anchor
        squared += (anchor - knot_pos[axis, center]) * (anchor - knot_pos[axis, center])
    return math.sqrt(squared)


@entry_point
def advance(
    numbers, arrays, threads, body, steps, chosen, thrust, external, target_pos, target_vel, chaser_force,
    knot_pos, knot_vel, mu_pos, mu_vel, bodies, bristle, crossed, crossed_count, closing, pair_length, locked,
    winch_length, tether_length, contacts,
):  # fmt: skip
    """Fly the ``chosen`` scenarios of a batch for ``steps`` steps; arrays as in State, with the leading scenario
    axis.
    """
    for b in chosen:
        contacts[b] = advance_scenario(
            numbers, arrays, threads, body, steps, thrust[b], external[b], target_pos[b], target_vel[b],
            chaser_force[b], knot_pos[b], knot_vel[b], mu_pos[b], mu_vel[b], bodies[b], bristle[b], crossed[b],
            crossed_count[b : b + 1], closing[b], pair_length[b], locked[b], winch_length[b], tether_length[b],
        )  # fmt: skip
