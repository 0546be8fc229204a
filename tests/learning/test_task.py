"""What is learned: seeds, bounds, scaling, symmetries, the net's features."""

import numpy as np
import pytest

from tests.systems import zenit
from tethernet_core.system import load_system, shipped_systems
from tethernet_learning.data import make_data, spread
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose, sequence
from tethernet_learning.symmetries import group, seen_group
from tethernet_planner.inference import net_features, symmetry
from tethernet_planner.inference.task import Task, TaskError, aimed_task_of, task_of


def test_no_scenario_of_a_test_is_ever_trained_on():
    def flown(purpose, count):
        return {(s.debris_position, s.seed) for s in random_scenarios(zenit(8), purpose, 0, 0, count)}

    trained = flown(Purpose.POLICY_TRAINING, 2000) | flown(Purpose.SURROGATE_TRAINING, 2000)
    trained |= flown(Purpose.OFFSET_OPTIMISATION, 2000)
    for purpose in (Purpose.POLICY_EVALUATION, Purpose.SURROGATE_TEST):
        assert not trained & flown(purpose, 200)


def test_streams_are_apart_whatever_the_seed_and_number():
    keys = {sequence(purpose, 3, number).spawn_key for purpose in Purpose for number in range(50)}
    assert len(keys) == 50 * len(Purpose)
    assert all(len(key) == 2 for key in keys)  # the evaluation command's keys have one number


def test_a_longer_list_goes_on_where_the_shorter_one_ends():
    whole = random_scenarios(zenit(4), Purpose.POLICY_TRAINING, 7, 0, 6)
    assert random_scenarios(zenit(4), Purpose.POLICY_TRAINING, 7, 2, 4) == whole[2:]
    whole = make_data.scenarios(zenit(4), "train", 7, 0, 6)
    assert make_data.scenarios(zenit(4), "train", 7, 2, 4) == whole[2:]


def test_positions_and_offsets_lie_on_the_papers_grid_and_within_its_bounds():
    for scenario in make_data.scenarios(zenit(8), "train", 0, 0, 100):
        assert task_of(zenit(8)).inside(scenario.debris_position)
        values = np.array([*scenario.debris_position, *np.ravel(scenario.aiming_offsets)])
        assert np.allclose(values, np.round(values, 1), atol=1e-9)
        assert np.abs(scenario.aiming_offsets).max() <= 5.0
    assert not task_of(zenit(8)).inside((9.2, 0.0, -50.0))
    assert not task_of(zenit(8)).inside((0.0, 0.0, -39.0))


@pytest.mark.parametrize("symmetric", [False, True])
def test_an_action_scales_to_metres_and_back_to_where_the_debris_is(symmetric):
    task = task_of(zenit(4))
    if symmetric:
        task = task.with_images(group(zenit(4)))
    observation, image = task.scale_observation((-9.0, 0.0, -60.0))
    assert observation[2] == -1.0
    assert observation[0] == (1.0 if symmetric else -1.0)
    action = np.zeros(8)
    action[:2] = 1.0, -0.5  # of unit 1 in the image
    offsets = task.offsets_from_action(action, image)
    moved = np.flatnonzero(np.abs(offsets).sum(axis=1))
    assert len(moved) == 1
    assert sorted(np.abs(offsets[moved[0]])) == [2.5, 5.0]
    assert np.allclose(task.offsets_from_action(np.full(8, 7.0)), 5.0)  # clipped


@pytest.mark.parametrize("position", [(3.0, 1.0, -50.0), (-3.0, 1.0, -50.0), (1.0, 8.0, -41.0), (-1.0, -8.0, -60.0)])
def test_the_image_of_a_position_lies_in_one_quarter_and_leads_back(position):
    image, used = symmetry.canonical(position, group(zenit(8)))
    assert image[0] >= abs(image[1])
    assert used.inverse.vectors(image).tolist() == list(position)


def test_the_papers_systems_have_the_four_images_of_a_net_and_a_cylinder_on_its_diagonal():
    for units in (4, 8):
        matrices = [image.matrix for image in group(zenit(units))]
        assert matrices == [((s, 0.0), (0.0, s)) for s in (1.0, -1.0)] + [((0.0, s), (s, 0.0)) for s in (1.0, -1.0)]


def test_images_are_those_that_net_units_closing_and_debris_share():
    counts = {name: len(group(load_system(name))) for name in shipped_systems() if not name.startswith("zenit")}
    assert counts["hexagonal_6mu"] == 2, "the cylinder lies on none of the net's axes of reflection"
    assert counts["envisat_8mu"] == 1, "the debris looks like itself from nowhere else"
    assert counts["passive_5m"] == 12, "six turns and six reflections: the ball has all"
    ball = {"debris.shape": {"kind": "sphere", "radius_m": 2.0}}
    assert len(group(load_system("zenit_8mu", ball))) == 8
    for changed in (
        {"units[0].mass_kg": 2.6},
        {"debris.shape": {"kind": "cone", "base_radius_m": 2.0, "top_radius_m": 0.5, "length_m": 9.0}},
    ):
        assert len(group(load_system("zenit_8mu", changed))) == 2, changed
    spinning = {"parameters.scenario": {"debris_rate": [0.0, 0.0, 0.02]}}
    assert len(group(load_system("zenit_8mu", spinning))) == 2, "a reflection across its axis turns the spin round"


