"""The integration of one scenario over many steps, and of a batch of scenarios on all cores."""

from __future__ import annotations

import math

import numba
import numpy as np

from tethernet_control.layout import KNOT_ROWS

from ..model import CENTRAL_KNOT, KNOTS
from . import contact, pairs, rigid_body, threads
from .options import FAST, kernel


@kernel
def mu_threads(knot_pos, knot_vel, mu_pos, mu_vel, model, mu_force):
    """Pull of the threads between MUs and knots: kicks the knots, adds to ``mu_force``."""
    for m in range(len(model.mu_knot)):
        k = model.mu_knot[m]
        dx, dy, dz = mu_pos[m, 0] - knot_pos[0, k], mu_pos[m, 1] - knot_pos[1, k], mu_pos[m, 2] - knot_pos[2, k]
        squared = dx * dx + dy * dy + dz * dz
        rest = model.mu_thread[m]
        if squared > rest * rest:
            length = math.sqrt(squared)
            rate = (
                (mu_vel[m, 0] - knot_vel[0, k]) * dx
                + (mu_vel[m, 1] - knot_vel[1, k]) * dy
                + (mu_vel[m, 2] - knot_vel[2, k]) * dz
            )
            tension = model.stiffness * (length - rest) + model.damping * rate / length
            tension = max(tension, 0.0) / length
            mu_force[m, 0] -= tension * dx
            mu_force[m, 1] -= tension * dy
            mu_force[m, 2] -= tension * dz


@kernel
def tether_force(knot_pos, knot_vel, chaser, matrix, rate, model, rest, force, torque):
    """Pull of the locked main tether on the central knot.

    Args:
        knot_pos, knot_vel: of the knots.
        chaser: body state (13,).
        matrix: its rotation.
        rate: its angular rate [rad/s].
        model: constants.
        rest: locked length [m].
        force: output, force on the knot [N]; the chaser gets the opposite at its anchor.
        torque: output, torque on the chaser [N m].

    Returns:
        Tension [N].
    """
    for axis in range(3):
        torque[axis] = (
            matrix[axis, 0] * model.tether_anchor[0]
            + matrix[axis, 1] * model.tether_anchor[1]
            + matrix[axis, 2] * model.tether_anchor[2]
        )
    ax, ay, az = torque[0], torque[1], torque[2]
    dx = chaser[0] + ax - knot_pos[0, CENTRAL_KNOT]
    dy = chaser[1] + ay - knot_pos[1, CENTRAL_KNOT]
    dz = chaser[2] + az - knot_pos[2, CENTRAL_KNOT]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    tension = 0.0
    if length > rest:
        vx = chaser[3] + rate[1] * az - rate[2] * ay - knot_vel[0, CENTRAL_KNOT]
        vy = chaser[4] + rate[2] * ax - rate[0] * az - knot_vel[1, CENTRAL_KNOT]
        vz = chaser[5] + rate[0] * ay - rate[1] * ax - knot_vel[2, CENTRAL_KNOT]
        tension = (
            model.tether_stiffness * (length - rest) + model.tether_damping * (vx * dx + vy * dy + vz * dz) / length
        )
        tension = max(tension, 0.0)
    scale = tension / length if length > 0.0 else 0.0
    force[0], force[1], force[2] = scale * dx, scale * dy, scale * dz
    torque[0] = -(ay * force[2] - az * force[1])
    torque[1] = -(az * force[0] - ax * force[2])
    torque[2] = -(ax * force[1] - ay * force[0])
    return tension


@kernel
def gather(knot_pos, mu_pos, particle, out):
    """Write a particle's position or velocity to ``out`` (3,)."""
    if particle < KNOTS:
        out[0], out[1], out[2] = knot_pos[0, particle], knot_pos[1, particle], knot_pos[2, particle]
    else:
        out[0], out[1], out[2] = mu_pos[particle - KNOTS, 0], mu_pos[particle - KNOTS, 1], mu_pos[particle - KNOTS, 2]


