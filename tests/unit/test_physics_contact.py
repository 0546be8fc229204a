"""Contact with the debris' cylinder: shape, normal force, scaled-box friction."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.physics import coast, make_world
from tethernet_sim.kernels import contact

N = make_world(8).model.numbers


def push(position, velocity, bristle=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 0.0)):
    """Force on one knot near a debris at the origin with identity attitude; None when it does not touch."""
    knot_pos, knot_vel = np.array(position, float).reshape(3, 1), np.array(velocity, float).reshape(3, 1)
    bristles, forces = np.array([bristle], float), np.zeros((1, 3))
    debris = np.zeros(13)
    debris[9] = 1.0
    touching = contact.contact_forces(
        knot_pos, knot_vel, np.zeros((0, 3)), np.zeros((0, 3)), np.array([0]), 1, bristles, debris, np.eye(3),
        np.array(rate, float), N, forces, np.zeros(1, np.int64),
    )  # fmt: skip
    return (forces[0], bristles[0]) if touching else None


def test_distance_from_the_cylinder():
    radius, half = N.debris_radius, N.debris_half_length
    cases = [
        ((radius + 0.3, 0.0, 1.0), 0.3, (1.0, 0.0, 0.0)),  # side
        ((0.0, -(radius - 0.1), -2.0), -0.1, (0.0, -1.0, 0.0)),  # inside, nearest to the side
        ((0.5, 0.0, half + 0.2), 0.2, (0.0, 0.0, 1.0)),  # flat end
        ((0.5, 0.5, -(half - 0.05)), -0.05, (0.0, 0.0, -1.0)),  # inside, nearest to an end
        ((radius + 0.3, 0.0, half + 0.4), 0.5, (0.6, 0.0, 0.8)),  # rim
    ]
    for point, distance, normal in cases:
        got = contact.surface(*point, radius, half)
        assert got[0] == pytest.approx(distance, abs=1e-12)
        assert np.allclose(got[1:], normal, atol=1e-12)


def test_normal_force_is_compliant_and_damped():
    depth = 0.005
    at = N.debris_radius + N.knot_radius - depth
    resting, _ = push((at, 0.0, 1.0), (0.0, 0.0, 0.0))
    assert np.allclose(resting, (N.contact_stiffness * depth, 0.0, 0.0))
    coming, _ = push((at, 0.0, 1.0), (-0.5, 0.0, 0.0))
    assert coming[0] == pytest.approx(N.contact_stiffness * depth + N.knot_contact_damping * 0.5)
    leaving, _ = push((at, 0.0, 1.0), (1000.0, 0.0, 0.0))
    assert leaving[0] == 0.0, "a contact never pulls"
    assert push((N.debris_radius + N.knot_radius + 1e-9, 0.0, 1.0), (0.0, 0.0, 0.0)) is None


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
    at = N.debris_radius + N.knot_radius - depth
    force, bristle = push((at, 0.0, 1.0), sliding, bristle=np.multiply(sliding, 1.0))
    limit = N.friction * N.contact_stiffness * depth
    assert np.allclose(force[1:], np.multiply(expected, limit), rtol=1e-12)
    assert np.abs(bristle).max() <= limit / N.contact_stiffness * (1 + 1e-12), (
        "the spring keeps no more than friction holds"
    )


def test_below_the_limit_a_contact_sticks():
    depth = 0.005
    at = N.debris_radius + N.knot_radius - depth
    small = 1e-5
    force, bristle = push((at, 0.0, 1.0), (0.0, 0.0, 0.0), bristle=(0.0, 0.0, small))
    assert force[2] == pytest.approx(-N.contact_stiffness * small)
    assert np.allclose(bristle, (0.0, 0.0, small))


def test_friction_acts_against_the_surface_that_turns():
    depth = 0.005
    at = N.debris_radius + N.knot_radius - depth
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
        inside = np.minimum(N.debris_radius - radial, N.debris_half_length - np.abs(along))
        deepest = max(deepest, float(inside.max()))
        touched = max(touched, int(state.contacts[0]))
    assert touched > 20
    assert deepest < 0.02


def test_the_vectorised_side_contact_equals_the_general_one():
    random = np.random.default_rng(5)
    count = 60
    debris = np.zeros(13)
    debris[:6] = random.normal(size=6)
    attitude = Rotation.random(random_state=1)
    debris[6:10] = attitude.as_quat()
    matrix, rate = attitude.as_matrix(), np.array([0.05, -0.08, 0.02])
    angle, along = random.uniform(0, 2 * np.pi, count), random.uniform(-4, 4, count)
    radius = N.debris_radius + N.knot_radius - random.uniform(-0.003, 0.006, count)  # a third does not touch
    body = np.stack([radius * np.cos(angle), radius * np.sin(angle), along])
    knot_pos = np.ascontiguousarray(matrix @ body + debris[:3, None])
    knot_vel = random.normal(size=(3, count)) + debris[3:6, None]
    bristles = random.normal(scale=1e-3, size=(count, 3))
    kick = np.full(count, 0.1)

    general = bristles.copy()
    forces, touched = np.zeros((count, 3)), np.zeros(count, np.int64)
    touching = contact.contact_forces(
        knot_pos, knot_vel, np.zeros((0, 3)), np.zeros((0, 3)), np.arange(count), count, general, debris, matrix, rate,
        N, forces, touched,
    )  # fmt: skip
    kicked, force, torque = knot_vel.copy(), np.zeros(3), np.zeros(3)
    contact.react(
        touched, forces, touching, kick, knot_pos, kicked, np.zeros((0, 3)), np.zeros((0, 3)), debris, force, torque
    )

    room = contact.ROOM
    side, work, fast = np.arange(count, dtype=np.uint32), np.zeros(12 * room), np.zeros((count, 3))
    held, which = np.zeros((3, room)), np.zeros(room, np.uint32)
    contact.fetch_bristles(bristles, side, count, held)
    fast_kicked, fast_force, fast_torque = knot_vel.copy(), np.zeros(3), np.zeros(3)
    assert 20 < touching < 50
    assert touching == contact.find_touching(knot_pos, debris, matrix, N, side, count, held, np.zeros(room), which)
    assert set(side[which[:touching]]) == set(touched[:touching])
    filled = contact.gather(knot_pos, knot_vel, debris, side, held, which, touching, work)
    contact.side_forces(work, filled, debris, matrix, rate, N, fast_force, fast_torque)
    contact.kick_side(side, held, which, touching, work, kick, fast_kicked)
    contact.store_bristles(fast, side, count, held)
    assert np.allclose(fast_kicked, kicked, atol=1e-12)
    assert np.allclose(fast, general, atol=1e-15)
    assert np.allclose(fast_force, force, atol=1e-10)
    assert np.allclose(fast_torque, torque, atol=1e-9)


def test_the_search_lists_all_that_may_touch_and_tells_side_from_ends():
    random = np.random.default_rng(2)
    knot_pos = np.ascontiguousarray(random.uniform(-7, 7, (3, 529)))
    mu_pos = np.array([[0.0, 0.0, N.debris_half_length + 0.1], [50.0, 0.0, 0.0]])
    debris = np.zeros(13)
    debris[9] = 1.0
    room = contact.ROOM
    side, others, flags = np.zeros(room + 1, np.uint32), np.zeros(room, np.uint32), np.zeros(room, np.uint8)
    squared, margin = np.zeros(room), 5.0 * contact.NEAR_STEPS * N.time_step
    sides, rest, steps = contact.find_candidates(
        knot_pos, mu_pos, debris, np.eye(3), N, 5.0, side, others, squared, squared.view(np.uint64),
        np.zeros(room), flags, flags.view(np.uint64), np.zeros(room, np.uint32),
    )  # fmt: skip
    assert steps == contact.NEAR_STEPS
    distance = np.array([contact.surface(*p, N.debris_radius, N.debris_half_length)[0] for p in knot_pos.T])
    listed = set(side[:sides].tolist()) | set(others[:rest].tolist())
    assert set(np.flatnonzero(distance < N.knot_radius + margin).tolist()) <= listed
    assert 529 in listed
    assert 530 not in listed
    assert all(distance[i] < N.knot_radius + 1.5 * margin for i in listed if i < 529), "no more than necessary"
    for i in side[:sides]:
        assert abs(knot_pos[2, i]) < N.debris_half_length - N.knot_radius - margin


def test_a_far_net_is_searched_seldom():
    debris = np.zeros(13)
    debris[9] = 1.0
    room = contact.ROOM
    flags, squared = np.zeros(room, np.uint8), np.zeros(room)
    found = contact.find_candidates(
        np.full((3, 529), 20.0), np.full((8, 3), 20.0), debris, np.eye(3), N, 5.0, np.zeros(room + 1, np.uint32),
        np.zeros(room, np.uint32), squared, squared.view(np.uint64), np.zeros(room), flags, flags.view(np.uint64),
        np.zeros(room, np.uint32),
    )  # fmt: skip
    assert found == (0, 0, contact.FAR_STEPS)
