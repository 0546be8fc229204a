"""Trained policies and surrogates by name and by path, shipped or not."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests import tiny_models
from tests.command import tethernet
from tests.systems import zenit
from tethernet_bringup.mission import arguments
from tethernet_bringup.mission import command_line as cli
from tethernet_bringup.mission import parameters as mission_parameters
from tethernet_core.aiming import nominal_aiming_points
from tethernet_core.system import load_system
from tethernet_learning import measured
from tethernet_learning.campaigns.cases import Case, aim
from tethernet_learning.flight_digest import flight_digest
from tethernet_planner import policies
from tethernet_planner import predictors as prediction
from tethernet_planner.inference import model_file, shipped_models
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
    file = tiny_models.policy(shipped_models.place("policy", zenit(mus).name), zenit(mus))
    name = word if word == "rl" else str(file)
    plan = policies.plan(name, zenit(mus), DEBRIS)
    assert (plan.policy, plan.message) == (name, "")
    for (x, y, z), nominal in zip(plan.points, nominal_aiming_points(zenit(mus), DEBRIS), strict=True):
        assert (x - nominal[0], y - nominal[1], z) == pytest.approx((0.5, -0.3, nominal[2]))
    assert len(policies.fingerprint(name, zenit(mus))) == 16
    assert policies.fingerprint("nominal", zenit(mus)) is None


def test_without_a_shipped_model_rl_says_so_and_what_to_do(shipped):
    tiny_models.policy(shipped_models.place("policy", "zenit_4mu"), zenit(4))
    policies.check("rl", zenit(4))
    with pytest.raises(policies.PolicyError) as refused:
        policies.check("rl", zenit(8))
    words = str(refused.value)
    for needed in (
        "no policy for system zenit_8mu is shipped",
        "(shipped: zenit_4mu)",
        "PATH/policy.safetensors",
        "tethernet models install",
        "nominal needs none",
    ):
        assert needed in words
    with pytest.raises(
        prediction.PredictorError, match=r"no surrogate for system zenit_8mu is shipped.*none needs none"
    ):
        prediction.make("surrogate", zenit(8))


def test_a_wrong_file_is_named_with_what_is_allowed(tmp_path):
    (tmp_path / "noise.safetensors").write_bytes(b"\x00" * 100)
    tiny_models.surrogate(tmp_path / "surrogate.safetensors", zenit(8))
    tiny_models.policy(tmp_path / "four.safetensors", zenit(4))
    for name, words in (
        ("missing.safetensors", "there is no file"),
        ("noise.safetensors", "cannot be read as a model"),
        ("surrogate.safetensors", "is a surrogate, format version 3; allowed: a policy"),
        ("four.safetensors", "made for system zenit_4mu .digest .*, not for zenit_8mu"),
    ):
        with pytest.raises(policies.PolicyError, match=words):
            policies.check(str(tmp_path / name), zenit(8))
    for name, words in (("missing.safetensors", "there is no file"), ("four.safetensors", "allowed: a surrogate")):
        with pytest.raises(prediction.PredictorError, match=words):
            prediction.make(str(tmp_path / name), zenit(8))


def test_outside_the_trained_bounds_the_nominal_points_stand_in_and_it_is_said(shipped):
    tiny_models.policy(shipped_models.place("policy", "zenit_8mu"), zenit(8))
    far = (9.5, 0.0, -50.0)
    plan = policies.plan("rl", zenit(8), far)
    assert plan.points == nominal_aiming_points(zenit(8), far)
    assert plan.policy == "nominal (fallback)"
    assert "policy rl was not trained for it (debris at (9.5, 0, -50) m; trained: x and y from -9 to 9" in plan.message
    near, away = aim([Case(Scenario("zenit_8mu", debris_position=place), "") for place in (DEBRIS, far)], "rl")
    assert (near.policy, away.policy) == ("rl", "nominal (fallback)")
    assert near.scenario.aiming_offsets[0] == pytest.approx((0.5, -0.3))
    assert away.scenario.aiming_offsets is None


def test_in_process_and_by_service_the_mus_are_sent_to_the_same_bits(shipped):
    tiny_models.policy(shipped_models.place("policy", "zenit_8mu"), zenit(8), 0.1, -4.7)
    for seed in range(20):
        place = tuple(np.round(np.random.default_rng(seed).uniform((-9, -9, -60), (9, 9, -40)), 1).tolist())
        [case] = aim([Case(Scenario("zenit_8mu", debris_position=place), "")], "rl")
        assert case.scenario.aiming_points().tolist() == [
            list(p) for p in policies.aiming_points("rl", zenit(8), place)
        ]


def test_a_surrogate_predicts_from_positions_and_velocities_relative_to_the_debris(tmp_path):
    knots = np.zeros((zenit(8).net.node_count, 3), np.float32)
    velocities = knots + np.float32(2.0)
    mus = np.zeros((8, 3), np.float32)

    def told(seen):
        file = tiny_models.surrogate(tmp_path / "surrogate.safetensors", zenit(8), pairs=3.0, seen=seen)
        sample = NetSample(0, (0, 0, 0), (0.0, 0.0, -1.5), 0, mus, knots, velocities, mus, (0.0, 0.0, 0.5))
        return prediction.make(str(file), zenit(8)).predict(sample)

    assert told(None) == Prediction(pytest.approx(1.5), pytest.approx(3.0), pytest.approx(0.5))
    assert told(2).locked_pairs == pytest.approx(3.0 + 1.5)
    assert told(5).locked_pairs == pytest.approx(3.0 + 1.5)
    assert told(4).locked_pairs == pytest.approx(3.0 + 2.0)


def test_a_net_with_another_mesh_is_refused(tmp_path):
    made = prediction.make(str(tiny_models.surrogate(tmp_path / "surrogate.safetensors", zenit(8))), zenit(8))
    few = np.zeros((9, 3), np.float32)
    with pytest.raises(ValueError, match="a net of 9 nodes; that of system zenit_8mu has 529"):
        made.predict(NetSample(0, (0, 0, 0), (0, 0, 0), 0, few[:8], few, few, few[:8]))


def test_a_mission_carries_absolute_paths_and_hashes(tmp_path, monkeypatch):
    tiny_models.policy(tmp_path / "policy.safetensors", zenit(4))
    tiny_models.surrogate(tmp_path / "surrogate.safetensors", zenit(4))
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
        make(shipped_models.place(kind, "zenit_8mu"), zenit(8))
        card = {"model": file_fingerprint(shipped_models.place(kind, "zenit_8mu")), "flight_digest": "of yesterday"}
        card["system_digest"] = zenit(8).digest
        measured.place(kind, "zenit_8mu").write_text(json.dumps(card))
    both = cli.stale_cards(mission_parameters.resolve(arguments.parse(["--mus", "8"])))
    assert [notice.partition(" is stale")[0] for notice in both if notice] == [
        "the card of the policy for zenit_8mu",
        "the card of the surrogate for zenit_8mu",
    ]
    [one] = cli.stale_cards(mission_parameters.resolve(arguments.parse(["--mus", "8", "--policy", "nominal"])))
    assert one.startswith("the card of the surrogate for zenit_8mu is stale")
    card["flight_digest"] = flight_digest()
    measured.place("surrogate", "zenit_8mu").write_text(json.dumps(card))
    assert cli.stale_cards(mission_parameters.resolve(arguments.parse(["--mus", "8", "--policy", "nominal"]))) == [""]


@pytest.mark.parametrize("mus", [4, 8])
def test_a_mission_with_a_policy_that_cannot_be_had_is_refused_before_anything_starts(tmp_path, mus):
    file = tiny_models.policy(tmp_path / "policy.safetensors", zenit(12 - mus))
    for word, words in (
        ("rl", "no policy for"),
        (str(file), f"made for system zenit_{12 - mus}mu .*, not for zenit_{mus}mu"),
    ):
        with pytest.raises(mission_parameters.MissionParametersError, match=f"--policy {word[:40]}.*: .*{words}"):
            mission_parameters.resolve(arguments.parse(["--mus", str(mus), "--policy", word]))


def test_flying_a_trained_policy_needs_no_torch(tmp_path):
    file = tiny_models.policy(tmp_path / "policy.safetensors", zenit(4))
    other = tiny_models.surrogate(tmp_path / "surrogate.safetensors", zenit(4))
    code = (
        "import sys\nfrom tethernet_core.system import load_system\n"
        "from tethernet_planner import policies, predictors as prediction\nsystem = load_system('zenit_4mu')\n"
        f"policies.plan({str(file)!r}, system, (0.0, 0.0, -50.0)); prediction.make({str(other)!r}, system)\n"
        "print([name for name in ('torch', 'sklearn', 'gymnasium', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_shipped_model_can_be_loaded_and_has_a_card():
    folder = Path(shipped_models.__file__).parent / "models"
    files = sorted(folder.glob("*.safetensors"))
    assert [file.stem for file in files] == [
        f"{kind}_zenit_{units}mu" for kind in ("policy", "surrogate") for units in (4, 8)
    ]
    for file in files:
        kind, _, name = file.stem.partition("_")
        assert shipped_models.place(kind, name).name == file.name
        make = policies.check if kind == "policy" else prediction.make
        make(str(file), load_system(name))
        assert f"# {file.stem}" in file.with_suffix(".md").read_text()


def test_a_model_of_a_system_that_was_changed_since_is_refused_with_both_named(shipped):
    tiny_models.policy(shipped_models.place("policy", "zenit_8mu"), zenit(8))
    tiny_models.surrogate(shipped_models.place("surrogate", "zenit_8mu"), zenit(8))
    changed = load_system("zenit_8mu", {"debris.mass_kg": 8000.0})
    words = (
        f"made for system zenit_8mu .digest {zenit(8).digest[:12]}.*, not for zenit_8mu .digest {changed.digest[:12]}"
    )
    with pytest.raises(policies.PolicyError, match=words):
        policies.check("rl", changed)
    with pytest.raises(prediction.PredictorError, match=words):
        prediction.make("surrogate", changed)
    with pytest.raises(
        policies.PolicyError, match=r"no policy for system hexagonal_6mu is shipped .*\(shipped: zenit_8mu\)"
    ):
        policies.check("rl", load_system("hexagonal_6mu"))


@pytest.mark.parametrize("kind", ["policy", "surrogate"])
def test_a_model_of_the_format_before_is_converted_with_its_weights(tmp_path, kind, capsys):
    file = getattr(tiny_models, kind)(tmp_path / f"{kind}.safetensors", zenit(8))
    arrays, about = model_file.read(file, kind)
    old_facts = {key: value for key, value in about.items() if key not in ("system", "system_digest", "images")}
    old_arrays = {name: array for name, array in arrays.items() if name not in ("nodes", "sectors")}
    if kind == "policy":
        old_facts["symmetry"] = "diagonal"
    monkeypatched = pytest.MonkeyPatch()
    monkeypatched.setattr(model_file, "VERSION", 2)
    model_file.write(file, kind, old_arrays, old_facts)
    monkeypatched.undo()
    with pytest.raises(model_file.ModelFileError, match=r"format version 2; .*tethernet models convert"):
        model_file.read(file, kind)
    assert tethernet("models", "convert", str(file), "--system", "zenit_4mu") == 2
    assert "was made for 8 units, and zenit_4mu has 4" in capsys.readouterr().err
    assert tethernet("models", "convert", str(file), "--system", "zenit_8mu") == 0
    again, facts = model_file.read(file, kind)
    assert again.keys() == arrays.keys()
    assert all(np.array_equal(again[name], arrays[name]) for name in arrays)
    assert facts["system_digest"] == zenit(8).digest
    assert kind == "surrogate" or len(facts["images"]) == 4
    assert tethernet("models", "convert", str(file), "--system", "zenit_8mu") == 2
    assert [path.name for path in tmp_path.iterdir() if path.is_file()] == [file.name]
