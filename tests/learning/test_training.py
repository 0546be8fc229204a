"""Training: one seed gives one policy, killed or not; what is exported answers as what was trained."""

import base64
import functools
import json
import pickle
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from tests.command import tethernet
from tests.learning.pretended import Pretended
from tests.systems import zenit
from tethernet_learning import run_folder
from tethernet_learning.policies import history, offset_search, train_policy
from tethernet_learning.policies.ppo import PpoSettings, begin_with, new_model
from tethernet_learning.policies.reward import Reward
from tethernet_learning.policies.vec_env import AimingVecEnv, minus_mean_of_others
from tethernet_planner.inference import model_file
from tethernet_planner.inference.networks import dense
from tethernet_planner.inference.policy_file import AimingPolicy, OutsideTrainingError, constant_policy
from tethernet_planner.inference.symmetry import Symmetry
from tethernet_planner.inference.task import task_of

pytestmark = pytest.mark.learning

ZENIT_4 = zenit(4)
REWARD = Reward(ZENIT_4, 0.05, 570.0)
SETTINGS = PpoSettings(ZENIT_4, seed=5, episodes=128, envs=8, steps=2, batch=8, log_std=-1.0)


class KilledError(Exception):
    pass


class KilledAfter(Pretended):
    def __init__(self, batches):
        self.left = batches

    def fly(self, scenarios):
        self.left -= 1
        if self.left < 0:
            raise KilledError
        return super().fly(scenarios)


def train(folder, source=None, settings=SETTINGS):
    folder.mkdir(exist_ok=True)
    file = train_policy.train(folder, settings, source or Pretended(), REWARD, {})
    return model_file.read(file, "policy")[0]


def test_the_same_seed_gives_the_same_policy_killed_or_not(tmp_path):
    whole = train(tmp_path / "whole")
    with pytest.raises(KilledError):
        train(tmp_path / "killed", KilledAfter(9))
    resumed = train(tmp_path / "killed")
    assert all(np.array_equal(whole[name], resumed[name]) for name in whole)
    files = [tmp_path / name / history.FILE for name in ("whole", "killed")]
    assert files[0].read_text() == files[1].read_text()
    assert len(history.read(files[0])) == 16
    other = train(tmp_path / "other", settings=PpoSettings(ZENIT_4, seed=6, episodes=128, envs=8, steps=2, batch=8))
    assert not np.array_equal(whole["weight_0"], other["weight_0"])


def test_a_training_begins_with_a_policy_when_told(tmp_path):
    train(tmp_path / "first")
    first = AimingPolicy.load(tmp_path / "first" / "policy.safetensors")
    model = new_model(SETTINGS, AimingVecEnv(Pretended(), REWARD, 8, 0))
    exploration = model.policy.log_std.detach().numpy().copy()
    begin_with(model, first)
    seen = np.random.default_rng(3).uniform(-1, 1, (20, 3)).astype(np.float32)
    answered = model.predict(seen, deterministic=True)[0]
    assert np.allclose(answered, np.clip(dense(first.arrays, seen), -1, 1), atol=1e-5)
    assert np.array_equal(model.policy.log_std.detach().numpy(), exploration)
    with pytest.raises(ValueError, match="layers"):
        begin_with(model, constant_policy(ZENIT_4, task_of(ZENIT_4), np.zeros((4, 2))))

    (tmp_path / "second").mkdir()
    slow = PpoSettings(ZENIT_4, seed=5, episodes=16, envs=8, steps=2, batch=8, learning_rate=1e-6, log_std=-1.0)
    train_policy.train(tmp_path / "second", slow, Pretended(), REWARD, {}, first)
    second = AimingPolicy.load(tmp_path / "second" / "policy.safetensors")
    assert np.allclose(second.offsets((1.0, 2.0, -50.0)), first.offsets((1.0, 2.0, -50.0)), atol=1e-3)


def test_rewards_within_a_draw_are_compared_with_the_others_there():
    rewards = np.array([1.0, 2.0, 6.0, 10.0, 30.0])
    compared = minus_mean_of_others(rewards, [[0, 1, 2], [3, 4]])
    assert compared.tolist() == [-3.0, -1.5, 4.5, -20.0, 20.0]
    assert rewards[0] == 1.0
    # What all members of a draw share is gone, whatever it is.
    assert np.allclose(minus_mean_of_others(rewards + np.array([7, 7, 7, -9, -9]), [[0, 1, 2], [3, 4]]), compared)


