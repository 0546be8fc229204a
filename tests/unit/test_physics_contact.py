"""Contact with the debris' cylinder: shape, normal force, scaled-box friction."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.physics import coast, make_world
from tethernet_core.shapes import Cylinder
from tethernet_sim.kernels import contact, debris_body
from tethernet_sim.kernels.rows import row_width

N, BODY = make_world(8, contact="knots").model.numbers, make_world(8).model.debris
CYLINDER = Cylinder(BODY.radius, 2.0 * BODY.half_length)
INTERIOR = 24
"""A knot in the middle of the net."""
DAMPING = make_world(4, contact="knots").model.arrays.contact_damping


@numba.njit
def surface(body, x, y, z):
    return debris_body.surface(body, x, y, z)


def push(position, velocity, bristle=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 0.0)):
    """Force on one knot near a debris at the origin with identity attitude; None when it does not touch."""
    work = np.zeros((contact.ROWS, contact.BLOCK))
    work[:9, 0] = *position, *velocity, *bristle
    work[12:16, 0] = N.knot_radius, DAMPING[INTERIOR], 1.0, 1.0
    debris = np.zeros(13)
    debris[9] = 1.0
    touching = contact.contact_forces(
        work.ravel(), 1, BODY, debris, np.eye(3), np.array(rate, float), N, False, np.zeros(3), np.zeros(3)
    )
    return (work[9:12, 0], work[6:9, 0]) if touching else None


def test_distance_from_the_cylinder():
    radius, half = BODY.radius, BODY.half_length
    cases = [
        ((radius + 0.3, 0.0, 1.0), 0.3, (1.0, 0.0, 0.0)),  # side
        ((0.0, -(radius - 0.1), -2.0), -0.1, (0.0, -1.0, 0.0)),  # inside, nearest to the side
        ((0.5, 0.0, half + 0.2), 0.2, (0.0, 0.0, 1.0)),  # flat end
        ((0.5, 0.5, -(half - 0.05)), -0.05, (0.0, 0.0, -1.0)),  # inside, nearest to an end
        ((radius + 0.3, 0.0, half + 0.4), 0.5, (0.6, 0.0, 0.8)),  # rim
    ]
    for point, distance, normal in cases:
        got = surface(BODY, *point)
        assert got[0] == pytest.approx(distance, abs=1e-12)
        assert np.allclose(got[1:], normal, atol=1e-12)


def test_normal_force_is_compliant_and_damped():
    depth = 0.005
    at = BODY.radius + N.knot_radius - depth
    resting, _ = push((at, 0.0, 1.0), (0.0, 0.0, 0.0))
    assert np.allclose(resting, (N.contact_stiffness * depth, 0.0, 0.0))
    coming, _ = push((at, 0.0, 1.0), (-0.5, 0.0, 0.0))
    assert coming[0] == pytest.approx(N.contact_stiffness * depth + DAMPING[INTERIOR] * 0.5)
    leaving, _ = push((at, 0.0, 1.0), (1000.0, 0.0, 0.0))
    assert leaving[0] == 0.0, "a contact never pulls"
    assert push((BODY.radius + N.knot_radius + 1e-9, 0.0, 1.0), (0.0, 0.0, 0.0)) is None


@pytest.mark.parametrize(
    ("sliding", "expected"),
    [
        ((0.0, 0.0, 5.0), (0.0, -1.0)),  # along the axis
        ((0.0, 5.0, 0.0), (-1.0, 0.0)),  # round the cylinder
        ((0.0, 5.0, 5.0), (-1.0, -1.0)),  # both: each direction has its own limit, that is the box
        ((0.0, -5.0, 0.5), (1.0, -1.0)),  # limits do not depend on the direction of the velocity either
    ],
)
def test_scaled_box_limits_each_direction_separately(sliding, expected):
    depth = 0.005
    at = BODY.radius + N.knot_radius - depth
    force, bristle = push((at, 0.0, 1.0), sliding, bristle=np.multiply(sliding, 1.0))
    limit = N.friction * N.contact_stiffness * depth
    assert np.allclose(force[1:], np.multiply(expected, limit), rtol=1e-12)
    assert np.abs(bristle).max() <= limit / N.contact_stiffness * (1 + 1e-12), (
        "the spring keeps no more than friction holds"
    )


def test_below_the_limit_a_contact_sticks():
    depth = 0.005
    at = BODY.radius + N.knot_radius - depth
    small = 1e-5
    force, bristle = push((at, 0.0, 1.0), (0.0, 0.0, 0.0), bristle=(0.0, 0.0, small))
    assert force[2] == pytest.approx(-N.contact_stiffness * small)
    assert np.allclose(bristle, (0.0, 0.0, small))


def test_friction_acts_against_the_surface_that_turns():
    depth = 0.005
    at = BODY.radius + N.knot_radius - depth
    force, _ = push((at, 0.0, 1.0), (0.0, 0.0, 0.0), rate=(0.0, 0.0, 2.0))  # the surface moves along +y
    assert force[1] > 0.0
    assert force[2] == pytest.approx(0.0, abs=1e-12)


def test_no_particle_gets_into_the_debris():
    # The whole flat net and its MUs fly into the debris at 4 m/s.
    world = make_world(8)
    state = world.state
    state.knot_pos[0, :2] /= world.physics.fold_factor * 1.02
    state.knot_pos[0, 2] = -47.0
    state.mu_pos[0] = state.knot_pos[0][:, world.model.arrays.mu_knot].T
    state.knot_vel[0, 2] = -4.0
    state.mu_vel[0, :, 2] = -4.0
    deepest, touched = 0.0, 0
    for _ in coast(world, 60):
        debris = state.bodies[0, 0]
        axis = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)  # nearly: the debris hardly turns in 3 s
        points = np.concatenate([state.knot_pos[0].T, state.mu_pos[0]]) - debris[:3]
        along = points @ axis
        radial = np.linalg.norm(points - along[:, None] * axis, axis=1)
        inside = np.minimum(BODY.radius - radial, BODY.half_length - np.abs(along))
        deepest = max(deepest, float(inside.max()))
        touched = max(touched, int(state.contacts[0]))
    assert touched > 20
    assert deepest < 0.02


@pytest.mark.parametrize("knot", [0, 11, INTERIOR])
def test_a_knot_bounces_as_its_own_mass_does(knot):
    """Corner, rim and middle: each is damped by the same share of its own critical damping."""
    world = make_world(4, debris=(0.0, 0.0, -50.0), attitude=(0.0, 0.0, 0.0, 1.0), time_step_s=2e-6, contact="knots")
    state, physics = world.state, world.physics
    others = np.arange(world.model.numbers.knots) != knot
    state.knot_pos[0][:, others] = np.array([0.0, 0.3, -44.0])[:, None]  # slack threads, nobody else near
    state.mu_pos[0] = (0.0, 0.3, -44.0)
    state.knot_pos[0, :, knot] = 0.0, 0.0, -50.0 + BODY.half_length + N.knot_radius + 1e-5
    state.knot_vel[0, 2, knot] = -0.5
    world.steps = 1
    while state.knot_pos[0, 2, knot] < -50.0 + BODY.half_length + N.knot_radius + 2e-5:
        world.advance(np.zeros((1, 4, 3)))
    zeta = physics.contact_damping_ratio
    damped = np.sqrt(1.0 - zeta**2)
    # A spring and damper that only push: the force ends where k x = c v, before the way does.
    restitution = np.exp(-zeta / damped * np.arctan2(2.0 * zeta * damped, 2.0 * zeta**2 - 1.0))
    assert state.knot_vel[0, 2, knot] == pytest.approx(0.5 * restitution, rel=0.01)


def law_of_one(position, velocity, bristle, size, damping, debris, matrix, rate):
    """Contact law of one particle: force on it [N], new bristle [m], whether it touches."""
    offset = position - debris[:3]
    local = matrix.T @ offset
    speed = matrix.T @ (velocity - debris[3:6] - np.cross(rate, offset))
    distance, normal = CYLINDER.distance(local)
    if distance >= size:
        return np.zeros(3), np.zeros(3), False
    pressing = max(N.contact_stiffness * (size - distance) - damping * (speed @ normal), 0.0)
    first = np.eye(3)[2 if abs(normal[2]) < 0.8 else 0]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    force, held = pressing * normal, np.zeros(3)
    for direction in (first, np.cross(normal, first)):
        stuck = bristle @ direction + N.time_step * (speed @ direction)
        limit = N.friction * pressing
        force = force + direction * np.clip(-N.contact_stiffness * stuck - damping * (speed @ direction), -limit, limit)
        held = held + direction * np.clip(stuck, -limit / N.contact_stiffness, limit / N.contact_stiffness)
    return matrix @ force, held, True


def test_all_contacts_at_once_equal_the_law_of_each_particle():
    random = np.random.default_rng(5)
    count, mus, room = 90, 4, contact.BLOCK
    debris = np.zeros(13)
    debris[:6] = random.normal(size=6)
    attitude = Rotation.random(random_state=1)
    debris[6:10] = attitude.as_quat()
    matrix, rate = attitude.as_matrix(), np.array([0.05, -0.08, 0.02])
    # Round the side, on the ends, across the edges; a third does not touch.
    angle, along = random.uniform(0, 2 * np.pi, count + mus), random.uniform(-5.7, 5.7, count + mus)
    radius = BODY.radius + N.knot_radius - random.uniform(-0.003, 0.006, count + mus)
    ends = np.arange(count + mus) % 3 == 0
    radius[ends] *= random.uniform(0.1, 1.0, ends.sum())
    along[ends] = np.sign(along[ends]) * (BODY.half_length + random.uniform(0.0, 0.03, ends.sum()))
    body = np.stack([radius * np.cos(angle), radius * np.sin(angle), along])
    position = (matrix @ body).T + debris[:3]
    velocity = random.normal(size=(count + mus, 3)) + debris[3:6]
    bristles = random.normal(scale=1e-3, size=(count + mus, 3))

    knot_pos, knot_vel = np.zeros((3, room)), np.zeros((3, room))
    knot_pos[:, :count], knot_vel[:, :count] = position[:count].T, velocity[:count].T
    near = np.concatenate([np.arange(count), 529 + np.arange(mus)]).astype(np.uint32)
    mu_radius = N.mu_radius * np.array([1.0, 0.9, 0.7, 1.0])  # each reaches as far as it is large
    held, touching, work = np.zeros((3, room)), np.zeros(room, np.uint32), np.zeros(contact.ROWS * room)
    held[:, : count + mus] = bristles.T
    knots, found = contact.find_touching(
        knot_pos, position[count:], BODY, debris, matrix, N, near, count, count + mus, held, np.zeros(room), touching
    )
    contact.gather(
        knot_pos, knot_vel, position[count:], velocity[count:], debris, DAMPING, mu_radius, N, near, held, touching,
        knots, found, work,
    )  # fmt: skip
    force, torque, mu_force = np.zeros(3), np.zeros(3), np.zeros((mus, 3))
    filled = contact.fill_up(work, found)
    touched = contact.contact_forces(work, filled, BODY, debris, matrix, rate, N, False, force, torque)
    contact.react(near, held, touching, knots, found, work, np.full(count, 0.1), 529, knot_vel, mu_force)

    size = np.concatenate([np.full(count, N.knot_radius), mu_radius])
    damping = np.concatenate([DAMPING[:count], DAMPING[529:]])
    rows = zip(position, velocity, bristles, size, damping, strict=True)
    law = [law_of_one(*row, debris, matrix, rate) for row in rows]
    forces, kept, touches = (np.array(part) for part in zip(*law, strict=True))
    assert touched == touches.sum()
    assert 40 < touched < 80
    assert np.allclose(knot_vel[:, :count].T, velocity[:count] + 0.1 * forces[:count], atol=1e-10)
    assert np.allclose(mu_force, forces[count:], atol=1e-9)
    assert np.allclose(held[:, : count + mus].T, kept, atol=1e-14)
    assert np.allclose(force, -forces.sum(axis=0), atol=1e-8)
    assert np.allclose(torque, -np.cross(position - debris[:3], forces).sum(axis=0), atol=1e-7)


def test_the_search_lists_all_that_may_touch():
    random = np.random.default_rng(2)
    knot_pos = np.ascontiguousarray(random.uniform(-7, 7, (3, 529)))
    mu_pos = np.array([[0.0, 0.0, BODY.half_length + 0.1], [50.0, 0.0, 0.0]])
    debris = np.zeros(13)
    debris[9] = 1.0
    room = row_width(529, 2)
    near, flags = np.zeros(room, np.uint32), np.zeros(room, np.uint8)
    squared, margin = np.zeros(room), 5.0 * contact.NEAR_STEPS * N.time_step
    knots, count, steps = contact.find_candidates(
        knot_pos, mu_pos, BODY, debris, np.eye(3), N, 5.0, near, squared, squared.view(np.uint64), flags,
        flags.view(np.uint64), np.zeros(room, np.uint32),
    )  # fmt: skip
    assert steps == contact.NEAR_STEPS
    distance = CYLINDER.distance(knot_pos.T)[0]
    listed = set(near[:count].tolist())
    assert knots == sum(i < 529 for i in listed)
    assert set(np.flatnonzero(distance < N.knot_radius + margin).tolist()) <= listed
    assert 529 in listed
    assert 530 not in listed
    assert all(distance[i] < N.knot_radius + 1.5 * margin for i in listed if i < 529), "no more than necessary"


def test_a_far_net_is_searched_seldom():
    debris = np.zeros(13)
    debris[9] = 1.0
    room = row_width(529, 2)
    flags, squared = np.zeros(room, np.uint8), np.zeros(room)
    found = contact.find_candidates(
        np.full((3, 529), 20.0), np.full((8, 3), 20.0), BODY, debris, np.eye(3), N, 5.0, np.zeros(room, np.uint32),
        squared, squared.view(np.uint64), flags, flags.view(np.uint64), np.zeros(room, np.uint32),
    )  # fmt: skip
    assert found == (0, 0, contact.FAR_STEPS)
