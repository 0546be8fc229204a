"""A search for one set of offsets for all debris positions, without learning: what a policy must beat."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core import atomic_file
from tethernet_learning import run_folder
from tethernet_learning.policies import episodes
from tethernet_learning.policies.capture_sources import Source
from tethernet_learning.policies.episode_settings import EpisodeSettings
from tethernet_learning.policies.reward import Reward
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose
from tethernet_planner.inference.policy_file import AimingPolicy, constant_policy

FILE = "generations.json"


@dataclass(frozen=True)
class SearchSettings(EpisodeSettings):
    """Of the search with CMA-ES."""

    scenarios: int = 16
    """On which each candidate of a generation is flown: the same for all, others in the next generation."""
    candidates: int = 12
    """Of a generation."""
    sigma_m: float = 1.0
    """Initial standard deviation of the offsets [m]."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: naming the value and what is allowed.
        """
        super().__post_init__()
        if self.scenarios < 1 or self.candidates < 4 or self.generations < 1:
            raise ValueError(
                f"{self.episodes} episodes, {self.candidates} candidates on {self.scenarios} scenarios; "
                "allowed: at least 4 candidates, 1 scenario and the episodes of one generation"
            )

    @property
    def generations(self) -> int:
        """How many the budget allows."""
        return self.episodes // (self.scenarios * self.candidates)


def search(
    folder: Path,
    settings: SearchSettings,
    source: Source,
    reward: Reward,
    tell: Callable[[int, str], None],
    about: dict[str, Any],
) -> AimingPolicy:
    """Search, or go on searching, in a claimed folder.

    Args:
        folder: takes the record of all generations.
        settings: of the search.
        source: flies the episodes.
        reward: judges them.
        tell: called after each generation with (episodes flown, what to tell).
        about: facts for the model card.

    Returns:
        The centre of the last generation as a policy.

    Raises:
        RunFolderError: when the folder's record is not of this search.
    """
    import cma

    random = np.random.default_rng(np.random.SeedSequence(settings.seed))
    options = {
        "bounds": [-1.0, 1.0],
        "popsize": settings.candidates,
        "randn": lambda *shape: random.standard_normal(shape),
        "seed": np.nan,
        "verbose": -9,
        "maxiter": settings.generations,
        "tolfun": 0.0,
        "tolfunhist": 0.0,
        "tolx": 0.0,
    }
    task = settings.task
    begin = [0.0] * (2 * task.unit_count)
    strategy = cma.CMAEvolutionStrategy(begin, settings.sigma_m / task.offset_limit_m, options)
    record = folder / FILE
    generations = json.loads(record.read_text(encoding="utf-8")) if record.exists() else []
    for number in range(settings.generations):
        candidates = strategy.ask()
        if number < len(generations):
            if not np.allclose(candidates, generations[number]["candidates"], atol=1e-12):
                raise run_folder.RunFolderError(f"{record} was not made by this search; name another folder")
        else:
            rewards = _judge(candidates, number, settings, source, reward)
            shown = {"candidates": np.array(candidates).tolist(), "rewards": rewards.tolist()}
            generations.append({**shown, "mean_m": (task.offset_limit_m * strategy.mean).tolist()})
            atomic_file.write_text(record, json.dumps(generations))
            flown = (number + 1) * settings.scenarios * settings.candidates
            tell(flown, f"mean reward {rewards.mean():.3f}, best {rewards.max():.3f}")
        strategy.tell(candidates, [-value for value in generations[number]["rewards"]])
    center = np.clip(strategy.result.xfavorite, -1.0, 1.0) * task.offset_limit_m
    last = {"reward": float(np.mean(generations[-1]["rewards"]))}
    return constant_policy(settings.system, task, center.reshape(-1, 2), {**about, "last_generation": last})


def _judge(
    candidates: list[np.ndarray], generation: int, settings: SearchSettings, source: Source, reward: Reward
) -> np.ndarray:
    """Mean reward of each candidate."""
    begin = generation * settings.scenarios
    stream = (settings.system, Purpose.OFFSET_OPTIMISATION, settings.seed, begin, settings.scenarios)
    scenarios = random_scenarios(*stream)
    task = settings.task
    images = [task.scale_observation(s.debris_position)[1] for s in scenarios]
    offsets = [task.offsets_from_action(candidate, image) for candidate in candidates for image in images]
    results = episodes.fly(source, reward, scenarios * len(candidates), offsets)
    return results.rewards.reshape(len(candidates), len(scenarios)).mean(axis=1)
