"""Trained policies and surrogates by name and by path, shipped or not."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests import tiny_models
from tethernet_bringup.mission import arguments
from tethernet_bringup.mission import command_line as cli
from tethernet_bringup.mission import parameters as mission_parameters
from tethernet_core.layout import KNOT_ROWS, nominal_aiming_points
from tethernet_learning import measured
from tethernet_learning.campaigns.cases import Case, aim
from tethernet_learning.flight_digest import flight_digest
from tethernet_planner import policies
from tethernet_planner import predictors as prediction
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.model_file import file_fingerprint
from tethernet_planner.inference.net_sample import NetSample
from tethernet_planner.inference.prediction import Prediction
from tethernet_sim.scenario import Scenario

DEBRIS = (1.0, -2.0, -50.0)


@pytest.fixture(autouse=True)
def shipped(monkeypatch, tmp_path):
    """Nothing is shipped but what the test puts there."""
    folder = tmp_path / "models"
    folder.mkdir()
    monkeypatch.setattr(shipped_models, "FOLDER", folder)
    policies._model.cache_clear()
    yield folder
    policies._model.cache_clear()


@pytest.mark.parametrize("mus", [4, 8])
@pytest.mark.parametrize("word", ["rl", "path"])
def test_a_trained_policy_moves_the_aiming_points(tmp_path, mus, word):
    file = tiny_models.policy(shipped_models.place("policy", mus), mus)
    name = word if word == "rl" else str(file)
    plan = policies.plan(name, mus, DEBRIS)
    assert (plan.policy, plan.message) == (name, "")
    for (x, y, z), nominal in zip(plan.points, nominal_aiming_points(mus, DEBRIS), strict=True):
        assert (x - nominal[0], y - nominal[1], z) == pytest.approx((0.5, -0.3, nominal[2]))
    assert len(policies.fingerprint(name, mus)) == 16
    assert policies.fingerprint("nominal", mus) is None


def test_without_a_shipped_model_rl_says_so_and_what_to_do(shipped):
    tiny_models.policy(shipped_models.place("policy", 4), 4)
    policies.check("rl", 4)
    with pytest.raises(policies.PolicyError) as refused:
        policies.check("rl", 8)
    words = str(refused.value)
    for needed in (
        "no policy for 8 MUs is shipped",
        "PATH/policy.safetensors",
        "tethernet models install",
        "nominal needs none",
    ):
        assert needed in words
    with pytest.raises(prediction.PredictorError, match=r"no surrogate for 8 MUs is shipped.*none needs none"):
        prediction.make("surrogate", 8)


def test_a_wrong_file_is_named_with_what_is_allowed(tmp_path):
    (tmp_path / "noise.safetensors").write_bytes(b"\x00" * 100)
    tiny_models.surrogate(tmp_path / "surrogate.safetensors", 8)
    tiny_models.policy(tmp_path / "four.safetensors", 4)
    for name, words in (
        ("missing.safetensors", "there is no file"),
        ("noise.safetensors", "cannot be read as a model"),
        ("surrogate.safetensors", "is a surrogate, format version 2; allowed: a policy"),
        ("four.safetensors", "made for 4 MUs, not for 8"),
    ):
        with pytest.raises(policies.PolicyError, match=words):
            policies.check(str(tmp_path / name), 8)
    for name, words in (("missing.safetensors", "there is no file"), ("four.safetensors", "allowed: a surrogate")):
        with pytest.raises(prediction.PredictorError, match=words):
            prediction.make(str(tmp_path / name), 8)


def test_outside_the_trained_bounds_the_nominal_points_stand_in_and_it_is_said(shipped):
    tiny_models.policy(shipped_models.place("policy", 8), 8)
    far = (9.5, 0.0, -50.0)
    plan = policies.plan("rl", 8, far)
    assert plan.points == nominal_aiming_points(8, far)
    assert plan.policy == "nominal (fallback)"
    assert "policy rl was not trained for it (debris at (9.5, 0, -50) m; trained: x and y from -9 to 9" in plan.message
    near, away = aim([Case(Scenario("zenit_8mu", debris_position=place), "") for place in (DEBRIS, far)], "rl")
    assert (near.policy, away.policy) == ("rl", "nominal (fallback)")
    assert near.scenario.aiming_offsets[0] == pytest.approx((0.5, -0.3))
    assert away.scenario.aiming_offsets is None


def test_in_process_and_by_service_the_mus_are_sent_to_the_same_bits(shipped):
    tiny_models.policy(shipped_models.place("policy", 8), 8, 0.1, -4.7)
    for seed in range(20):
        place = tuple(np.round(np.random.default_rng(seed).uniform((-9, -9, -60), (9, 9, -40)), 1).tolist())
        [case] = aim([Case(Scenario("zenit_8mu", debris_position=place), "")], "rl")
        assert case.scenario.aiming_points().tolist() == [list(p) for p in policies.aiming_points("rl", 8, place)]


def test_a_surrogate_predicts_from_positions_and_velocities_relative_to_the_debris(tmp_path):
    knots = np.zeros((KNOT_ROWS**2, 3), np.float32)
    velocities = knots + np.float32(2.0)
    mus = np.zeros((8, 3), np.float32)

    def told(seen):
        file = tiny_models.surrogate(tmp_path / "surrogate.safetensors", 8, pairs=3.0, seen=seen)
        sample = NetSample(0, (0, 0, 0), (0.0, 0.0, -1.5), 0, mus, knots, velocities, mus, (0.0, 0.0, 0.5))
        return prediction.make(str(file), 8).predict(sample)

    assert told(None) == Prediction(pytest.approx(1.5), pytest.approx(3.0), pytest.approx(0.5))
    assert told(2).locked_pairs == pytest.approx(3.0 + 1.5)
    assert told(5).locked_pairs == pytest.approx(3.0 + 1.5)
    assert told(4).locked_pairs == pytest.approx(3.0 + 2.0)


def test_a_net_with_another_mesh_is_refused(tmp_path):
    made = prediction.make(str(tiny_models.surrogate(tmp_path / "surrogate.safetensors", 8)), 8)
    few = np.zeros((9, 3), np.float32)
    with pytest.raises(ValueError, match="9 knots; surrogates are made for 23 x 23"):
        made.predict(NetSample(0, (0, 0, 0), (0, 0, 0), 0, few[:8], few, few, few[:8]))


def test_a_mission_carries_absolute_paths_and_hashes(tmp_path, monkeypatch):
    tiny_models.policy(tmp_path / "policy.safetensors", 4)
    tiny_models.surrogate(tmp_path / "surrogate.safetensors", 4)
    (tmp_path / "p.yaml").write_text("assessor: {ros__parameters: {predictor: ./surrogate.safetensors}}\n")
    monkeypatch.chdir(tmp_path)
    words = ["--mus", "4", "--policy", "policy.safetensors", "--params", "p.yaml"]
    setup = mission_parameters.resolve(arguments.parse(words))
    assert setup.policy == str(tmp_path / "policy.safetensors")
    assert setup.nodes["planner"]["policy"] == setup.policy
    assert setup.nodes["assessor"]["predictor"] == str(tmp_path / "surrogate.safetensors")
    assert sorted(setup.models) == ["policy", "predictor"]


def test_a_mission_says_whose_card_does_not_hold(shipped, tmp_path):
    for kind, make in (("policy", tiny_models.policy), ("surrogate", tiny_models.surrogate)):
        make(shipped_models.place(kind, 8), 8)
        card = {"model": file_fingerprint(shipped_models.place(kind, 8)), "flight_digest": "of yesterday"}
        measured.place(kind, 8).write_text(json.dumps(card))
    both = cli.stale_cards(mission_parameters.resolve(arguments.parse(["--mus", "8"])))
    assert [notice.partition(" is stale")[0] for notice in both if notice] == [
        "the card of the policy for 8 MUs",
        "the card of the surrogate for 8 MUs",
    ]
    [one] = cli.stale_cards(mission_parameters.resolve(arguments.parse(["--mus", "8", "--policy", "nominal"])))
    assert one.startswith("the card of the surrogate for 8 MUs is stale")
    card["flight_digest"] = flight_digest()
    measured.place("surrogate", 8).write_text(json.dumps(card))
    assert cli.stale_cards(mission_parameters.resolve(arguments.parse(["--mus", "8", "--policy", "nominal"]))) == [""]


@pytest.mark.parametrize("mus", [4, 8])
def test_a_mission_with_a_policy_that_cannot_be_had_is_refused_before_anything_starts(tmp_path, mus):
    file = tiny_models.policy(tmp_path / "policy.safetensors", 12 - mus)
    for word, words in (("rl", "no policy for"), (str(file), f"made for {12 - mus} MUs, not for {mus}")):
        with pytest.raises(mission_parameters.MissionParametersError, match=f"--policy {word[:40]}.*: .*{words}"):
            mission_parameters.resolve(arguments.parse(["--mus", str(mus), "--policy", word]))


def test_flying_a_trained_policy_needs_no_torch(tmp_path):
    file = tiny_models.policy(tmp_path / "policy.safetensors", 4)
    other = tiny_models.surrogate(tmp_path / "surrogate.safetensors", 4)
    code = (
        "import sys\nfrom tethernet_planner import policies, predictors as prediction\n"
        f"policies.plan({str(file)!r}, 4, (0.0, 0.0, -50.0)); prediction.make({str(other)!r}, 4)\n"
        "print([name for name in ('torch', 'sklearn', 'gymnasium', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_shipped_model_can_be_loaded_and_has_a_card():
    folder = Path(shipped_models.__file__).parent / "models"
    files = sorted(folder.glob("*.safetensors"))
    assert [file.stem for file in files] == ["policy_4mus", "policy_8mus", "surrogate_4mus", "surrogate_8mus"]
    for file in files:
        kind, design = file.stem.split("_")
        assert shipped_models.place(kind, int(design[0])).name == file.name
        make = policies.check if kind == "policy" else prediction.make
        make(str(file), int(design[0]))
        assert f"# {file.stem}" in file.with_suffix(".md").read_text()
