"""Many episodes at once as a stable-baselines3 ``VecEnv`` on the batch engine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium  # noqa: TID253 - this module is imported only where training is wanted
import numpy as np
from stable_baselines3.common.vec_env import VecEnv  # noqa: TID253

from tethernet_learning import assumed_numbers
from tethernet_learning.policies import episodes
from tethernet_learning.policies.capture_sources import Source
from tethernet_learning.policies.episode_settings import learned_task
from tethernet_learning.policies.reward import Reward
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose


def minus_mean_of_others(rewards: np.ndarray, groups: Sequence[Sequence[int]]) -> np.ndarray:
    """Each reward minus the mean of the others of its group.

    The others' actions were drawn independently of its own, so that the policy's gradient keeps its expected value.

    Args:
        rewards: shape (N,).
        groups: numbers of the members of each, every number in one of them, two or more in each.

    Returns:
        Shape (N,).
    """
    compared = np.array(rewards, float)
    for group in groups:
        members = np.asarray(group)
        own = compared[members]
        compared[members] = own - (own.sum() - own) / (len(own) - 1)
    return compared


class AimingVecEnv(VecEnv):
    """N environments of one-step episodes, flown as one batch.

    Observation: the debris' position scaled to [-1, 1], shape (3,). Action: (dx, dy) of each MU scaled to [-1, 1],
    shape (2 M,). Episode k of a seed is always the same scenario, so that the environment has no state but the number
    of the next episode: a training that goes on after a kill sees what it would have seen.
    """

    def __init__(
        self,
        source: Source,
        reward: Reward,
        env_count: int,
        seed: int,
        next_episode: int = 0,
        symmetry: str = "none",
        purpose: Purpose = Purpose.POLICY_TRAINING,
        compare_within_draws: bool = False,
    ):
        """Args:
        source: flies the episodes.
        reward: judges them; names the system.
        env_count: episodes in parallel.
        seed: of the stream of scenarios.
        next_episode: number of the first episode.
        symmetry: one of :data:`.task.SYMMETRIES`.
        purpose: the stream of scenarios.
        compare_within_draws: give rewards minus the mean of the others with the same draw of the assumed numbers;
            ``infos`` hold them as they are.
        """
        self.render_mode = None
        actions = gymnasium.spaces.Box(-1.0, 1.0, (2 * reward.system.unit_count,), np.float32)
        super().__init__(env_count, gymnasium.spaces.Box(-1.0, 1.0, (3,), np.float32), actions)
        self.next_episode = next_episode
        self._source, self._reward, self._seed = source, reward, seed
        self._compare_within_draws = compare_within_draws
        self._task, self._purpose = learned_task(reward.system, symmetry), purpose
        self._actions = np.zeros((env_count, 2 * reward.system.unit_count))
        self._observe()

    def _observe(self) -> np.ndarray:
        """Look at the next episodes."""
        self._scenarios = random_scenarios(
            self._reward.system, self._purpose, self._seed, self.next_episode, self.num_envs
        )
        scaled = [self._task.scale_observation(s.debris_position) for s in self._scenarios]
        self._images = [image for _, image in scaled]
        self._observations = np.array([observation for observation, _ in scaled])
        return self._observations.copy()

    def reset(self) -> np.ndarray:
        """The next episodes' observations, shape (N, 3); nothing was flown of them."""
        return self._observations.copy()

    def step_async(self, actions: np.ndarray) -> None:
        """Args:
        actions: shape (N, 2 M).
        """
        self._actions = np.asarray(actions, float)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Fly. All episodes end; ``infos`` hold the terms of the reward by name, and what was flown."""
        offsets = [
            self._task.offsets_from_action(a, image) for a, image in zip(self._actions, self._images, strict=True)
        ]
        results = episodes.fly(self._source, self._reward, self._scenarios, offsets)
        flown, captured = results.flown, results.flown.captured
        infos = [
            {
                "reward_terms": {name: float(values[i]) for name, values in results.terms.items()},
                "fuel_kg": float(flown.fuel_kg[i]),
                "mouth_area_m2": float(flown.mouth_area_m2[i]),
                "cqi": float(flown.cqi[i]),
                "locked_pairs": int(flown.locked_pairs[i]),
                "is_success": bool(captured[i]),
                "episode": {"r": float(results.rewards[i]), "l": 1, "t": 0.0},
                "terminal_observation": self._observations[i].copy(),
                "TimeLimit.truncated": False,
            }
            for i in range(self.num_envs)
        ]
        self.next_episode += self.num_envs
        rewards = results.rewards
        if self._compare_within_draws:
            rewards = minus_mean_of_others(rewards, [numbers for numbers, _ in assumed_numbers.groups(self._scenarios)])
        return self._observe(), rewards.astype(np.float32), np.ones(self.num_envs, bool), infos

    def close(self) -> None:
        """Nothing to close."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The same for all: there is one object."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Sets it for all: there is one object."""
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Calls it once for each index."""
        return [getattr(self, method_name)(*args, **kwargs) for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Nothing is wrapped."""
        return [False for _ in self._get_indices(indices)]
