"""The search for offsets: alone, on top of a trained policy, for the assumed numbers in which a policy saves least."""

import dataclasses
import json

import numpy as np
import pytest

pytest.importorskip("cma")

from tests.command import tethernet
from tests.systems import zenit
from tethernet_learning import assumed_numbers
from tethernet_learning.flight_settings import Flight
from tethernet_learning.flown import Flown, from_outcomes
from tethernet_learning.policies import capture_sources, offset_search
from tethernet_learning.policies.episode_settings import learned_task
from tethernet_learning.policies.reward import Reward
from tethernet_planner.inference import model_file
from tethernet_planner.inference.policy_file import AimingPolicy, constant_policy, moved_policy
from tethernet_sim.fly import Settings, fly_many

pytestmark = pytest.mark.learning

ZENIT_4 = zenit(4)
REWARD = Reward(ZENIT_4, 0.05, 570.0, "lean")
TASK = learned_task(ZENIT_4, "system")


class TwoKinds:
    """Of every two groups of scenarios one saves 1 g for each metre that unit 1 aims farther in x, up to 1 m, one loses
    0.2 g: all offsets in x but 0 lose in one of both.
    """

    def fly(self, scenarios):
        x = np.array([s.aiming_offsets[0][0] for s in scenarios])
        fuel = np.full(len(scenarios), 0.02)
        for group, (numbers, _) in enumerate(assumed_numbers.groups(scenarios)):
            fuel[numbers] += 0.001 * (0.2 * np.abs(x[numbers] + 3.0) if group % 2 else np.abs(x[numbers] - 1.0))
        ones = np.ones(len(scenarios))
        return Flown(4, 0.5 * ones, 9 * ones, fuel, 500.0 * ones, ZENIT_4)


def settings(**others):
    return offset_search.SearchSettings(ZENIT_4, **{"seed": 1, "candidates": 8, "sigma_m": 0.5, **others})


def search(folder, made, source, first=None):
    folder.mkdir()
    return offset_search.search(folder, made, source, REWARD, lambda done, more: None, {}, first)


@pytest.mark.parametrize(("worst", "best"), [(1.0, 1.0), (0.5, 0.0)])
def test_a_candidate_is_judged_where_it_gains_least(tmp_path, worst, best):
    made = settings(episodes=60 * 128, scenarios=16, worst=worst)
    policy = search(tmp_path / "run", made, TwoKinds())
    assert policy.offsets((3.0, 0.0, -50.0))[0, 0] == pytest.approx(best, abs=0.11)


def test_what_is_found_comes_on_top_of_a_trained_policy(tmp_path):
    plain = learned_task(ZENIT_4, "none")
    first = constant_policy(ZENIT_4, plain, np.full((4, 2), 0.7))
    policy = search(tmp_path / "run", settings(episodes=60 * 128, scenarios=16), TwoKinds(), first)
    assert policy.offsets((3.0, 0.0, -50.0))[0, 0] == pytest.approx(1.0, abs=0.11)
    mean_m = np.array(json.loads((tmp_path / "run" / offset_search.FILE).read_text())[-1]["mean_m"])
    assert mean_m[0] == pytest.approx(0.3, abs=0.11)


def test_a_moved_policy_gives_the_same_offsets_more():
    random = np.random.default_rng(0)
    shapes = {"weight_0": (6, 3), "bias_0": (6,), "weight_1": (8, 6), "bias_1": (8,)}
    arrays = {name: 0.1 * random.normal(size=shape).astype(np.float32) for name, shape in shapes.items()}
    first = AimingPolicy(constant_policy(ZENIT_4, TASK, np.zeros((4, 2))).made_for, TASK, arrays)
    offsets = 0.1 * random.integers(-9, 9, (4, 2))
    moved = moved_policy(first, offsets, {"method": "cma-es"})
    assert moved.about == {"method": "cma-es"}
    for position in random.uniform(TASK.debris_low_m, TASK.debris_high_m, (20, 3)).tolist():
        _, image = TASK.scale_observation(position)
        np.testing.assert_allclose(
            moved.offsets(position) - first.offsets(position), image.offsets(offsets), atol=0.051
        )


