"""What every force of one step does: work and dissipation, found from the laws of forces once more, apart from the
kernels that fly.

A step changes velocities by h F / m and then moves everything with the new velocities, so that the work of a force F on
a particle is h F (v + v') / 2 exactly, v before and v' after. A winch or motor that moves the end of a spring works
against the force that acts in the step, on both ends alike, over all of its way. What a spring stores is read from the
state before and after; here is only what neither stays kinetic nor is stored: thrust, motors, dampers, slip.
"""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels import collisions, contact, crossing_energy, debris_body, thread_points
from tethernet_sim.kernels.crossing_energy import WORK
from tethernet_sim.kernels.options import entry_point, ieee
from tethernet_sim.kernels.rigid_body import angular_rate, rotation_matrix
from tethernet_sim.kernels.step import advance_scenario

THRUST, WINCH_IN, JOINT_IN, THREADS, TETHER, CONTACT, FRICTION, WINCH_SLIP, JOINTS = range(1, 10)
HELD = 10
TERMS = 12
"""Rows of the ledger [J]: the work of all forces on all bodies; put in by thrusters, winches and joints' motors; taken
out by the dampers of threads and of the tether, contact, friction, slipping winches, the dampers of joints. HELD is no
term: what the bristles of threads hold after the last step. The last row, and WORK, are crossing_energy's too."""
THREADS_NEAR_M = 0.05
"""Points of threads that are farther away do not touch in this step."""


@ieee
def _kelvin_voigt(stiffness, damping, stretch, rate):
    """Tension of a spring and damper that only pull [N], and the damper's part of it [N]."""
    if stretch <= 0.0:
        return 0.0, 0.0
    tension = max(stiffness * stretch + damping * rate, 0.0)
    return tension, tension - stiffness * stretch


@ieee
def _between(a, b, va, vb, wa, wb):
    """Distance of two points [m], its rate before [m/s] and its mean rate in the step [m/s]."""
    squared, before, after = 0.0, 0.0, 0.0
    for axis in range(3):
        offset = b[axis] - a[axis]
        squared += offset * offset
        before += offset * (vb[axis] - va[axis])
        after += offset * (wb[axis] - wa[axis])
    length = math.sqrt(squared)
    scale = 1.0 / max(length, 1e-9)
    return length, before * scale, 0.5 * (before + after) * scale


@ieee
def _net(ledger, numbers, arrays, x, v, w, mu_pos, mu_vel, mu_vel_after):
    # Few arrays by hand instead of all constants: they are copied at every call.
    threads, rests, stiffness, damping = arrays.threads, arrays.rest, arrays.stiffness, arrays.damping
    work, lost = 0.0, 0.0
    for t in range(len(threads)):
        i, j, rest = threads[t, 0], threads[t, 1], rests[t]
        dx, dy, dz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
        squared = dx * dx + dy * dy + dz * dz
        if squared > rest * rest:
            length = math.sqrt(squared)
            rate = (dx * (v[0, j] - v[0, i]) + dy * (v[1, j] - v[1, i]) + dz * (v[2, j] - v[2, i])) / length
            after = (dx * (w[0, j] - w[0, i]) + dy * (w[1, j] - w[1, i]) + dz * (w[2, j] - w[2, i])) / length
            tension, damper = _kelvin_voigt(stiffness[t], damping[t], length - rest, rate)
            work += tension * 0.5 * (rate + after)
            lost += damper * 0.5 * (rate + after)
    for m in range(len(mu_pos)):
        knot = arrays.mu_knot[m]
        length, rate, mean = _between(
            x[:, knot], mu_pos[m], v[:, knot], mu_vel[m], w[:, knot], mu_vel_after[m]
        )  # fmt: skip
        stretch = length - arrays.mu_thread[m]
        tension, damper = _kelvin_voigt(arrays.mu_stiffness[m], arrays.mu_damping[m], stretch, rate)
        work += tension * mean
        lost += damper * mean
    ledger[WORK] -= numbers.time_step * work
    ledger[THREADS] += numbers.time_step * lost