def test_environments_compare_within_draws_and_tell_the_rewards_as_they_are():
    actions = np.linspace(-1, 1, 16 * 8).reshape(16, 8)
    plain, compared = (AimingVecEnv(Pretended(), REWARD, 16, 0, compare_within_draws=told) for told in (False, True))
    (_, rewards, _, infos), (_, differences, _, same) = plain.step(actions), compared.step(actions)
    assert [info["episode"]["r"] for info in same] == [info["episode"]["r"] for info in infos]
    assert np.allclose(differences, minus_mean_of_others(rewards, [range(8), range(8, 16)]), atol=1e-6)
    assert np.abs(differences).max() > 1e-3


@pytest.mark.parametrize(
    "wrong", [{"baseline": "mean"}, {"baseline": "draw"}, {"baseline": "draw", "assumed": "random", "envs": 12}]
)
def test_a_baseline_that_cannot_be_is_refused(wrong):
    with pytest.raises(ValueError, match="baseline"):
        PpoSettings(ZENIT_4, **wrong)


def test_a_training_learns_and_leaves_what_it_should(tmp_path):
    settings = PpoSettings(ZENIT_4, seed=1, episodes=1600, envs=32, steps=2, log_std=-1.0)
    train(tmp_path / "run", settings=settings)
    lines = history.read(tmp_path / "run" / history.FILE)
    rewards = [line[1] for line in lines]
    assert np.mean(rewards[-10:]) > np.mean(rewards[:10]) + 0.05
    assert (tmp_path / "run" / "history.png").stat().st_size > 10_000
    assert list((tmp_path / "run" / "tensorboard").iterdir())
    assert (tmp_path / "run" / "policy.zip").exists()
    policy = AimingPolicy.load(tmp_path / "run" / "policy.safetensors")
    assert policy.offsets((0.0, 0.0, -50.0))[0].mean() < -0.5
    assert policy.about["last_tenth"]["captured"] == 1.0


class Hostile:
    """Executes something when it is unpickled."""

    def __init__(self, evidence):
        self.evidence = evidence

    def __reduce__(self):
        return (Path.touch, (self.evidence,))


def test_a_checkpoint_of_somebody_else_executes_nothing(tmp_path, capsys):
    torch = pytest.importorskip("torch")
    with pytest.raises(KilledError):
        train(tmp_path / "run", KilledAfter(9))
    evidence, replaced = tmp_path / "executed", 0
    for found in (tmp_path / "run" / "checkpoints").rglob("*"):
        if found.suffix == ".pt":
            torch.save({"policy": Hostile(evidence)}, found)
        elif found.suffix == ".zip":  # the library's own format
            hostile = base64.b64encode(pickle.dumps(Hostile(evidence))).decode()
            with zipfile.ZipFile(found, "w") as file:
                file.writestr("data", json.dumps({"seed": {":type:": "x", ":serialized:": hostile}}))
        else:
            continue
        replaced += 1
    assert replaced
    torch.save(Hostile(evidence), tmp_path / "control.pt")
    torch.load(tmp_path / "control.pt", weights_only=False)
    assert evidence.exists(), "the hostile object does what it is made for"
    evidence.unlink()
    with pytest.raises(ValueError, match="cannot be read as a checkpoint"):
        train(tmp_path / "run")
    assert not evidence.exists()


def test_no_module_unpickles_what_it_finds():
    unpickling = re.compile(
        r"pickle\.loads?\(|PPO\.load\(|joblib|allow_pickle(?!=False)|read_pickle|yaml\.unsafe_load"
        r"|torch\.load\((?!.*weights_only=True)"
    )
    sources = sorted((Path(__file__).parents[2] / "ros2_ws" / "src").glob("*/tethernet_*/**/*.py"))
    assert len(sources) > 300
    found = [
        f"{source.name}: {line.strip()}"
        for source in sources
        for line in source.read_text().splitlines()
        if unpickling.search(line)
    ]
    assert not found


