"""A search for one set of offsets for all debris positions: alone what a policy must beat, on top of a trained policy
what makes it save where the numbers that nobody has measured are other than described.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core import atomic_file
from tethernet_learning import assumed_numbers, run_folder
from tethernet_learning.policies import episodes
from tethernet_learning.policies.capture_sources import Source
from tethernet_learning.policies.episode_settings import EpisodeSettings
from tethernet_learning.policies.reward import Reward
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose
from tethernet_planner.inference.policy_file import AimingPolicy, constant_policy, moved_policy
from tethernet_planner.inference.task import Task

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
    symmetric: bool = False
    """Search only among offsets that all images of the system leave as they are: fewer numbers."""
    worst: float = 1.0
    """Judge a candidate by this share of the groups of scenarios with the same assumed numbers, those in which it gains
    least over the nominal points: its conditional value at risk (Rockafellar & Uryasev 2000, J. Risk 2(3)); 1: by the
    mean of all."""

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
        if not 0.0 < self.worst <= 1.0:
            raise ValueError(f"worst {self.worst}; allowed: above 0, up to 1")
        self.check_ends("scenarios", self.scenarios)

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
    first: AimingPolicy | None = None,
) -> AimingPolicy:
    """Search, or go on searching, in a claimed folder.

    Args:
        folder: takes the record of all generations.
        settings: of the search.
        source: flies the episodes.
        reward: judges them.
        tell: called after each generation with (episodes flown, what to tell).
        about: facts for the model card.
        first: policy that the offsets come on top of; None: the nominal points.

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
    searched = searched_directions(task, settings.symmetric)
    strategy = cma.CMAEvolutionStrategy([0.0] * len(searched), settings.sigma_m / task.offset_limit_m, options)
    record = folder / FILE
    generations = json.loads(record.read_text(encoding="utf-8")) if record.exists() else []
    for number in range(settings.generations):
        candidates = strategy.ask()
        if number < len(generations):
            if not np.allclose(candidates, generations[number]["candidates"], atol=1e-12):
                raise run_folder.RunFolderError(f"{record} was not made by this search; name another folder")
        else:
            rewards = _judge(np.array(candidates) @ searched, number, settings, source, reward, first)
            shown = {"candidates": np.array(candidates).tolist(), "rewards": rewards.tolist()}
            generations.append({**shown, "mean_m": (task.offset_limit_m * strategy.mean @ searched).tolist()})
            atomic_file.write_text(record, json.dumps(generations))
            flown = (number + 1) * settings.scenarios * settings.candidates
            tell(flown, f"mean reward {rewards.mean():.3f}, best {rewards.max():.3f}")
        strategy.tell(candidates, [-value for value in generations[number]["rewards"]])
    center = np.clip(strategy.result.xfavorite @ searched, -1.0, 1.0) * task.offset_limit_m
    last = {"reward": float(np.mean(generations[-1]["rewards"]))}
    about = {**about, "last_generation": last}
    if first:
        return moved_policy(first, center.reshape(-1, 2), about)
    return constant_policy(settings.system, task, center.reshape(-1, 2), about)


def searched_directions(task: Task, symmetric: bool) -> np.ndarray:
    """Orthonormal directions of the offsets that are searched, shape (., 2 M)."""
    every = np.eye(2 * task.unit_count)
    if not symmetric:
        return every
    mean = np.mean([[image.offsets(one.reshape(-1, 2)).ravel() for one in every] for image in task.images], axis=0)
    kept, directions = np.linalg.eigh((mean + mean.T) / 2.0)
    return directions.T[kept > 0.5]  # 1 for what all images leave as it is, else 0


def _judge(
    candidates: np.ndarray,
    generation: int,
    settings: SearchSettings,
    source: Source,
    reward: Reward,
    first: AimingPolicy | None,
) -> np.ndarray:
    """What each candidate, scaled to [-1, 1], is worth."""
    begin = generation * settings.scenarios
    stream = (settings.system, Purpose.OFFSET_OPTIMISATION, settings.seed, begin, settings.scenarios)
    scenarios = random_scenarios(*stream)
    task = settings.task
    images = [task.scale_observation(s.debris_position)[1] for s in scenarios]
    begun = [first.action(s.debris_position) if first else np.zeros(2 * task.unit_count) for s in scenarios]
    offsets = [
        task.offsets_from_action(candidate + action, image)
        for candidate in candidates
        for action, image in zip(begun, images, strict=True)
    ]
    rows = len(candidates)
    if settings.worst < 1.0:
        offsets += [np.zeros((task.unit_count, 2))] * len(scenarios)
        rows += 1
    results = episodes.fly(source, reward, scenarios * rows, offsets)
    rewards = results.rewards.reshape(rows, len(scenarios))
    if settings.worst == 1.0:
        return rewards.mean(axis=1)
    gains = rewards[:-1] - rewards[-1]
    members = [numbers for numbers, _ in assumed_numbers.groups(scenarios)]
    of_groups = np.sort([gains[:, numbers].mean(axis=1) for numbers in members], axis=0)
    return of_groups[: math.ceil(settings.worst * len(members))].mean(axis=0)