@ieee
def _tether(ledger, numbers, x, v, w, chaser, chaser_after, rest):
    matrix, before, after = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    rotation_matrix(chaser, matrix)
    angular_rate(chaser, matrix, numbers.chaser_inertia, numbers.chaser_inertia, before)
    angular_rate(chaser_after, matrix, numbers.chaser_inertia, numbers.chaser_inertia, after)
    arm = numbers.tether_anchor * matrix[:, 2]
    length, rate, mean = _between(
        x, chaser[:3] + arm, v, chaser[3:6] + np.cross(before, arm), w, chaser_after[3:6] + np.cross(after, arm)
    )
    tension, damper = _kelvin_voigt(numbers.tether_stiffness, numbers.tether_damping, length - rest, rate)
    ledger[WORK] -= numbers.time_step * tension * mean
    ledger[TETHER] += numbers.time_step * damper * mean


@ieee
def _particle(knots, mus, number):
    count = knots.shape[1]
    return knots[:, number] if number < count else mus[number - count]


@ieee
def _closing(ledger, numbers, arrays, x, v, w, mus, mu_vel, mu_vel_after, joints, locks, threads):
    """``joints``, ``locks``, ``threads``: lengths of joints, which are locked, lengths of threads; before and after."""
    h, pairs = numbers.time_step, arrays.pairs
    span = np.zeros((len(pairs), 3))
    for r in range(len(pairs)):
        a, b = pairs[r, 0], pairs[r, 1]
        span[r] = _between(
            _particle(x, mus, a), _particle(x, mus, b), _particle(v, mu_vel, a), _particle(v, mu_vel, b),
            _particle(w, mu_vel_after, a), _particle(w, mu_vel_after, b),
        )  # fmt: skip
        if locks[1, r]:
            length, rate, mean = span[r]
            tension = numbers.joint_stiffness * max(length - joints[1, r], 0.0)
            damper = arrays.joint_damping[r] * rate
            ledger[JOINT_IN] += tension * ((joints[0, r] if locks[0, r] else length) - joints[1, r])
            ledger[WORK] -= h * (tension + damper) * mean
            ledger[JOINTS] += h * damper * mean
    for thread in range(threads.shape[1]):
        stretch, mean = np.array([-threads[0, thread], -threads[1, thread]]), 0.0
        for r in range(arrays.winch_begin[thread], arrays.winch_begin[thread + 1]):
            stretch[0] += 0.0 if locks[0, r] else span[r, 0]
            if not locks[1, r]:
                stretch[1] += span[r, 0]
                mean += span[r, 2]
        tension = numbers.winch_stiffness * max(stretch[1], 0.0)
        by_winch = tension * (stretch[1] - stretch[0])
        ledger[WINCH_IN] += max(by_winch, 0.0)
        ledger[WINCH_SLIP] += max(-by_winch, 0.0)
        ledger[WORK] -= h * tension * mean


@ieee
def _contact(
    ledger, numbers, k, damping, size, place, speed, speed_after, along, body, debris, debris_after, matrix, rates, held
):  # fmt: skip
    """One particle, or one point of a thread ``along`` a unit vector (launch frame; 0 for a particle): ``rates`` (2, 3)
    of the debris before and after [rad/s], ``held`` its bristle before [m]. Returns what its bristle holds after [J].
    """
    h = numbers.time_step
    arm = place - debris[:3]
    local, bristle = matrix.T @ arm, 0.5 * k * np.dot(held, held)
    distance, nx, ny, nz = debris_body.surface(body, local[0], local[1], local[2])
    depth = size - distance
    if depth <= 0.0:
        ledger[FRICTION] += bristle  # what has let go has lost what its bristle held
        return 0.0
    slip = matrix.T @ (speed - debris[3:6] - np.cross(rates[0], arm))
    later = matrix.T @ (speed_after - debris_after[3:6] - np.cross(rates[1], arm))
    mean = 0.5 * (slip + later)
    normal, direction = np.array([nx, ny, nz]), matrix.T @ along
    normal = normal - np.dot(normal, direction) * direction
    steepness = math.sqrt(max(np.dot(normal, normal), contact.LEAST_STEEPNESS))
    normal = normal / steepness
    spring = steepness * k * depth
    pressing = max(spring - steepness * steepness * damping * np.dot(slip, normal), 0.0)
    ledger[WORK] += h * pressing * np.dot(mean, normal)
    ledger[CONTACT] -= h * (pressing - spring) * np.dot(mean, normal)
    first = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 0.8 else np.array([1.0, 0.0, 0.0])
    first -= np.dot(first, normal) * normal
    first /= math.sqrt(np.dot(first, first))
    limit = numbers.friction * pressing
    ledger[FRICTION] += bristle
    kept = 0.0
    for direction in (first, np.cross(normal, first)):
        was, slide, way = np.dot(held, direction), np.dot(slip, direction), np.dot(mean, direction)
        ledger[FRICTION] -= 0.5 * k * was * was  # what stays is what turned out of the tangent plane
        raw = was + h * slide
        stuck = min(max(raw, -limit / k), limit / k)
        force = min(max(-k * raw - damping * slide, -limit), limit)
        ledger[WORK] += h * force * way
        ledger[FRICTION] += k * stuck * (raw - stuck) - h * (force + k * stuck) * way
        kept += 0.5 * k * stuck * stuck
    return kept


