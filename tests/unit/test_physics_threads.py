"""Threads and main tether against what can be worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.physics import make_world

STEP = 1e-6  # [s] a half oscillation of a thread lasts 3.4e-4 s


def one_thread(damping_ratio: float, speed: float):
    """A world in which only the thread from the corner knot 0 to its neighbour 1 can become taut; knot 0 flies off
    along -x.
    """
    world = make_world(4, hardware={"net.thread.damping_ratio": damping_ratio}, time_step_s=STEP)
    state = world.state
    state.knot_pos[0] = np.array([0.0, 0.0, -1.5])[:, None]
    state.mu_pos[0] = (0.0, 0.0, -1.5)
    mesh = world.system.net.mesh_m
    state.knot_pos[0, 0, 0] = -mesh
    state.knot_pos[0, 0, 23] = -0.5 * mesh  # the corner's other neighbour stays near enough to be slack
    state.knot_vel[0, 0, 0] = -speed
    world.steps = 1
    return world


def taut_phase(world) -> tuple[float, float, float]:
    """Follow the thread until it is slack again: duration [s], largest stretch [m], relative speed at the end [m/s]."""
    zero = np.zeros((1, 4, 3))
    state, mesh = world.state, world.system.net.mesh_m
    largest = 0.0
    for step in range(1, 2000):
        world.advance(zero)
        stretch = state.knot_pos[0, 0, 1] - state.knot_pos[0, 0, 0] - mesh
        largest = max(largest, stretch)
        if stretch <= 0.0:
            return step * STEP, largest, float(state.knot_vel[0, 0, 0] - state.knot_vel[0, 0, 1])
    raise AssertionError("the thread never became slack again")


def test_oscillation_frequency_and_amplitude_of_a_thread():
    speed = 0.5
    world = one_thread(0.0, speed)
    mass = world.model.arrays.knot_mass
    reduced = mass[0] * mass[1] / (mass[0] + mass[1])
    omega = math.sqrt(world.system.net.thread_stiffness[0] / reduced)
    duration, largest, rebound = taut_phase(world)
    assert duration == pytest.approx(math.pi / omega, rel=0.01)  # two steps of 343
    assert largest == pytest.approx(speed / omega, rel=0.005)
    assert rebound == pytest.approx(speed, rel=0.005)


def test_damping_of_a_thread():
    """A damped half swing gives back exp(-pi zeta' / sqrt(1 - zeta'^2)) of the speed while tension lasts, cut where T
    would turn to
    push: T = k x + c v reaches 0 before the stretch does."""
    speed = 0.5
    world = one_thread(0.106, speed)
    mass = world.model.arrays.knot_mass
    reduced = mass[0] * mass[1] / (mass[0] + mass[1])
    k, c = world.system.net.thread_stiffness[0], world.system.net.thread_damping[0]
    omega, sigma = math.sqrt(k / reduced), c / (2.0 * reduced)
    damped = math.sqrt(omega**2 - sigma**2)
    times = np.linspace(0.0, math.pi / damped, 200001)
    stretch = speed / damped * np.exp(-sigma * times) * np.sin(damped * times)
    rate = np.gradient(stretch, times)
    end = np.argmax((k * stretch + c * rate <= 0.0) & (times > 0.0))
    _, largest, rebound = taut_phase(world)
    assert largest == pytest.approx(stretch.max(), rel=0.01)
    assert rebound == pytest.approx(-rate[end], rel=0.01)


def test_a_thread_never_pushes():
    world = make_world(8)
    state = world.state
    random = np.random.default_rng(3)
    # Folded and shaken: all threads are slack, many of them are being compressed further.
    state.knot_vel[0] = random.normal(0.0, 1.0, state.knot_vel[0].shape)
    state.mu_vel[0] = random.normal(0.0, 1.0, state.mu_vel[0].shape)
    before = state.copy()
    world.steps = 1
    for _ in range(20):
        world.advance(np.zeros((1, 8, 3)))
        assert np.array_equal(state.knot_vel, before.knot_vel)
        assert np.array_equal(state.mu_vel, before.mu_vel)


def test_a_damper_does_not_push_while_a_stretched_thread_shortens_fast():
    world = one_thread(0.106, 0.0)
    state, net = world.state, world.system.net
    stretch = 1e-5
    state.knot_pos[0, 0, 0] -= stretch
    # k x + c v < 0
    state.knot_vel[0, 0, 0] = 2.0 * net.thread_stiffness[0] * stretch / net.thread_damping[0]
    before = state.knot_vel[0, 0, :2].copy()
    world.advance(np.zeros((1, 4, 3)))
    assert np.array_equal(state.knot_vel[0, 0, :2], before)


@pytest.mark.parametrize("taut_threads", ["few", "all"])
def test_sparse_and_dense_evaluation_follow_the_same_law(taut_threads):
    """The kernel evaluates few taut threads one by one and many of them all together; either must equal the plain
    law.
    """
    world = make_world(8, debris=(0.0, 0.0, -80.0))
    state, numbers = world.state, world.model.numbers
    random = np.random.default_rng(5)
    size = 0.92 if taut_threads == "few" else 1.02
    state.knot_pos[0, :2] *= size / world.physics.fold_factor
    state.knot_pos[0] += random.normal(0.0, 0.05, state.knot_pos[0].shape)
    state.knot_vel[0] = random.normal(0.0, 0.5, state.knot_vel[0].shape)
    state.mu_pos[0] = state.knot_pos[0][:, world.model.arrays.mu_knot].T
    index = np.arange(529).reshape(23, 23)
    ends = np.concatenate(
        [
            np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], 1),
            np.stack([index[:-1].ravel(), index[1:].ravel()], 1),
        ]
    )
    position, velocity = state.knot_pos[0].T.copy(), state.knot_vel[0].T.copy()
    along = position[ends[:, 1]] - position[ends[:, 0]]
    length = np.linalg.norm(along, axis=1)
    rate = np.einsum("tx,tx->t", velocity[ends[:, 1]] - velocity[ends[:, 0]], along) / length
    stiffness, damping = world.system.net.thread_stiffness[0], world.system.net.thread_damping[0]
    tension = np.where(length > 1.0, np.maximum(stiffness * (length - 1.0) + damping * rate, 0.0), 0.0)
    assert (np.count_nonzero(tension) < 160) == (taut_threads == "few")
    force = np.zeros_like(position)
    np.add.at(force, ends[:, 0], (tension / length)[:, None] * along)
    np.add.at(force, ends[:, 1], -(tension / length)[:, None] * along)
    expected = velocity + numbers.time_step * force / world.model.arrays.knot_mass[:, None]
    world.steps = 1
    world.advance(np.zeros((1, 8, 3)))
    assert np.allclose(state.knot_vel[0].T, expected, rtol=1e-12, atol=1e-12)


def test_pull_of_the_locked_tether():
    world = make_world(8)
    state, numbers = world.state, world.model.numbers
    world.begin_closing(0)
    assert state.tether_length[0] == pytest.approx(world.physics.start_distance_m)
    stretch = 0.02
    state.knot_pos[0, 2, world.system.net.center_node] -= stretch
    world.steps = 1
    world.advance(np.zeros((1, 8, 3)))
    pull = numbers.tether_stiffness * stretch
    assert state.bodies[0, 1, 5] == pytest.approx(-numbers.time_step * pull / numbers.chaser_mass, rel=1e-12)
    center = world.system.net.center_node
    knot_mass = world.model.arrays.knot_mass[center]
    assert state.knot_vel[0, 2, center] == pytest.approx(numbers.time_step * pull / knot_mass, rel=1e-12)


def test_the_tether_pays_out_freely_before_closing():
    world = make_world(8)
    world.state.knot_pos[0, 2] -= 30.0
    world.state.mu_pos[0, :, 2] -= 30.0
    world.advance(np.zeros((1, 8, 3)))
    assert not world.state.knot_vel.any()
    length, tension = world.tether(0)
    assert length == pytest.approx(31.5)
    assert tension == 0.0


def test_the_net_is_the_one_of_the_design():
    world = make_world(8)
    net, arrays = world.system.net, world.model.arrays
    thread_kg = net.material.linear_density_kg_m * net.mesh_m
    assert len(arrays.knot_mass) == 529
    assert net.thread_stiffness[0] == pytest.approx(70e9 * math.pi * 0.25e-6, rel=1e-12)
    assert thread_kg == pytest.approx(1390.0 * math.pi * 0.25e-6, rel=1e-12)
    assert arrays.knot_mass.sum() == pytest.approx(1012 * thread_kg)
    assert np.allclose(arrays.mu_thread, [math.sqrt(2.0)] * 4 + [0.71] * 4)
    # Folded to 5 % and at rest, MUs on their knots, 1.5 m in front of the launch point.
    spread = world.state.knot_pos[0].max(axis=1) - world.state.knot_pos[0].min(axis=1)
    assert np.allclose(spread, [1.1, 1.1, 0.0])
    assert np.array_equal(world.state.mu_pos[0], world.state.knot_pos[0][:, arrays.mu_knot].T)
    assert (world.state.knot_pos[0, 2] == -1.5).all()
