"""Winches, their threads, and the joints of docked and locked pairs."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics import make_world

STILL = np.zeros((1, 4, 3))


def flat_world(hardware=None):
    """A flat net, closing, its threads just slack; the debris is far away."""
    world = make_world(4, debris=(0.0, 0.0, -80.0), hardware=hardware)
    state = world.state
    state.knot_pos[0, :2] *= 0.999 / world.physics.fold_factor
    state.mu_pos[0] = state.knot_pos[0][:, world.model.arrays.mu_knot].T
    world.begin_closing(0)
    world.steps = 1
    return world


def side_length(world, side: int = 0) -> float:
    """Length of the closing thread along a side [m]."""
    pairs = world.model.arrays.pairs[3 * side : 3 * side + 3]
    position = world.state.knot_pos[0].T
    return float(np.linalg.norm(position[pairs[:, 1]] - position[pairs[:, 0]], axis=1).sum())


def kicks(world) -> np.ndarray:
    """Force on every knot in one step, without the net's threads, which are slack [N], (529, 3)."""
    before = world.state.knot_vel[0].copy()
    world.advance(STILL)
    return ((world.state.knot_vel[0] - before) / world.model.arrays.kick).T


def test_a_winch_at_standstill_holds_its_thread():
    world = flat_world({"closing.winch.speed_m_s": 0.0})
    length = side_length(world)
    stretch = 0.004
    world.state.winch_length[0, 0] -= stretch  # as if the knots had gone apart
    force = kicks(world)
    assert world.state.winch_length[0, 0] == pytest.approx(length - stretch, rel=1e-12)
    assert force[0, 0] == pytest.approx(world.system.closing.winch_stiffness_n_m * stretch, rel=1e-6)


def test_a_winch_never_pulls_harder_than_it_can_and_then_slips():
    world = flat_world()
    physics, state, closing = world.physics, world.state, world.system.closing
    length = side_length(world)
    state.winch_length[0] = 0.3 * length
    force = kicks(world)
    assert force[0, 0] == pytest.approx(closing.winch_tension_n, rel=1e-9)
    assert state.winch_length[0, 0] == pytest.approx(length - closing.winch_tension_n / closing.winch_stiffness_n_m)
    # The thread is slack as soon as its nodes come nearer than that, and must be taken in first.
    state.knot_vel[0], state.knot_pos[0, 0] = 0.0, 0.99 * state.knot_pos[0, 0]
    before = state.winch_length[0, 0]
    assert not kicks(world)[[7, 15]].any()
    assert before - state.winch_length[0, 0] == pytest.approx(2.0 * closing.winch_speed_m_s * physics.time_step_s)


def test_the_thread_slides_through_its_nodes():
    """One tension all along: the nodes between feel it only where the thread bends."""
    world = flat_world({"closing.winch.speed_m_s": 0.0})
    state = world.state
    state.knot_pos[0, 1, 7] += 0.02  # node 7 lies beside the side's line
    state.winch_length[0, 0] = side_length(world) - 0.005
    force = kicks(world)
    first, middle, second, last = (state.knot_pos[0, :, knot] for knot in (0, 7, 15, 22))
    tension = world.system.closing.winch_stiffness_n_m * 0.005
    into, out = (middle - first) / np.linalg.norm(middle - first), (second - middle) / np.linalg.norm(second - middle)
    assert np.allclose(force[0], tension * into, atol=1e-2)
    assert np.allclose(force[7], tension * (out - into), atol=1e-2)
    assert np.allclose(force[22], tension * (second - last) / np.linalg.norm(second - last), atol=1e-2)
    assert np.allclose(force[[0, 7, 15, 22]].sum(axis=0), 0.0, atol=1e-9)


def test_a_pair_that_comes_near_locks_without_a_jerk():
    world = flat_world({"closing.winch.speed_m_s": 0.0})
    state = world.state
    state.winch_length[0, 0] = side_length(world) - 0.004
    state.knot_pos[0, :, 7] = state.knot_pos[0, :, 15] - np.array([0.49, 0.0, 0.0])
    before = side_length(world)
    state.winch_length[0, 0] = before - 0.004
    force = kicks(world)
    assert state.locked[0].tolist() == [False, True] + [False] * 10
    assert state.pair_length[0, 1] == pytest.approx(0.49)
    assert state.winch_length[0, 0] == pytest.approx(before - 0.49 - 0.004, abs=1e-9), "the thread's tension stays"
    assert force[0, 0] == pytest.approx(world.system.closing.winch_stiffness_n_m * 0.004, rel=1e-6)


def test_a_docked_pair_is_drawn_in_by_a_motor_that_can_stall():
    world = make_world(8, debris=(0.0, 0.0, -80.0))
    state, physics = world.state, world.physics
    world.begin_closing(0)
    world.steps = 1
    zero = np.zeros((1, 8, 3))
    state.mu_pos[0, 4] = state.mu_pos[0, 0] + (0.4, 0.0, 0.0)
    world.advance(zero)
    assert state.locked[0].sum() == 1
    assert state.locked[0, 0]
    # Held apart: it pulls with the motor's force at the most, however long.
    for _ in range(200):
        state.mu_pos[0, 4], state.mu_vel[0] = state.mu_pos[0, 0] + (0.4, 0.0, 0.0), 0.0
        world.advance(zero)
    least = 0.4 - world.system.closing.pull_n / physics.joint_stiffness_n_m
    assert state.pair_length[0, 0] == pytest.approx(least, abs=1e-9)
    # Torn: the motor stands still and the joint holds, without limit.
    state.mu_pos[0, 4], state.mu_vel[0] = state.mu_pos[0, 0] + (0.45, 0.0, 0.0), 0.0
    world.advance(zero)
    assert state.pair_length[0, 0] == pytest.approx(least, abs=1e-9)
    pull = physics.joint_stiffness_n_m * (0.45 - least)
    assert state.mu_vel[0, 0, 0] == pytest.approx(physics.time_step_s * pull / world.system.units[0].mass_kg, rel=1e-9)
    # Free: it comes together.
    for _ in range(40000):
        world.advance(zero)
    assert state.pair_length[0, 0] == 0.0
    assert np.linalg.norm(state.mu_pos[0, 4] - state.mu_pos[0, 0]) < 0.05


def test_a_joint_pulls_along_its_line_only():
    world = make_world(8, debris=(0.0, 0.0, -80.0))
    state = world.state
    world.begin_closing(0)
    world.steps = 1
    state.mu_pos[0, 4] = state.mu_pos[0, 0] + (0.4, 0.0, 0.0)
    state.mu_vel[0, 4] = 0.2, 0.3, -0.1
    world.advance(np.zeros((1, 8, 3)))
    assert state.mu_vel[0, 0, 0] > 0.0, "its damper works"
    assert state.mu_vel[0, 4, 1:].tolist() == [0.3, -0.1], "and not across"
