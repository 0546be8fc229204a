"""What is learned: seeds, bounds, scaling, symmetries, the net's features."""

import numpy as np
import pytest

from tethernet_core.layout import design
from tethernet_learning.data import make_data, spread
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose, sequence
from tethernet_planner.inference import net_features, symmetry, task


def test_no_scenario_of_a_test_is_ever_trained_on():
    def flown(purpose, count):
        return {(s.debris_position, s.seed) for s in random_scenarios(8, purpose, 0, 0, count)}

    trained = flown(Purpose.POLICY_TRAINING, 2000) | flown(Purpose.SURROGATE_TRAINING, 2000)
    trained |= flown(Purpose.OFFSET_OPTIMISATION, 2000)
    for purpose in (Purpose.POLICY_EVALUATION, Purpose.SURROGATE_TEST):
        assert not trained & flown(purpose, 200)


def test_streams_are_apart_whatever_the_seed_and_number():
    keys = {sequence(purpose, 3, number).spawn_key for purpose in Purpose for number in range(50)}
    assert len(keys) == 50 * len(Purpose)
    assert all(len(key) == 2 for key in keys)  # the evaluation command's keys have one number


def test_a_longer_list_goes_on_where_the_shorter_one_ends():
    whole = random_scenarios(4, Purpose.POLICY_TRAINING, 7, 0, 6)
    assert random_scenarios(4, Purpose.POLICY_TRAINING, 7, 2, 4) == whole[2:]
    whole = make_data.scenarios(4, "train", 7, 0, 6)
    assert make_data.scenarios(4, "train", 7, 2, 4) == whole[2:]


def test_positions_and_offsets_lie_on_the_papers_grid_and_within_its_bounds():
    for scenario in make_data.scenarios(8, "train", 0, 0, 100):
        assert task.inside(scenario.debris_position)
        values = np.array([*scenario.debris_position, *np.ravel(scenario.aiming_offsets)])
        assert np.allclose(values, np.round(values, 1), atol=1e-9)
        assert np.abs(scenario.aiming_offsets).max() <= 5.0
    assert not task.inside((9.2, 0.0, -50.0))
    assert not task.inside((0.0, 0.0, -39.0))


@pytest.mark.parametrize("symmetric", task.SYMMETRIES)
def test_an_action_scales_to_metres_and_back_to_where_the_debris_is(symmetric):
    observation, image = task.scale_observation((-9.0, 0.0, -60.0), symmetric)
    assert observation[2] == -1.0
    assert abs(observation[0]) == 1.0 or symmetric == "diagonal"
    action = np.zeros(8)
    action[:2] = 1.0, -0.5  # of MU 1 in the image
    offsets = task.offsets_from_action(action, image)
    moved = np.flatnonzero(np.abs(offsets).sum(axis=1))
    assert len(moved) == 1
    assert sorted(np.abs(offsets[moved[0]])) == [2.5, 5.0]
    assert np.allclose(task.offsets_from_action(np.full(8, 7.0)), 5.0)  # clipped


@pytest.mark.parametrize("position", [(3.0, 1.0, -50.0), (-3.0, 1.0, -50.0), (1.0, 8.0, -41.0), (-1.0, -8.0, -60.0)])
def test_the_image_of_a_position_lies_in_one_quarter_and_leads_back(position):
    image, used = symmetry.canonical(position)
    assert image[0] >= abs(image[1])
    assert used.vectors(image).tolist() == list(position)


@pytest.mark.parametrize("mus", [4, 8])
@pytest.mark.parametrize("mirrored", symmetry.GROUP)
def test_aiming_points_of_the_image_are_images_of_the_aiming_points(mus, mirrored):
    offsets = np.random.default_rng(1).normal(size=(mus, 2))
    nominal = np.array(design(mus).nominal_offsets)
    images = {tuple(np.round(p, 9)) for p in mirrored.vectors(nominal + offsets)}
    assert images == {tuple(np.round(p, 9)) for p in nominal + symmetry.image_of_offsets(mirrored, offsets)}


@pytest.mark.parametrize(("mus", "count"), [(4, 990), (8, 1014)])
def test_features_are_those_of_the_paper_relative_to_the_debris(mus, count):
    random = np.random.default_rng(0)
    knots, rates, mu, mu_rates = (random.normal(size=(n, 3)).astype(np.float32) for n in (529, 529, mus, mus))
    row = net_features.features(knots, rates, mu, mu_rates, (1.0, 2.0, 3.0), (0.0, 0.0, 0.5))
    assert row.shape == (count,) == (net_features.feature_count(mus),)
    nodes = row.reshape(-1, 6)
    assert np.allclose(nodes[0, :3], knots[0] - [1, 2, 3])
    assert np.allclose(nodes[160, 3:], rates[529 // 2] - [0, 0, 0.5])
    assert np.allclose(nodes[161:, :3], mu - [1, 2, 3], atol=1e-6)
    assert len(np.unique(net_features.knot_places(), axis=0)) == 161


@pytest.mark.parametrize("mus", [4, 8])
def test_features_of_the_flat_net_are_mapped_onto_themselves(mus):
    places = np.vstack([net_features.knot_places()[:, ::-1] - 11.0, design(mus).nominal_offsets])
    flat = np.zeros((1, len(places), 6), np.float32)
    flat[0, :, :2] = places
    for mirrored in symmetry.GROUP:
        image = net_features.image_of_features(mirrored, flat.reshape(1, -1), mus)
        assert np.allclose(image, flat.reshape(1, -1))


@pytest.mark.parametrize("mus", [4, 8])
def test_data_sets_hold_narrow_mouths_mouths_beside_the_debris_and_torn_ones(mus):
    random = np.random.default_rng(1)
    drawn = np.array([spread.random_offsets(random, mus) for _ in range(600)])
    assert np.array_equal(drawn, task.on_grid(drawn))
    assert np.abs(drawn).max() == task.OFFSET_LIMIT_M
    nominal = np.array(design(mus).nominal_offsets)
    inwards = -(drawn * nominal).sum(axis=(1, 2)) / (nominal**2).sum()
    own = drawn + inwards[:, None, None] * nominal
    common = np.linalg.norm(own.mean(axis=1), axis=1)
    torn = np.abs(drawn).max(axis=(1, 2)) > 3.5
    narrow = (inwards > 0.05) & (np.abs(own).max(axis=(1, 2)) < 2.5)
    assert 0.4 * spread.SHARES[mus]["narrow"] < narrow.mean() < spread.SHARES[mus]["narrow"] + 0.1
    assert torn.mean() > 0.8 * spread.SHARES[mus]["torn"]
    assert (common > 2.0).mean() > 0.2 * spread.SHARES[mus]["beside"]
    assert sum(spread.SHARES[mus].values()) == pytest.approx(1.0)
