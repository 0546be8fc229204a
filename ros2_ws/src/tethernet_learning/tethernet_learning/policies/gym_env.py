"""One episode at a time as a Gymnasium environment, for any library of reinforcement learning."""

from __future__ import annotations

from typing import Any

import gymnasium  # noqa: TID253 - this module is imported only where training is wanted
import numpy as np

from tethernet_learning.policies import episodes
from tethernet_learning.policies.capture_sources import Source
from tethernet_learning.policies.episode_settings import learned_task
from tethernet_learning.policies.reward import Reward
from tethernet_sim.scenario import Scenario


class AimingEnv(gymnasium.Env):
    """Aim the net once at a debris somewhere within the mission's bounds.

    Spaces as in :class:`.vec_env.AimingVecEnv`. An episode has one step and is then ``terminated``, never
    ``truncated``. ``options={"debris_position": (x, y, z)}`` at ``reset`` chooses the debris [m].
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(self, source: Source, reward: Reward, symmetry: str = "none"):
        """Args:
        source: flies the episodes.
        reward: judges them; names the system.
        symmetry: one of :data:`.task.SYMMETRIES`.
        """
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (3,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2 * reward.system.unit_count,), np.float32)
        self._source, self._reward = source, reward
        self._task = learned_task(reward.system, symmetry)
        self._scenario: Scenario | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """See :class:`gymnasium.Env`.

        Raises:
            ValueError: for a debris position out of the bounds.
        """
        super().reset(seed=seed)
        position = (options or {}).get("debris_position")
        if position is None:
            position = self._task.random_debris_position(self.np_random)
        if not self._task.inside(position):
            raise ValueError(f"debris_position {position}; allowed: {self._task.bounds_text()}")
        noise_seed = int(self.np_random.integers(2**31))
        self._scenario = Scenario(self._reward.system, debris_position=tuple(position), seed=noise_seed)
        self._observation, self._image = self._task.scale_observation(position)
        return self._observation.copy(), {"debris_position": self._scenario.debris_position}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """See :class:`gymnasium.Env`; the observation does not change.

        Raises:
            RuntimeError: when ``reset`` was not called since the last step.
        """
        if self._scenario is None:
            raise RuntimeError("the episode is over after one step; call reset()")
        offsets = self._task.offsets_from_action(action, self._image)
        results = episodes.fly(self._source, self._reward, [self._scenario], [offsets])
        self._scenario = None
        info = {
            "reward_terms": {name: float(values[0]) for name, values in results.terms.items()},
            "fuel_kg": float(results.flown.fuel_kg[0]),
            "mouth_area_m2": float(results.flown.mouth_area_m2[0]),
            "cqi": float(results.flown.cqi[0]),
            "locked_pairs": int(results.flown.locked_pairs[0]),
            "is_success": bool(results.flown.captured[0]),
        }
        return self._observation.copy(), float(results.rewards[0]), True, False, info
