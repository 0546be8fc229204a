"""A trained policy: where the units shall aim, given where the debris is. NumPy only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.aiming import nominal_aiming_points
from tethernet_core.mission import Point
from tethernet_core.system import System
from tethernet_planner.inference import model_file, networks
from tethernet_planner.inference.model_file import MadeFor, ModelFileError
from tethernet_planner.inference.task import Task

KIND = "policy"


class OutsideTrainingError(ValueError):
    """The debris is where the policy was never trained."""


@dataclass(frozen=True)
class AimingPolicy:
    """The deterministic part of a trained policy: a dense network with tanh, its mean taken as it is."""

    made_for: MadeFor
    task: Task
    """Where the debris was in training, how far the units may be sent from their nominal points, and under which images
    one debris position stands for others."""
    arrays: dict[str, np.ndarray]
    """``weight_k``, ``bias_k``; see :func:`.networks.dense`. Input and output as of :mod:`.task`."""
    about: dict[str, Any] = field(default_factory=dict)
    """Method, seed, commit, scores: facts for the model card."""

    @property
    def mus(self) -> int:
        """Number of units."""
        return self.made_for.units

    def offsets(self, debris_position: Sequence[float]) -> np.ndarray:
        """Offsets of the aiming points from the nominal ones.

        Args:
            debris_position: at launch [m].

        Returns:
            On the task's grid, within its limit [m], shape (M, 2).

        Raises:
            OutsideTrainingError: naming the trained bounds.
        """
        if not self.task.inside(debris_position):
            position = ", ".join(f"{value:g}" for value in debris_position)
            raise OutsideTrainingError(f"debris at ({position}) m; trained: {self.task.bounds_text()}")
        _, image = self.task.scale_observation(debris_position)
        return self.task.offsets_from_action(self.action(debris_position), image)

    def action(self, debris_position: Sequence[float]) -> np.ndarray:
        """What the network answers for the image of a position [m] that stands for all, see :mod:`.task`: (2 M,)."""
        observation, _ = self.task.scale_observation(debris_position)
        return networks.dense(self.arrays, observation[None])[0]

    def aiming_points(self, system: System, debris_position: Sequence[float]) -> list[Point]:
        """Aiming points [m] of all units, unit 1 first: a policy in the sense of :mod:`tethernet_planner.policies`.

        Raises:
            ModelFileError: when the policy was made for another system.
            OutsideTrainingError: see :meth:`offsets`.
        """
        self.check_system(system)
        nominal = nominal_aiming_points(system, debris_position)
        offsets = self.offsets(debris_position).tolist()
        return [(x + dx, y + dy, z) for (x, y, z), (dx, dy) in zip(nominal, offsets, strict=True)]

    def check_system(self, system: System) -> None:
        """Make sure that the policy was made for this system.

        Raises:
            ModelFileError: when it was not; names both.
        """
        self.made_for.check(system, KIND)

    def save(self, path: Path) -> None:
        """Write the policy to a file; see :mod:`.model_file`."""
        about = {**self.about, **self.task.as_json(), **self.made_for.as_json()}
        model_file.write(path, KIND, self.arrays, about)

    @classmethod
    def load(cls, path: Path) -> AimingPolicy:
        """Read a policy from a file.

        Raises:
            ModelFileError: when it is none or is damaged.
        """
        arrays, about = model_file.read(path, KIND)
        made_for = MadeFor.from_json(about, path)
        try:
            task = Task.from_json(made_for.units, about)
        except (KeyError, TypeError, ValueError) as error:
            raise ModelFileError(f"{path} does not say what it was trained for: {error}") from error
        outputs, layers = 2 * made_for.units, networks.dense_layers(arrays)
        if not layers:
            raise ModelFileError(f"{path}: has no layers; allowed: weight_0, bias_0, ...")
        for k in range(layers):
            inputs = 3 if k == 0 else arrays[f"weight_{k - 1}"].shape[0]
            width = outputs if k == layers - 1 else None
            model_file.check_shapes(path, arrays, {f"weight_{k}": (width, inputs)})
            model_file.check_shapes(path, arrays, {f"bias_{k}": (arrays[f"weight_{k}"].shape[0],)})
        return cls(made_for, task, arrays, about)


def constant_policy(
    system: System, task: Task, offsets: np.ndarray, about: dict[str, Any] | None = None
) -> AimingPolicy:
    """A policy that always gives the same offsets.

    Args:
        system: that it is for.
        task: its bounds and images.
        offsets: [m], shape (M, 2), within the task's limit; those for the one image that stands for all.
        about: facts for the model card.
    """
    flat = np.asarray(offsets, float).ravel() / task.offset_limit_m
    arrays = {"weight_0": np.zeros((len(flat), 3), np.float32), "bias_0": flat.astype(np.float32)}
    return AimingPolicy(MadeFor.of(system), task, arrays, about or {})


def moved_policy(policy: AimingPolicy, offsets: np.ndarray, about: dict[str, Any]) -> AimingPolicy:
    """A policy that gives the same offsets more than another one.

    Args:
        policy: the other one.
        offsets: [m], shape (M, 2); those for the one image that stands for all.
        about: facts for the model card.
    """
    last = f"bias_{networks.dense_layers(policy.arrays) - 1}"
    moved = policy.arrays[last] + np.asarray(offsets, float).ravel() / policy.task.offset_limit_m
    return AimingPolicy(policy.made_for, policy.task, {**policy.arrays, last: moved.astype(np.float32)}, about)
