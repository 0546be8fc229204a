"""Both environments: the libraries' own checks, the reward's terms, what an episode comes to."""

import numpy as np
import pytest

from tests.systems import zenit
from tethernet_learning.policies import capture_sources as sources
from tethernet_learning.policies.reward import TERMS, Reward
from tethernet_sim.fly import Settings

pytest.importorskip("stable_baselines3")
from tests.learning.pretended import Pretended
from tethernet_learning.policies.gym_env import AimingEnv
from tethernet_learning.policies.vec_env import AimingVecEnv

pytestmark = pytest.mark.learning

REWARD = Reward(zenit(4), 0.13, 570.0)


def test_the_gymnasium_environment_passes_the_libraries_checks():
    from gymnasium.utils.env_checker import check_env
    from stable_baselines3.common.env_checker import check_env as check_env_sb3

    check_env(AimingEnv(Pretended(), REWARD), skip_render_check=True)
    check_env_sb3(AimingEnv(Pretended(), REWARD))


def test_an_episode_has_one_step():
    env = AimingEnv(Pretended(), REWARD)
    with pytest.raises(RuntimeError, match="reset"):
        env.step(np.zeros(8))
    observation, info = env.reset(seed=1, options={"debris_position": (9.0, -9.0, -50.0)})
    assert observation.tolist() == [1.0, -1.0, 0.0]
    assert info["debris_position"] == (9.0, -9.0, -50.0)
    _, reward, terminated, truncated, info = env.step(np.zeros(8))
    assert (terminated, truncated) == (True, False)
    assert sum(info["reward_terms"].values()) == pytest.approx(reward)
    with pytest.raises(ValueError, match="allowed"):
        env.reset(options={"debris_position": (99.0, 0.0, -50.0)})


def test_the_batch_names_its_terms_and_goes_on_where_it_is_told():
    env = AimingVecEnv(Pretended(), REWARD, env_count=3, seed=1)
    first = env.reset()
    actions = np.zeros((3, 8))
    actions[1] = 1.0
    second, rewards, dones, infos = env.step(actions)
    assert dones.all()
    assert set(infos[0]["reward_terms"]) == set(TERMS)
    assert rewards[0] > rewards[1]
    assert infos[1]["terminal_observation"].tolist() == first[1].tolist()
    assert not np.array_equal(first, second)
    assert np.array_equal(AimingVecEnv(Pretended(), REWARD, 3, seed=1, next_episode=3).reset(), second)


def test_the_aiming_points_follow_the_debris_through_the_symmetry():
    source = Pretended()
    env = AimingVecEnv(source, REWARD, env_count=8, seed=2, symmetry="system")
    assert (env.reset()[:, 0] >= np.abs(env.reset()[:, 1])).all()
    action = np.zeros((8, 8))
    action[:, 0] = 1.0  # MU 1 of the image outwards
    env.step(action)
    moved = {int(np.abs(s.aiming_offsets).sum(axis=1).argmax()) for s in source.flown}
    assert len(moved) > 1


def test_a_full_simulation_is_flown():
    env = AimingVecEnv(sources.make("full", Settings.load()), REWARD, env_count=1, seed=1)
    env.reset()
    _, rewards, _, infos = env.step(np.zeros((1, 8)))
    assert 400.0 < infos[0]["mouth_area_m2"] < 600.0
    assert infos[0]["reward_terms"]["mouth"] == pytest.approx(infos[0]["mouth_area_m2"] / 570.0)
    assert rewards[0] == pytest.approx(sum(infos[0]["reward_terms"].values()))


def test_sources_are_known_by_name():
    with pytest.raises(ValueError, match="allowed: full, surrogate"):
        sources.make("other", Settings.load())
    with pytest.raises(ValueError, match="needs the file"):
        sources.make("surrogate", Settings.load())
