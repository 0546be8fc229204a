"""Both engines fly the same flights, for nets of all sizes, and keep what free flight keeps."""

from __future__ import annotations

import numpy as np
import pytest

from tests.engines import ENGINES, MESH_M, STEP_S, flat_state, fly, grid_model, make_model, shaken
from tests.physics import flying_net
from tethernet_sim import audit
from tethernet_sim.engine import Commands, EdgeListEngine, GridEngine, engine_for, is_uniform_grid
from tethernet_sim.fly import fly as fly_mission
from tethernet_sim.scenario import Scenario

SIZES = [(2, 2), (2, 3), (3, 7), (7, 3), (8, 8), (23, 23), (5, 40), (91, 91), (100, 100)]
"""Most of them no multiple of 8; the last one the largest allowed."""


@pytest.mark.parametrize("size", SIZES)
def test_both_engines_agree_to_rounding(size):
    model = grid_model(*size, units=2)
    steps = 100 if size[0] * size[1] < 2000 else 20
    grid, edges = (fly(engine(model), shaken(model), steps * STEP_S) for engine in ENGINES.values())
    scale = np.abs(grid.knot_vel).max()
    assert np.abs(grid.knot_vel - shaken(model).knot_vel).max() > 0.01 * scale, "threads must have pulled"
    assert np.allclose(grid.knot_vel, edges.knot_vel, rtol=0.0, atol=1e-8 * scale)
    assert np.allclose(grid.knot_pos, edges.knot_pos, rtol=0.0, atol=1e-10)
    assert np.allclose(grid.mu_pos, edges.mu_pos, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("size", [(8, 8), (23, 23), (45, 45)])
@pytest.mark.parametrize("shuffled", [1.0, 0.3])
def test_how_the_nodes_are_numbered_changes_nothing(size, shuffled):
    """Without order no threads run side by side, with some of it a part of them does."""
    model = grid_model(*size)
    nodes = size[0] * size[1]
    random = np.random.default_rng(5)
    number = np.arange(nodes)
    moved = np.flatnonzero(random.random(nodes) < shuffled)
    number[moved] = random.permutation(moved)
    other = make_model(nodes, number[model.arrays.threads])
    state = shaken(model)
    renumbered = flat_state(other, np.zeros((3, nodes)))
    renumbered.knot_pos[:, :, number], renumbered.knot_vel[:, :, number] = state.knot_pos, state.knot_vel
    for _ in range(4):
        fly(GridEngine(model), state, 50 * STEP_S)
        fly(EdgeListEngine(other), renumbered, 50 * STEP_S)
    assert np.allclose(renumbered.knot_vel[:, :, number], state.knot_vel, rtol=0.0, atol=1e-6)
    assert np.allclose(renumbered.knot_pos[:, :, number], state.knot_pos, rtol=0.0, atol=1e-8)


def test_both_engines_fly_the_same_deployment_for_the_first_second():
    final = []
    for engine in ENGINES.values():
        model = grid_model(23, 23, units=4)
        corners = np.array([0, 22, 506, 528])
        model = model._replace(arrays=model.arrays._replace(mu_knot=corners))
        state = flat_state(model)
        state.knot_pos[:, :2] *= 0.1
        state.mu_pos[0] = state.knot_pos[0, :, corners]
        thrust = np.zeros((1, 4, 3))
        thrust[0, :, :2] = 3.0 * np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
        flown = engine(model)
        for _ in range(20):
            flown.advance(state, Commands.of_thrust(thrust), 0.05)
        final.append(state)
    grid, edges = final
    assert np.linalg.norm(grid.mu_pos[0, 0] - grid.mu_pos[0, 3]) > 4.0
    assert np.allclose(grid.knot_pos, edges.knot_pos, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("size", [(2, 2), (3, 7), (23, 23)])
@pytest.mark.parametrize("units", [0, 1, 24])
def test_free_flight_keeps_momentum_and_gains_no_energy(name, size, units):
    model = grid_model(*size, units=units)
    state = shaken(model)
    linear, angular = audit.linear_momentum(model, state), audit.angular_momentum(model, state)
    energy = audit.kinetic_energy(model, state) + audit.elastic_energy(model, state)
    fly(ENGINES[name](model), state, 200 * STEP_S)
    assert np.allclose(audit.linear_momentum(model, state), linear, rtol=0.0, atol=1e-12)
    assert np.allclose(audit.angular_momentum(model, state), angular, rtol=0.0, atol=1e-11 * np.abs(angular).max())
    after = audit.kinetic_energy(model, state) + audit.elastic_energy(model, state)
    assert after[0] < energy[0] * (1.0 + 1e-3)


@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_a_thread_between_two_nodes_swings_as_the_equation_says(damping):
    """Pulled apart and let go, it swings back like a damped oscillator until it is slack."""
    stiffness, time_step, stretch, mass = 400.0, 1e-5, 0.01, 0.005
    model = make_model(2, [[0, 1]], stiffness=stiffness, damping=damping, time_step=time_step)
    positions = np.array([[0.0, MESH_M + stretch], [0.0, 0.0], [0.0, 0.0]])
    state = flat_state(model, positions)
    reduced = mass / 2.0
    decay = damping / (2.0 * reduced)
    angular_rate = np.sqrt(stiffness / reduced - decay**2)
    until = 0.2 / np.sqrt(stiffness / reduced)
    steps = round(until / time_step)
    fly(EdgeListEngine(model), state, steps * time_step)
    t = steps * time_step
    exact = stretch * np.exp(-decay * t) * (
        np.cos(angular_rate * t) + decay / angular_rate * np.sin(angular_rate * t)
    )  # fmt: skip
    found = state.knot_pos[0, 0, 1] - state.knot_pos[0, 0, 0] - MESH_M
    assert found == pytest.approx(exact, abs=stretch * 2.0 * time_step / until)
    assert exact < 0.99 * stretch


def test_a_slack_thread_does_not_pull_before_it_is_taut():
    model = make_model(2, [[0, 1]], damping=0.0)
    state = flat_state(model, np.array([[0.0, 0.9], [0.0, 0.0], [0.0, 0.0]]))
    state.knot_vel[0, 0] = -1.0, 1.0
    engine = EdgeListEngine(model)
    fly(engine, state, 0.0499)
    assert np.array_equal(state.knot_vel[0, 0], [-1.0, 1.0])
    fly(engine, state, 0.005)
    assert state.knot_vel[0, 0, 1] < 0.0, "it has been pulled back"


def test_an_irregular_net_of_unlike_threads_is_flown():
    """A star with three unlike arms: each thread obeys its own rest length and stiffness."""
    rest, stiffness = np.array([0.5, 1.0, 2.0]), np.array([100.0, 1000.0, 10000.0])
    model = make_model(4, [[0, 1], [2, 0], [0, 3]], rest=rest, stiffness=stiffness, damping=0.0)
    length = rest + np.array([0.02, 0.01, -0.1])
    angle = np.array([0.0, 2.0, 4.0])
    arms = np.stack([length * np.cos(angle), length * np.sin(angle), np.zeros(3)])
    state = flat_state(model, np.concatenate([np.zeros((3, 1)), arms], axis=1))
    fly(EdgeListEngine(model), state, STEP_S)
    tension = stiffness * np.maximum(length - rest, 0.0)
    expected = -model.arrays.kick[1:] * tension * arms / length
    assert np.allclose(state.knot_vel[0, :, 1:], expected, rtol=1e-12)
    assert np.allclose(state.knot_vel[0, :, 0], -expected.sum(axis=1), rtol=1e-9)


def test_pairs_join_nodes_and_units_and_winches_have_segments_of_their_own_number():
    """One winch with three segments, one with one, and a docking pair of a node and a unit."""
    model = grid_model(
        4, 4, units=2, pairs=[[1, 17], [0, 3], [3, 15], [15, 12], [1, 2]], pair_winch=[-1, 0, 0, 0, 1], center=5
    )
    for engine in ENGINES.values():
        state = shaken(model)
        state.mu_pos[0, 1] = state.knot_pos[0, :, 1] + (0.0, 0.0, 0.2)  # within its thread
        linear, angular = audit.linear_momentum(model, state), audit.angular_momentum(model, state)
        flown = engine(model)
        flown.begin_closing(state, 0)
        assert np.allclose(state.winch_length[0], [9.0009, 1.0001], atol=1e-3)
        fly(flown, state, 0.01)
        assert state.locked[0].tolist() == [True, False, False, False, False]
        assert (state.winch_length[0] < [9.0, 1.0]).all(), "both have been drawn in"
        assert np.allclose(audit.linear_momentum(model, state), linear, rtol=0.0, atol=1e-11)
        assert np.allclose(audit.angular_momentum(model, state), angular, rtol=0.0, atol=1e-10 * np.abs(angular).max())


def test_a_batch_flies_like_each_of_its_scenarios():
    model = grid_model(3, 7, units=1)
    for engine in ENGINES.values():
        together = fly(engine(model), shaken(model, batch=3), 0.01)
        for b in range(3):
            alone = shaken(model, batch=3)
            engine(model).advance(alone, Commands.of_thrust(np.zeros((3, 1, 3))), 0.01, np.array([b]))
            assert np.array_equal(alone.knot_pos[b], together.knot_pos[b])


def test_more_particles_touch_than_fit_into_one_block():
    """A fine net on the debris: the contact's forces still cancel."""
    model = grid_model(40, 40, units=1)
    state = flat_state(model, debris=(0.0, 0.0, 0.0))
    state.knot_pos[:, :2] *= 0.45 / 20.0
    state.knot_pos[:, 2] = 0.54
    state.knot_vel[:, 2] = -0.1
    state.mu_pos[:] = (0.0, 0.0, 3.0)
    linear, angular = audit.linear_momentum(model, state), audit.angular_momentum(model, state)
    fly(EdgeListEngine(model), state, 0.002)
    assert state.contacts[0] > 600
    assert np.allclose(audit.linear_momentum(model, state), linear, rtol=0.0, atol=1e-12)
    assert np.allclose(audit.angular_momentum(model, state), angular, rtol=0.0, atol=1e-12)


def test_what_is_no_uniform_grid_goes_to_the_edge_list():
    uniform = grid_model(3, 4)
    assert isinstance(engine_for(uniform), GridEngine)
    rest = uniform.arrays.rest.copy()
    rest[3] = 0.9
    for other in (
        uniform._replace(grid=None),
        uniform._replace(arrays=uniform.arrays._replace(rest=rest)),
        uniform._replace(grid=(4, 3)),
        make_model(2, [[0, 1]], grid=(1, 2)),
    ):
        assert not is_uniform_grid(other)
        assert isinstance(engine_for(other), EdgeListEngine)
        with pytest.raises(ValueError, match="use EdgeListEngine"):
            GridEngine(other)


def test_a_period_that_is_no_whole_number_of_steps_is_refused():
    model = grid_model(2, 2)
    for period in (1.5 * STEP_S, 0.0):
        with pytest.raises(ValueError, match=r"whole number of time steps of 0\.0001 s"):
            fly(engine_for(model), flat_state(model), period)


@pytest.mark.parametrize("closing", [False, True])
def test_the_edge_list_flies_the_shipped_systems_like_the_grid(closing):
    for mus in (4, 8):
        final = []
        for engine in ENGINES.values():
            world = flying_net(mus, closing)
            world.engine = engine(world.model)
            for _ in range(2):
                world.advance(np.zeros_like(world.state.mu_pos))
            final.append(world.state)
        assert np.allclose(final[0].knot_pos, final[1].knot_pos, rtol=0.0, atol=1e-6)
        assert np.allclose(final[0].bodies, final[1].bodies, rtol=0.0, atol=1e-6)


def test_a_mission_on_the_edge_list_comes_to_the_same_verdict(monkeypatch):
    monkeypatch.setattr("tethernet_sim.world.engine_for", EdgeListEngine)
    outcome = fly_mission(Scenario("zenit_8mu"))
    assert outcome.captured
    assert outcome.locked_pairs >= 6
    assert 38.0 < outcome.end_time_s < 41.0