@pytest.mark.parametrize("name", [name for name in shipped_systems() if load_system(name).unit_count])
def test_images_make_a_group_and_map_offsets_with_the_units(name):
    system = load_system(name)
    images = group(system)
    products = {
        tuple(np.round(np.array(a.matrix) @ np.array(b.matrix), 6).ravel() + 0.0) for a in images for b in images
    }
    assert products == {tuple(np.round(np.array(a.matrix), 6).ravel() + 0.0) for a in images}
    nominal = system.aiming.offsets
    offsets = np.random.default_rng(1).normal(size=nominal.shape)
    for image in images:
        moved = {tuple(np.round(p, 6) + 0.0) for p in image.vectors(nominal + offsets)}
        assert moved == {tuple(np.round(p, 6) + 0.0) for p in nominal + image.offsets(offsets)}
        assert np.allclose(image.inverse.offsets(image.offsets(offsets)), offsets)


def test_bounds_and_grid_follow_the_system():
    assert (task_of(zenit(8)).offset_limit_m, task_of(zenit(8)).step_m) == (5.0, 0.1)
    small = task_of(load_system("passive_5m"))
    assert small.debris_low_m == (-1.0, -1.0, -15.0)
    assert small.step_m == 0.01
    with pytest.raises(TaskError, match="passive_5m has no units"):
        aimed_task_of(load_system("passive_5m"))
    hexagonal = task_of(load_system("hexagonal_6mu")).with_images(group(load_system("hexagonal_6mu")))
    assert Task.from_json(6, hexagonal.as_json()) == hexagonal


@pytest.mark.parametrize(("mus", "count"), [(4, 990), (8, 1014)])
def test_features_are_those_of_the_paper_relative_to_the_debris(mus, count):
    random, system = np.random.default_rng(0), zenit(mus)
    knots, rates, mu, mu_rates = (random.normal(size=(n, 3)).astype(np.float32) for n in (529, 529, mus, mus))
    row = net_features.features(system, knots, rates, mu, mu_rates, (1.0, 2.0, 3.0), (0.0, 0.0, 0.5))
    assert row.shape == (count,) == (net_features.feature_count(system),)
    nodes = row.reshape(-1, 6)
    assert np.allclose(nodes[0, :3], knots[0] - [1, 2, 3])
    assert np.allclose(nodes[22, :3], knots[22] - [1, 2, 3])  # the corner after the first side
    assert np.allclose(nodes[88, :3], knots[4 * 23 + 4] - [1, 2, 3])  # the second loop's corner
    assert np.allclose(nodes[160, 3:], rates[system.net.center_node] - [0, 0, 0.5])
    assert np.allclose(nodes[161:, :3], mu - [1, 2, 3], atol=1e-6)
    assert [len(loop) for loop in net_features.seen(system).loops] == [88, 56, 16]
    assert len(np.unique(net_features.seen(system).nodes)) == 161


@pytest.mark.parametrize("name", shipped_systems())
def test_every_nets_loops_go_round_once_and_begin_at_the_border(name):
    system = load_system(name)
    look = net_features.seen(system)
    flat = system.net.nodes[:, :2] - system.net.nodes[system.net.center_node, :2]
    for loop in look.loops:
        turn = np.unwrap(np.arctan2(*flat[list(loop)].T[::-1]))
        assert (np.diff(turn) > 0.0).all()
        assert turn[-1] - turn[0] < 2.0 * np.pi
    assert set(np.argsort(np.hypot(*flat.T))[-3:].tolist()) <= set(look.loops[0]), "the farthest ones"
    assert len(set(look.nodes.tolist())) == len(look.nodes)
    sectors = net_features.sector_nodes(system)
    assert set(sectors.ravel().tolist()) - {look.count} == set(range(look.count))


@pytest.mark.parametrize("name", ["zenit_4mu", "zenit_8mu", "hexagonal_6mu", "passive_5m"])
def test_features_of_the_flat_net_are_mapped_onto_themselves(name):
    system = load_system(name)
    places = net_features.places(system)
    flat = np.zeros((1, len(places), 6), np.float32)
    flat[0, :, :2] = places
    assert seen_group(system) == group(system)
    for mirrored in group(system):
        image = net_features.image_of_features(mirrored, flat.reshape(1, -1), system)
        assert np.allclose(image, flat.reshape(1, -1), atol=1e-5)


@pytest.mark.parametrize("name", ["zenit_4mu", "zenit_8mu", "hexagonal_6mu"])
def test_data_sets_hold_narrow_mouths_mouths_beside_the_debris_and_torn_ones(name):
    random, system = np.random.default_rng(1), load_system(name)
    task, shares = task_of(system), spread.spread_of(system).shares
    drawn = np.array([spread.random_offsets(random, system) for _ in range(600)])
    assert np.array_equal(drawn, task.on_grid(drawn))
    assert np.abs(drawn).max() == task.offset_limit_m
    nominal, scale = system.aiming.offsets, task.offset_limit_m / 5.0
    inwards = -(drawn * nominal).sum(axis=(1, 2)) / (nominal**2).sum()
    own = drawn + inwards[:, None, None] * nominal
    common = np.linalg.norm(own.mean(axis=1), axis=1)
    torn = np.abs(drawn).max(axis=(1, 2)) > 3.5 * scale
    narrow = (inwards > 0.05) & (np.abs(own).max(axis=(1, 2)) < 2.5 * scale)
    assert 0.4 * shares["narrow"] < narrow.mean() < shares["narrow"] + 0.1
    assert torn.mean() > 0.8 * shares["torn"]
    assert (common > 2.0 * scale).mean() > 0.2 * shares["beside"]
    assert sum(shares.values()) == pytest.approx(1.0)
