"""A system that is not the paper's, from the first scenario to a mission with the trained policy, at tiny size."""

import json

import numpy as np
import pytest

from tests.command import tethernet
from tethernet_core.system import load_system
from tethernet_learning.data import data_set
from tethernet_planner import policies
from tethernet_planner import predictors as prediction
from tethernet_planner.inference.net_sample import NetSample
from tethernet_planner.inference.policy_file import AimingPolicy
from tethernet_sim.fly import Settings, fly_many
from tethernet_sim.scenario import Scenario
from tethernet_sim.world import World

pytest.importorskip("torch")
pytest.importorskip("sklearn")
pytest.importorskip("stable_baselines3")
pytest.importorskip("pyarrow")

pytestmark = pytest.mark.learning

NAME = "mine"
BASE = "hexagonal_6mu"
TEXT = """
name: mine
based_on: {base}
capture: {{cqi_threshold: {threshold:.3f}}} # some of its captures, not all
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Data, constants of the reward, a surrogate and a policy."""
    folder = tmp_path_factory.mktemp("own")
    file = folder / "mine.yaml"
    indices = [outcome.cqi for outcome in fly_many([Scenario(BASE, seed=seed) for seed in range(6)])]
    file.write_text(TEXT.format(base=BASE, threshold=float(np.median(indices))))
    system = ["--system", file]
    data, constants, surrogate = folder / "data", folder / "references.json", folder / "surrogate"
    commands = (
        ["data", "make", *system, "--train", "28", "--test", "8", "--output", data],
        ["train", "references", *system, "--missions", "4", "--output", constants],
        ["train", "surrogate", "--data", data, "--models", "trees", "rnn", "--trees", "5", "--epochs", "2",
         "--output", surrogate],
        ["train", "policy", *system, "--surrogate", surrogate / "surrogate.safetensors", "--references", constants,
         "--symmetry", "system", "--episodes", "8", "--envs", "2", "--steps", "2", "--batch", "4",
         "--output", folder / "policy"],
    )  # fmt: skip
    for words in commands:
        assert tethernet(*map(str, words)) == 0, words
    return folder


def test_the_data_describe_their_system(made):
    captures = data_set.read(made / "data" / "train.parquet")
    assert captures.system == load_system(made / "mine.yaml")
    assert captures.features.shape[1] == 6 * (84 + 54 + 18 + 1 + 6)


def test_models_carry_their_system_and_no_other_takes_them(made):
    system, policy, surrogate = (
        load_system(made / "mine.yaml"),
        made / "policy/policy.safetensors",
        made / "surrogate/rnn.safetensors",
    )
    loaded = AimingPolicy.load(policy)
    assert (loaded.made_for.system, loaded.made_for.digest, loaded.mus) == (NAME, system.digest, 6)
    assert len(loaded.task.images) == 2
    assert len(policies.plan(str(policy), system, (1.0, 2.0, -50.0)).points) == 6
    for check, error, file in (
        (policies.check, policies.PolicyError, policy),
        (prediction.make, prediction.PredictorError, surrogate),
    ):
        check(str(file), system)
        with pytest.raises(error, match=f"made for system {NAME} .*, not for zenit_8mu"):
            check(str(file), load_system("zenit_8mu"))


def test_the_surrogate_predicts_from_a_net_as_it_is_published(made):
    system = load_system(made / "mine.yaml")
    settings = Settings.load(system)
    world = World(
        system, *map(np.array, ([[0.0, 0.0, -50.0]], [[0.0, 0.0, 0.0, 1.0]], [[0.0, 0.0, 0.0]])), settings.physics,
        settings.control,
    )  # fmt: skip
    knots, mus = world.knots_as_published(0), world.mus_as_published(0)
    sample = NetSample(0, (0, 0, 0), (0.0, 0.0, -50.0), 0, mus, knots, 0.0 * knots, 0.0 * mus)
    told = prediction.make(str(made / "surrogate" / "surrogate.safetensors"), system).predict(sample)
    assert 0.0 <= told.locked_pairs <= system.closing.max_locked_pairs
    assert 0.0 <= told.capture_probability <= 1.0


def test_the_policy_is_evaluated_and_flies_a_mission(made, tmp_path, capsys):
    policy = str(made / "policy" / "policy.safetensors")
    system = ["--system", str(made / "mine.yaml")]
    words = [*system, "--scenarios", "2", "--policy", policy, "--output", str(tmp_path / "evaluation")]
    assert tethernet("evaluate", "policies", *words) == 0
    result = json.loads((tmp_path / "evaluation" / "evaluation.json").read_text())["systems"][NAME]
    assert result["paper"] is None
    assert result["policies"][policy]["against_nominal"]["pairs"] == 2
    capsys.readouterr()
    assert tethernet("fly", *system, "--policy", policy, "--json", str(tmp_path / "out.json")) in (0, 3)
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["policy"] == policy
    assert len(told["scenario"]["aiming_offsets"]) == 6
    assert told["outcome"]["error"] == ""


def test_what_is_lacking_for_an_own_system_is_said(made, tmp_path, capsys):
    words = ["--system", str(made / "mine.yaml"), "--output", str(tmp_path / "run")]
    surrogate = str(made / "surrogate" / "surrogate.safetensors")
    assert tethernet("train", "policy", *words, "--surrogate", surrogate) == 2
    assert f"constants for system {NAME} are not there" in capsys.readouterr().err
    assert tethernet("fly", "--system", str(made / "mine.yaml"), "--policy", "rl") == 2
    assert f"no policy for system {NAME} is shipped" in (said := capsys.readouterr().err)
    assert "shipped: zenit_4mu, zenit_8mu" in said
    assert "nominal needs none" in said
    assert tethernet("train", "policy", "--system", "passive_5m", "--source", "full", "--output", str(tmp_path)) == 2
    assert "passive_5m has no units" in capsys.readouterr().err
