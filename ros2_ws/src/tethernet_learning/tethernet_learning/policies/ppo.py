"""Hyper-parameters of the training with PPO, and how a trained policy leaves it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tethernet_learning import assumed_numbers
from tethernet_learning.policies.episode_settings import EpisodeSettings
from tethernet_planner.inference.model_file import MadeFor
from tethernet_planner.inference.networks import dense
from tethernet_planner.inference.policy_file import AimingPolicy

DRAW = "draw"
BASELINES = ("none", DRAW)
"""``draw``: the mean reward of the other episodes with the same draw of the assumed numbers. The critic sees where the
debris is and not what was drawn, and between draws fuel differs by several times what aiming can save."""


@dataclass(frozen=True)
class PpoSettings(EpisodeSettings):
    """The paper's where it tells them [P], else those of stable-baselines3 or assumed [A]. Everything else is a named
    deviation.
    """

    envs: int = 32
    """Episodes in parallel [P]."""
    steps: int = 5
    """Batches of parallel episodes between two updates [A]: 160 episodes, 71 updates in 11,360 episodes."""
    batch: int = 64
    """Mini-batch [P]."""
    epochs: int = 10
    """Passes over the episodes of an update (library's default)."""
    learning_rate: float = 0.001
    """[P]"""
    rate_decay: bool = False
    """The learning rate falls to nothing in a straight line over the episodes."""
    clip: float = 0.2
    """PPO's clipping range (library's default)."""
    log_std: float = 0.0
    """Logarithm of the exploration's initial standard deviation, actions scaled to [-1, 1]: 0, the library's default,
    is 5 m for every MU; -2.3 is half a metre."""
    baseline: str = "none"
    """One of :data:`BASELINES`: what an episode's reward is compared with, beside the critic's value."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: naming the value and what is allowed.
        """
        super().__post_init__()
        if self.baseline not in BASELINES:
            raise ValueError(f"baseline {self.baseline!r}; allowed: {', '.join(BASELINES)}")
        alike = self.assumed == assumed_numbers.AS_DESCRIBED
        if self.baseline == DRAW and (alike or self.envs % assumed_numbers.GROUP):
            raise ValueError(
                f"baseline {DRAW}: allowed with assumed = {assumed_numbers.RANDOM} or {assumed_numbers.ENDS} and envs "
                f"a multiple of the {assumed_numbers.GROUP} scenarios that share a draw"
            )
        for name in ("episodes", "envs", "steps", "batch", "epochs"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} = {getattr(self, name)}; allowed: 1 or more")
        self.check_ends("envs", self.envs)
        if self.episodes % (self.envs * self.steps):
            raise ValueError(
                f"episodes = {self.episodes}; allowed: a multiple of envs x steps = {self.envs * self.steps}, "
                "the episodes of one update"
            )

    @property
    def update_episodes(self) -> int:
        """Episodes between two updates."""
        return self.envs * self.steps


def new_model(settings: PpoSettings, env: Any) -> Any:
    """An untrained PPO whose policy aims at the nominal points.

    The mean of the library's untrained policy is within a few centimetres of them.
    """
    from stable_baselines3 import PPO

    rate = settings.learning_rate
    return PPO(
        "MlpPolicy",
        env,
        learning_rate=_falling(rate) if settings.rate_decay else rate,
        n_steps=settings.steps,
        batch_size=settings.batch,
        n_epochs=settings.epochs,
        clip_range=settings.clip,
        policy_kwargs={"log_std_init": settings.log_std},
        seed=settings.seed,
        device="cpu",
    )


class _falling:  # noqa: N801 - a function that can be saved
    def __init__(self, rate: float):
        self.rate = rate

    def __call__(self, left: float) -> float:
        return self.rate * left


def begin_with(model: Any, policy: AimingPolicy) -> None:
    """Give an untrained PPO the mean of a trained policy; exploration and critic stay as they are.

    Args:
        model: a stable-baselines3 PPO.
        policy: for the same system and with the same layers as the library's default policy.

    Raises:
        ValueError: when its layers are others.
    """
    import torch

    wanted = {name: tuple(value.shape) for name, value in _weights(model).items()}
    given = {name: tuple(value.shape) for name, value in policy.arrays.items()}
    if given != wanted:
        raise ValueError(f"the policy to begin with has layers {given}; allowed: {wanted}")
    with torch.no_grad():
        for name, value in _weights(model).items():
            value.copy_(torch.from_numpy(policy.arrays[name]))


def _weights(model: Any) -> dict[str, Any]:
    """The deterministic part of a PPO, by the names of a policy's arrays."""
    policy = model.policy
    layers = [layer for layer in policy.mlp_extractor.policy_net if hasattr(layer, "weight")] + [policy.action_net]
    return {f"{name}_{k}": getattr(layer, name) for name in ("weight", "bias") for k, layer in enumerate(layers)}


def export(model: Any, settings: PpoSettings, about: dict[str, Any]) -> AimingPolicy:
    """The deterministic part of a trained PPO, for NumPy.

    Args:
        model: a stable-baselines3 PPO.
        settings: it was trained with.
        about: facts for the model card.

    Raises:
        ValueError: when the copy does not answer as the original does.
    """
    arrays = {name: value.detach().numpy().copy() for name, value in _weights(model).items()}
    observations = np.random.default_rng(0).uniform(-1, 1, (100, 3)).astype(np.float32)
    expected, _ = model.predict(observations, deterministic=True)
    if not np.allclose(np.clip(dense(arrays, observations), -1, 1), expected, atol=1e-4):
        raise ValueError("the exported policy does not answer as the trained one; is its network not the default one?")
    return AimingPolicy(MadeFor.of(settings.system), settings.task, arrays, about)