@kernel
def advance_scenario(
    model, steps, thrust, external, target_pos, target_vel,
    knot_pos, knot_vel, mu_pos, mu_vel, bodies, bristle, closing, pair_length, locked, tether_length,
):  # fmt: skip
    """Fly one scenario for ``steps`` steps under constant thrust.

    Args:
        model: constants.
        steps: number of steps.
        thrust: per MU [N], (M, 3).
        external: per MU, whether its stand-in follows a target (M,).
        target_pos: the target at the first step [m], (M, 3).
        target_vel: its velocity [m/s], (M, 3).
        knot_pos, knot_vel, mu_pos, mu_vel, bodies, bristle, pair_length, locked: the scenario's state, see State; updated.
        closing: closing has begun.
        tether_length: locked length of the main tether [m].

    Returns:
        Particles in contact with the debris at the last step.
    """
    dt = model.time_step
    mus = len(model.mu_knot)
    row_flags = np.zeros(528, np.uint8)
    column_flags = np.zeros(512, np.uint8)
    row_words, column_words = row_flags.view(np.uint64), column_flags.view(np.uint64)
    first, second = np.empty(threads.DENSE_FROM, np.int64), np.empty(threads.DENSE_FROM, np.int64)
    taut_force = np.empty((3, threads.DENSE_FROM))
    row_force, column_force = np.zeros((3, KNOTS + 1)), np.zeros((3, KNOTS + KNOT_ROWS))
    column_stiffness = np.full(threads.COLUMN_THREADS, model.stiffness)
    column_damping = np.full(threads.COLUMN_THREADS, model.damping)
    mu_force = np.zeros((mus, 3))
    pulls = np.zeros((mus + 1, 3))  # on the MUs' knots, then on the central knot
    pair_forces = np.zeros((len(model.pairs), 3))
    candidates = np.empty(KNOTS + mus, np.int64)
    contact_forces = np.zeros((KNOTS + mus, 3))
    position, velocity, other, other_velocity = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    work = np.zeros((5, 3))
    matrices = np.zeros((2, 3, 3))
    rate, force, torque = np.zeros(3), np.zeros(3), np.zeros(3)
    debris, chaser = bodies[0], bodies[1]
    rigid_body.rotation_matrix(debris, matrices[0])
    rigid_body.rotation_matrix(chaser, matrices[1])
    candidate_count, search_in, coasted, touching = 0, 0, 0, 0

    for step in range(steps):
        # 1. Contact search. Debris without candidates coasts; it is moved just before the next search.
        if search_in == 0:
            if coasted:
                rigid_body.drift_body(debris, matrices[0], model.debris_inertia, coasted * dt)
                coasted = 0
            candidate_count, search_in = contact.find_candidates(
                knot_pos, mu_pos, debris, matrices[0], model, candidates, work[0]
            )
            search_in = max(search_in, 1)
        search_in -= 1

        # 2. Forces, all from the state at the beginning of the step.
        for m in range(mus):
            for axis in range(3):
                mu_force[m, axis] = thrust[m, axis]
                if external[m]:
                    ahead = target_pos[m, axis] + target_vel[m, axis] * (step * dt)
                    mu_force[m, axis] = model.coupling_stiffness * (
                        ahead - mu_pos[m, axis]
                    ) + model.coupling_damping * (target_vel[m, axis] - mu_vel[m, axis])
                pulls[m, axis] = mu_force[m, axis]
        mu_threads(knot_pos, knot_vel, mu_pos, mu_vel, model, mu_force)
        for m in range(mus):
            for axis in range(3):
                pulls[m, axis] -= mu_force[m, axis]
        if closing:
            rigid_body.angular_rate(chaser, matrices[1], model.chaser_inertia, rate)
            tether_force(knot_pos, knot_vel, chaser, matrices[1], rate, model, tether_length, pulls[mus], torque)
            for r in range(len(model.pairs)):
                gather(knot_pos, mu_pos, model.pairs[r, 0], position)
                gather(knot_pos, mu_pos, model.pairs[r, 1], other)
                gather(knot_vel, mu_vel, model.pairs[r, 0], velocity)
                gather(knot_vel, mu_vel, model.pairs[r, 1], other_velocity)
                pairs.pair_force(
                    other[0] - position[0], other[1] - position[1], other[2] - position[2],
                    other_velocity[0] - velocity[0], other_velocity[1] - velocity[1], other_velocity[2] - velocity[2],
                    pair_length[r], locked[r], model, pair_forces[r],
                )  # fmt: skip
        if candidate_count:
            touching = 0
            rigid_body.angular_rate(debris, matrices[0], model.debris_inertia, rate)
            for j in range(candidate_count):
                i = candidates[j]
                gather(knot_pos, mu_pos, i, position)
                gather(knot_vel, mu_vel, i, velocity)
                size, damping = model.knot_radius, model.knot_contact_damping
                if i >= KNOTS:
                    size, damping = model.mu_radius, model.mu_contact_damping
                if contact.contact_force(
                    position,
                    velocity,
                    bristle[i],
                    size,
                    damping,
                    debris,
                    matrices[0],
                    rate,
                    model,
                    contact_forces[j],
                    work,
                ):
                    touching += 1

        # 3. Velocities. The net's threads come first, because they find their forces themselves.
        threads.flag_taut(knot_pos[0], knot_pos[1], knot_pos[2], threads.ROW_THREADS, 1, model.mesh, row_flags)
        threads.clear_row_ends(row_flags)
        threads.flag_taut(
            knot_pos[0], knot_pos[1], knot_pos[2], threads.COLUMN_THREADS, KNOT_ROWS, model.mesh, column_flags
        )
        taut = threads.collect(row_words, 1, first, second, 0, threads.DENSE_FROM)
        if taut <= threads.DENSE_FROM:
            taut = threads.collect(column_words, KNOT_ROWS, first, second, taut, threads.DENSE_FROM)
        if taut <= threads.DENSE_FROM:
            threads.apply_taut(knot_pos, knot_vel, first, second, taut, model, taut_force)
        else:
            threads.apply_all(knot_pos, knot_vel, model, column_stiffness, column_damping, row_force, column_force)
        for m in range(mus):
            knot = model.mu_knot[m]
            for axis in range(3):
                knot_vel[axis, knot] += dt * model.inverse_knot_mass[knot] * pulls[m, axis]
        if closing:
            for axis in range(3):
                knot_vel[axis, CENTRAL_KNOT] += dt * model.inverse_knot_mass[CENTRAL_KNOT] * pulls[mus, axis]
                force[axis] = -pulls[mus, axis]
            rigid_body.kick(chaser, model.chaser_mass, force, torque, dt)
            for r in range(len(model.pairs)):
                a, b = model.pairs[r, 0], model.pairs[r, 1]
                for axis in range(3):
                    if a >= KNOTS:
                        mu_force[a - KNOTS, axis] += pair_forces[r, axis]
                        mu_force[b - KNOTS, axis] -= pair_forces[r, axis]
                    else:
                        knot_vel[axis, a] += dt * model.inverse_knot_mass[a] * pair_forces[r, axis]
                        knot_vel[axis, b] -= dt * model.inverse_knot_mass[b] * pair_forces[r, axis]
        if candidate_count:
            for axis in range(3):
                force[axis] = 0.0
                torque[axis] = 0.0
            for j in range(candidate_count):
                i = candidates[j]
                gather(knot_pos, mu_pos, i, position)
                fx, fy, fz = contact_forces[j, 0], contact_forces[j, 1], contact_forces[j, 2]
                dx, dy, dz = position[0] - debris[0], position[1] - debris[1], position[2] - debris[2]
                force[0] -= fx
                force[1] -= fy
                force[2] -= fz
                torque[0] -= dy * fz - dz * fy
                torque[1] -= dz * fx - dx * fz
                torque[2] -= dx * fy - dy * fx
                for axis in range(3):
                    if i < KNOTS:
                        knot_vel[axis, i] += dt * model.inverse_knot_mass[i] * contact_forces[j, axis]
                    else:
                        mu_force[i - KNOTS, axis] += contact_forces[j, axis]
            rigid_body.kick(debris, model.debris_mass, force, torque, dt)

        # 4. Positions.
        threads.drift(knot_pos, knot_vel, dt)
        for m in range(mus):
            for axis in range(3):
                mu_vel[m, axis] += dt / model.mu_mass * mu_force[m, axis]
                mu_pos[m, axis] += dt * mu_vel[m, axis]
        if candidate_count:
            rigid_body.drift_body(debris, matrices[0], model.debris_inertia, dt)
        else:
            coasted += 1
            touching = 0
        if closing:
            rigid_body.drift_body(chaser, matrices[1], model.chaser_inertia, dt)
            for r in range(len(model.pairs)):
                gather(knot_pos, mu_pos, model.pairs[r, 0], position)
                gather(knot_pos, mu_pos, model.pairs[r, 1], other)
                dx, dy, dz = other[0] - position[0], other[1] - position[1], other[2] - position[2]
                pair_length[r], locked[r] = pairs.reel_in(
                    math.sqrt(dx * dx + dy * dy + dz * dz), pair_length[r], locked[r], model, dt
                )

    if coasted:
        rigid_body.drift_body(debris, matrices[0], model.debris_inertia, coasted * dt)
    if not closing:
        rigid_body.drift_body(chaser, matrices[1], model.chaser_inertia, steps * dt)
    return touching