@ieee
def _collisions(ledger, numbers, arrays, x, v, w, mus, mu_vel, mu_vel_after, chaser, chaser_after):
    """Units with each other, knots and units with the chaser."""
    h = numbers.time_step
    for p in range(len(arrays.meeting)):
        force, damper, depth, nx, ny, nz = collisions.unit_push(arrays, numbers, p, mus, mu_vel)
        if depth > 0.0:
            a, b = arrays.meeting[p, 0], arrays.meeting[p, 1]
            mean = 0.5 * (mu_vel[b] + mu_vel_after[b] - mu_vel[a] - mu_vel_after[a])
            rate = mean[0] * nx + mean[1] * ny + mean[2] * nz
            ledger[WORK] += h * force * rate
            ledger[CONTACT] -= h * damper * rate
    matrix, before, after = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    rotation_matrix(chaser, matrix)
    angular_rate(chaser, matrix, numbers.chaser_inertia, numbers.chaser_inertia, before)
    angular_rate(chaser_after, matrix, numbers.chaser_inertia, numbers.chaser_inertia, after)
    for p in range(numbers.knots + len(mus)):
        place, speed, later = _particle(x, mus, p), _particle(v, mu_vel, p), _particle(w, mu_vel_after, p)
        force, damper, depth, _, nx, ny, nz = collisions.chaser_push(
            arrays, numbers, p, place, speed, chaser, matrix, before
        )
        if depth > 0.0:
            arm = place - chaser[:3]
            mean = 0.5 * (speed + later - chaser[3:6] - chaser_after[3:6] - np.cross(before + after, arm))
            rate = mean[0] * nx + mean[1] * ny + mean[2] * nz
            ledger[WORK] += h * force * rate
            ledger[CONTACT] -= h * damper * rate


@entry_point
def stored_in_collisions(numbers, arrays, knots, mu_pos, chaser):
    """Energy in the contacts of units with each other and of anything with the chaser [J]: of one scenario that closes,
    arrays as in State.
    """
    total, stiffness, still = 0.0, numbers.contact_stiffness * numbers.mu_contact_share, np.zeros(3)
    at_rest, matrix = np.zeros(mu_pos.shape), np.zeros((3, 3))
    for p in range(len(arrays.meeting)):
        depth = collisions.unit_push(arrays, numbers, p, mu_pos, at_rest)[2]
        total += 0.5 * stiffness * depth * depth
    rotation_matrix(chaser, matrix)
    for p in range(numbers.knots + len(mu_pos)):
        _, _, depth, stiffness, _, _, _ = collisions.chaser_push(
            arrays, numbers, p, _particle(knots, mu_pos, p), still, chaser, matrix, still
        )
        total += 0.5 * stiffness * depth * depth
    return total


@ieee
def _touching_threads(numbers, arrays, body, knots, mu_pos, debris, matrix, closing, work):
    """Find the points that touch. Returns how many there are."""
    count = len(arrays.segments) if closing else numbers.open_segments
    listed = thread_points.list_segments(
        work, arrays, count, knots, mu_pos, body, debris, matrix, numbers, THREADS_NEAR_M
    )
    return thread_points.find_points(work, arrays, listed, knots, mu_pos, body, debris, matrix, numbers, THREADS_NEAR_M)