@pytest.mark.parametrize(("mus", "numbers"), [(4, 2), (8, 4)])
def test_symmetric_offsets_are_those_that_every_image_leaves(mus, numbers):
    task = learned_task(zenit(mus), "system")
    searched = offset_search.searched_directions(task, symmetric=True)
    assert searched.shape == (numbers, 2 * mus)
    np.testing.assert_allclose(searched @ searched.T, np.eye(numbers), atol=1e-12)
    for one in searched:
        for image in task.images:
            np.testing.assert_allclose(image.offsets(one.reshape(-1, 2)).ravel(), one, atol=1e-12)
    assert np.array_equal(offset_search.searched_directions(task, symmetric=False), np.eye(2 * mus))


@pytest.mark.parametrize("mus", [4, 8])
def test_ends_are_each_number_alone_at_either_end(mus):
    system = zenit(mus)
    base = Flight(system, Settings.load(system))
    flights = assumed_numbers.at_ends(base)
    assert flights[0] == (base, {})
    numbers = assumed_numbers.OF_SYSTEM + assumed_numbers.OF_PHYSICS
    changed = [next(iter(entry.items())) for _, entry in flights[1:]]
    assert len(changed) == 2 * len(numbers) - (1 if mus == 4 else 2), "a winch is at most as stiff as described"
    for (name, value), (flight, _) in zip(changed, flights[1:], strict=True):
        number = next(number for number in numbers if number.name == name)
        if number in assumed_numbers.OF_SYSTEM:
            described = assumed_numbers.described_entry(system.content, name)
            assert assumed_numbers.described_entry(flight.system.content, name) == value
        else:
            described = getattr(base.settings.physics, name)
            assert flight.system.digest == system.digest
            assert getattr(flight.settings.physics, name) == value
        assert value in (number.value(0.0, described), number.value(1.0, described))


def test_each_group_is_flown_with_its_own_end(monkeypatch):
    """And judged as the system that is described."""
    monkeypatch.setattr(assumed_numbers, "GROUP", 1)
    base = Flight(ZENIT_4, Settings.load(ZENIT_4))
    flights = assumed_numbers.at_ends(base)[:3]
    monkeypatch.setattr(assumed_numbers, "at_ends", lambda _: flights)
    scenarios = offset_search.random_scenarios(ZENIT_4, offset_search.Purpose.OFFSET_OPTIMISATION, 0, 0, 4)
    full = capture_sources.make(capture_sources.FULL, base.settings)
    flown = capture_sources.AssumedAtEnds(full, base).fly(scenarios)
    for number, scenario in enumerate(scenarios):
        flight, _ = flights[number % 3]
        outcomes = fly_many([dataclasses.replace(scenario, system=flight.system)], flight.settings)
        assert flown.fuel_kg[number] == from_outcomes(outcomes, ZENIT_4).fuel_kg[0]


def test_wrong_words_are_refused_with_what_is_allowed(tmp_path, capsys):
    words = ["train", "offsets", "--mus", "4", "--source", "full", "--output", str(tmp_path / "run")]
    for wrong, told in (
        (["--worst", "0"], "allowed: above 0, up to 1"),
        (["--assumed", "ends"], "16 scenarios; allowed with assumed = ends: multiples of 80, 8 with each of 10"),
        (["--begin-with", str(tmp_path / "none")], "cannot be read"),
    ):
        assert tethernet(*words, *wrong) == 2
        assert told in capsys.readouterr().err
    constant_policy(ZENIT_4, TASK, np.zeros((4, 2))).save(tmp_path / "p.safetensors")
    assert tethernet(*words, "--begin-with", str(tmp_path / "p.safetensors")) == 2
    assert "was trained for other bounds or images; --symmetry says which" in capsys.readouterr().err
    words[1] = "policy"
    assert tethernet(*words, "--assumed", "ends") == 2
    assert "32 envs; allowed with assumed = ends: multiples of 80" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
    with pytest.raises(model_file.ModelFileError):
        AimingPolicy.load(tmp_path / "run")