@kernel
def paid_out(knot_pos, chaser, matrix, anchor):
    """Distance of the central knot from the tether's anchor on the chaser [m]."""
    squared = 0.0
    for axis in range(3):
        place = chaser[axis] + matrix[axis, 0] * anchor[0] + matrix[axis, 1] * anchor[1] + matrix[axis, 2] * anchor[2]
        difference = place - knot_pos[axis, CENTRAL_KNOT]
        squared += difference * difference
    return math.sqrt(squared)


@kernel
def begin_closing(model, knot_pos, mu_pos, chaser, pair_length, locked):
    """Lock the main tether at its present length, take the closing pairs' present distances. Returns the tether's length [m]."""
    position, other = np.zeros(3), np.zeros(3)
    for r in range(len(model.pairs)):
        gather(knot_pos, mu_pos, model.pairs[r, 0], position)
        gather(knot_pos, mu_pos, model.pairs[r, 1], other)
        squared = 0.0
        for axis in range(3):
            squared += (other[axis] - position[axis]) * (other[axis] - position[axis])
        pair_length[r] = math.sqrt(squared)
        locked[r] = False
    matrix = np.zeros((3, 3))
    rigid_body.rotation_matrix(chaser, matrix)
    return paid_out(knot_pos, chaser, matrix, model.tether_anchor)


# The only parallel function: nested parallel and cached numba functions have crashed (numba issues 4807 and 10184).
@numba.njit(cache=True, fastmath=FAST, error_model="numpy", parallel=True, nogil=True)
def advance(
    model, steps, chosen, thrust, external, target_pos, target_vel,
    knot_pos, knot_vel, mu_pos, mu_vel, bodies, bristle, closing, pair_length, locked, tether_length, contacts,
):  # fmt: skip
    """Fly the ``chosen`` scenarios of a batch for ``steps`` steps; arrays as in State, with the leading scenario axis."""
    for c in numba.prange(len(chosen)):
        b = chosen[c]
        contacts[b] = advance_scenario(
            model, steps, thrust[b], external[b], target_pos[b], target_vel[b],
            knot_pos[b], knot_vel[b], mu_pos[b], mu_vel[b], bodies[b], bristle[b],
            closing[b], pair_length[b], locked[b], tether_length[b],
        )  # fmt: skip