@ieee
def _threads(
    ledger, numbers, arrays, knots, v, w, mu_pos, mu_vel, mu_vel_after, body, debris, debris_after, matrix, rates,
    bristle, points, work,
):  # fmt: skip
    """All touching points of threads; their stiffness may be another than at the step before, which friction pays."""
    held = 0.0
    for p in range(points):
        of_point = bristle[work.bristle[p]]
        held += 0.5 * numbers.contact_stiffness * work.numbers[2, p] * work.weight[p] * np.dot(of_point, of_point)
    ledger[FRICTION] += ledger[HELD] - held
    ledger[HELD] = 0.0
    for p in range(points):
        i, j, share, weight = work.ends[0, p], work.ends[1, p], work.share[p], work.weight[p]
        start, end = _particle(knots, mu_pos, i), _particle(knots, mu_pos, j)
        along = end - start
        along = along / math.sqrt(np.dot(along, along)) if 0.0 < share < 1.0 else np.zeros(3)
        ledger[HELD] += _contact(
            ledger, numbers, numbers.contact_stiffness * work.numbers[2, p] * weight, work.numbers[1, p] * weight,
            work.numbers[0, p], start + share * (end - start),
            (1.0 - share) * _particle(v, mu_vel, i) + share * _particle(v, mu_vel, j),
            (1.0 - share) * _particle(w, mu_vel_after, i) + share * _particle(w, mu_vel_after, j),
            along, body, debris, debris_after, matrix, rates, bristle[work.bristle[p]],
        )  # fmt: skip


@entry_point
def stored_in_threads(numbers, arrays, body, knots, mu_pos, debris, bristle, closing):
    """Energy in the contacts of threads [J]: of one scenario, arrays as in State."""
    matrix = np.zeros((3, 3))
    rotation_matrix(debris, matrix)
    work = thread_points.workspace(len(arrays.segments), debris_body.parts(body))
    points = _touching_threads(numbers, arrays, body, knots, mu_pos, debris, matrix, closing, work)
    total = 0.0
    for p in range(points):
        share = work.share[p]
        start, end = _particle(knots, mu_pos, work.ends[0, p]), _particle(knots, mu_pos, work.ends[1, p])
        local = matrix.T @ (start + share * (end - start) - debris[:3])
        depth = work.numbers[0, p] - debris_body.surface(body, local[0], local[1], local[2])[0]
        if depth > 0.0:
            of_point = bristle[work.bristle[p]]
            stiffness = numbers.contact_stiffness * work.numbers[2, p] * work.weight[p]
            total += 0.5 * stiffness * (depth * depth + np.dot(of_point, of_point))
    return total


@ieee
def book_step(
    ledger, numbers, arrays, body, thrust, chaser_force, closing, tether_length, knots, knot_vels, mu_pos, mu_vels,
    bodies, bristle, joints, locks, threads, work,
):  # fmt: skip
    """Add what one step did to the ``ledger`` (TERMS,) [J].

    Args:
        ledger: updated.
        numbers: scalar constants of the model.
        arrays: constant arrays of the model.
        body: constants of the debris.
        thrust: of the MUs in this step [N], (M, 3).
        chaser_force: thrust of the chaser [N], (3,); felt once closing has begun.
        closing: whether closing has begun.
        tether_length: of the locked tether [m].
        knots: positions before [m], (3, N).
        knot_vels: velocities before and after [m/s], (2, 3, N).
        mu_pos: positions before [m], (M, 3).
        mu_vels: velocities before and after [m/s], (2, M, 3).
        bodies: before and after, (2, 2, 13).
        bristle: before [m], see State.
        joints: rest lengths of the pairs before and after [m], (2, R).
        locks: which pairs are locked before and after, (2, R).
        threads: rest lengths of the winches' threads before and after [m], (2, S).
        work: of thread_points.workspace.
    """
    v, w = knot_vels[0], knot_vels[1]
    given = 0.0
    for m in range(len(mu_pos)):
        for axis in range(3):
            given += numbers.time_step * thrust[m, axis] * 0.5 * (mu_vels[0, m, axis] + mu_vels[1, m, axis])
    if closing:
        for axis in range(3):
            given += numbers.time_step * chaser_force[axis] * 0.5 * (bodies[0, 1, 3 + axis] + bodies[1, 1, 3 + axis])
    ledger[THRUST] += given
    ledger[WORK] += given
    _net(ledger, numbers, arrays, knots, v, w, mu_pos, mu_vels[0], mu_vels[1])
    count, center = numbers.knots, numbers.center_node
    if closing and center >= 0:
        _tether(
            ledger, numbers, knots[:, center], v[:, center], w[:, center], bodies[0, 1], bodies[1, 1], tether_length
        )
    if closing:
        _closing(ledger, numbers, arrays, knots, v, w, mu_pos, mu_vels[0], mu_vels[1], joints, locks, threads)
        _collisions(ledger, numbers, arrays, knots, v, w, mu_pos, mu_vels[0], mu_vels[1], bodies[0, 1], bodies[1, 1])
    debris, after = bodies[0, 0], bodies[1, 0]
    matrix, rates, no_thread = np.zeros((3, 3)), np.zeros((2, 3)), np.zeros(3)
    rotation_matrix(debris, matrix)
    debris_body.rate(body, debris, matrix, rates[0])
    debris_body.rate(body, after, matrix, rates[1])
    px, py, pz = debris[0], debris[1], debris[2]
    frame = debris_body.frame(body, matrix)
    for p in range(count + len(mu_pos)):
        if p < count:
            dx, dy, dz = knots[0, p] - px, knots[1, p] - py, knots[2, p] - pz
        else:
            dx, dy, dz = mu_pos[p - count, 0] - px, mu_pos[p - count, 1] - py, mu_pos[p - count, 2] - pz
        # Outside of a debris that is larger all round nothing touches.
        size = numbers.knot_radius if p < count else arrays.mu_radius[p - count]
        stiffness = numbers.contact_stiffness * (1.0 if p < count else numbers.mu_contact_share)
        if debris_body.within(body, frame, debris_body.inflated(body, size), dx, dy, dz):
            _contact(
                ledger, numbers, stiffness, arrays.contact_damping[p], size, _particle(knots, mu_pos, p),
                _particle(v, mu_vels[0], p), _particle(w, mu_vels[1], p), no_thread, body, debris, after, matrix, rates,
                bristle[p],
            )  # fmt: skip
        elif bristle[p, 0] != 0.0 or bristle[p, 1] != 0.0 or bristle[p, 2] != 0.0:
            ledger[FRICTION] += 0.5 * stiffness * np.dot(bristle[p], bristle[p])  # it has let go
    if len(arrays.segments):
        points = _touching_threads(numbers, arrays, body, knots, mu_pos, debris, matrix, closing, work)
        _threads(
            ledger, numbers, arrays, knots, v, w, mu_pos, mu_vels[0], mu_vels[1], body, debris, after, matrix, rates,
            bristle, points, work,
        )  # fmt: skip