@pytest.mark.parametrize("wrong", [{"episodes": 100}, {"symmetry": "x"}, {"batch": 0}])
def test_wrong_settings_are_explained(wrong):
    with pytest.raises(ValueError, match="allowed"):
        PpoSettings(ZENIT_4, **wrong)


def test_a_folder_takes_one_run_only(tmp_path):
    assert not run_folder.claim(tmp_path / "a", {"seed": 1, "more": {"x": 1}})
    assert run_folder.claim(tmp_path / "a", {"seed": 1, "more": {"x": 1}})
    with pytest.raises(run_folder.RunFolderError, match=r"more\.x: there 1, asked for 2"):
        run_folder.claim(tmp_path / "a", {"seed": 1, "more": {"x": 2}})
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "thesis.txt").touch()
    with pytest.raises(run_folder.RunFolderError, match="something that is no run"):
        run_folder.claim(tmp_path / "b", {})


def test_a_policy_keeps_its_bounds_and_its_design(tmp_path):
    constant_policy(ZENIT_4, task_of(ZENIT_4), np.full((4, 2), 1.2)).save(tmp_path / "p.safetensors")
    policy = AimingPolicy.load(tmp_path / "p.safetensors")
    assert np.allclose(policy.offsets((1.0, 2.0, -44.0)), 1.2)
    points = policy.aiming_points(ZENIT_4, (1.0, 2.0, -44.0))
    assert np.allclose(points[0], (-9.8, -8.8, -44.0))
    with pytest.raises(OutsideTrainingError, match="z from -60 to -40"):
        policy.offsets((0.0, 0.0, -70.0))
    with pytest.raises(model_file.ModelFileError, match=r"made for system zenit_4mu .*, not for zenit_8mu"):
        policy.aiming_points(zenit(8), (0.0, 0.0, -50.0))


@pytest.mark.parametrize("spoil", ["missing", "text", "surrogate", "symmetry", "layer"])
def test_wrong_policy_files_are_explained(spoil, tmp_path):
    path = tmp_path / "p.safetensors"
    policy = constant_policy(ZENIT_4, task_of(ZENIT_4), np.zeros((4, 2)))
    if spoil == "text":
        path.write_text("no policy")
    elif spoil == "surrogate":
        model_file.write(path, "surrogate", policy.arrays, policy.made_for.as_json())
    elif spoil == "symmetry":
        task = policy.task.with_images([Symmetry(((1.0, 0.0), (0.0, 2.0)), (0, 1, 2, 3))])
        AimingPolicy(policy.made_for, task, policy.arrays).save(path)
    elif spoil == "layer":
        AimingPolicy(policy.made_for, policy.task, {**policy.arrays, "bias_0": np.zeros(3)}).save(path)
    with pytest.raises(model_file.ModelFileError, match=r"p\.safetensors"):
        AimingPolicy.load(path)


def test_the_search_finds_the_offsets_killed_or_not(tmp_path):
    pytest.importorskip("cma")
    settings = offset_search.SearchSettings(ZENIT_4, seed=1, episodes=40 * 24, scenarios=2, candidates=12)

    def search(folder, source):
        folder.mkdir(exist_ok=True)
        return offset_search.search(folder, settings, source, REWARD, lambda done, more: None, {})

    with pytest.raises(KilledError):
        search(tmp_path / "killed", KilledAfter(17))
    resumed, whole = search(tmp_path / "killed", Pretended()), search(tmp_path / "whole", Pretended())
    assert np.array_equal(resumed.arrays["bias_0"], whole.arrays["bias_0"])
    offsets = whole.offsets((3.0, 0.0, -50.0))
    assert np.allclose(offsets[0], -2.0, atol=0.5)
    assert np.abs(offsets[1:]).max() < 0.5


def test_the_commands_explain_what_is_wrong(tmp_path, capsys):
    words = ["--mus", "4", "--output", str(tmp_path / "run")]
    for name in ("policy", "offsets"):
        train = functools.partial(tethernet, "train", name)
        assert train(*words) == 2
        assert "needs --surrogate" in capsys.readouterr().err
        assert train(*words, "--surrogate", str(tmp_path / "none.safetensors")) == 2
        assert "none.safetensors cannot be read" in capsys.readouterr().err
        assert train(*words, "--source", "full", "--episodes", "7") == 2
        assert "allowed" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