@entry_point
def fly_booked(
    ledger, numbers, arrays, threads, body, steps, thrust, external, target_pos, target_vel, chaser_force,
    knot_pos, knot_vel, mu_pos, mu_vel, bodies, bristle, crossed, crossed_count, closing, pair_length, locked,
    winch_length, tether_length,
):  # fmt: skip
    """Fly one scenario like step.advance, step by step, and book each step. Returns the particles in contact at the
    last.
    """
    contacts = 0
    knot_vels, mu_vels = np.zeros((2, *knot_vel.shape)), np.zeros((2, *mu_vel.shape))
    both_bodies, joints = np.zeros((2, *bodies.shape)), np.zeros((2, *pair_length.shape))
    locks, winches = np.zeros((2, *locked.shape), np.bool_), np.zeros((2, *winch_length.shape))
    work = thread_points.workspace(len(arrays.segments), debris_body.parts(body))
    for _ in range(steps):
        knots, mus, held = knot_pos.copy(), mu_pos.copy(), bristle.copy()
        touched = crossed[: crossed_count[0]].copy()
        knot_vels[0], mu_vels[0], both_bodies[0] = knot_vel, mu_vel, bodies
        joints[0], locks[0], winches[0] = pair_length, locked, winch_length
        contacts = advance_scenario(
            numbers, arrays, threads, body, 1, thrust, external, target_pos, target_vel, chaser_force, knot_pos,
            knot_vel, mu_pos, mu_vel, bodies, bristle, crossed, crossed_count, closing, pair_length, locked,
            winch_length, tether_length,
        )  # fmt: skip
        if crossed_count[0] > len(crossed):
            break  # there is no room for what has to be booked
        knot_vels[1], mu_vels[1], both_bodies[1] = knot_vel, mu_vel, bodies
        joints[1], locks[1], winches[1] = pair_length, locked, winch_length
        book_step(
            ledger, numbers, arrays, body, thrust, chaser_force, closing, tether_length, knots, knot_vels, mus,
            mu_vels, both_bodies, held, joints, locks, winches, work,
        )  # fmt: skip
        crossing_energy.book(ledger, numbers, arrays, knots, knot_vels, touched, crossed[: crossed_count[0]])
    return contacts
