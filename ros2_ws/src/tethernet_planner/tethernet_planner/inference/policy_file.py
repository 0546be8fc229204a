"""A trained policy: where the MUs shall aim, given where the debris is. NumPy only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tethernet_core.layout import design, nominal_aiming_points
from tethernet_planner.inference import model_file, networks, task
from tethernet_planner.inference.model_file import ModelFileError

KIND = "policy"


class OutsideTrainingError(ValueError):
    """The debris is where the policy was never trained."""


@dataclass(frozen=True)
class AimingPolicy:
    """The deterministic part of a trained policy: a dense network with tanh, its mean taken as it is."""

    mus: int
    arrays: dict[str, np.ndarray]
    """``weight_k``, ``bias_k``; see :func:`.networks.dense`. Input and output as of :mod:`.task`."""
    symmetry: str = "none"
    """One of :data:`.task.SYMMETRIES`."""
    about: dict[str, Any] = field(default_factory=dict)
    """Method, seed, commit, scores: facts for the model card."""

    def offsets(self, debris_position: Sequence[float]) -> npt.NDArray[np.float64]:
        """Offsets of the aiming points from the nominal ones.

        Args:
            debris_position: at launch [m].

        Returns:
            On the grid of 0.1 m, within 5 m [m], shape (M, 2).

        Raises:
            OutsideTrainingError: naming the trained bounds.
        """
        if not task.inside(debris_position):
            position = ", ".join(f"{value:g}" for value in debris_position)
            raise OutsideTrainingError(
                f"debris at ({position}) m; trained: x and y from {task.DEBRIS_LOW_M[0]:g} to "
                f"{task.DEBRIS_HIGH_M[0]:g}, z from {task.DEBRIS_LOW_M[2]:g} to {task.DEBRIS_HIGH_M[2]:g} m"
            )
        observation, image = task.scale_observation(debris_position, self.symmetry)
        return task.offsets_from_action(networks.dense(self.arrays, observation[None])[0], image)

    def aiming_points(self, mu_count: int, debris_position: Sequence[float]) -> list[tuple[float, float, float]]:
        """Aiming points [m] of all MUs, MU 1 first: a policy in the sense of :mod:`tethernet_planner.policies`.

        Raises:
            ModelFileError: when the policy was made for another number of MUs.
            OutsideTrainingError: see :meth:`offsets`.
        """
        self.check_design(mu_count)
        nominal = nominal_aiming_points(mu_count, debris_position)
        offsets = self.offsets(debris_position).tolist()
        return [(x + dx, y + dy, z) for (x, y, z), (dx, dy) in zip(nominal, offsets, strict=True)]

    def check_design(self, mu_count: int) -> None:
        """Make sure that the policy was made for this number of MUs.

        Raises:
            ModelFileError: when it was not.
        """
        if mu_count != self.mus:
            raise ModelFileError(f"this policy was made for {self.mus} MUs, not for {mu_count}")

    def save(self, path: Path) -> None:
        """Write the policy to a file; see :mod:`.model_file`."""
        bounds = {
            "debris_low_m": task.DEBRIS_LOW_M,
            "debris_high_m": task.DEBRIS_HIGH_M,
            "offset_limit_m": task.OFFSET_LIMIT_M,
            "step_m": task.STEP_M,
        }
        model_file.write(path, KIND, self.arrays, {**self.about, **bounds, "mus": self.mus, "symmetry": self.symmetry})

    @classmethod
    def load(cls, path: Path) -> AimingPolicy:
        """Read a policy from a file.

        Raises:
            ModelFileError: when it is none, is damaged, or was trained for other bounds than those of :mod:`.task`.
        """
        arrays, about = model_file.read(path, KIND)
        if about.get("mus") not in (4, 8) or about.get("symmetry") not in task.SYMMETRIES:
            found = f"{about.get('mus')!r} MUs, symmetry {about.get('symmetry')!r}"
            raise ModelFileError(f"{path}: {found}; allowed: 4 or 8 MUs, {', '.join(task.SYMMETRIES)}")
        bounds = [about.get(name) for name in ("debris_low_m", "debris_high_m", "offset_limit_m", "step_m")]
        ours = [list(task.DEBRIS_LOW_M), list(task.DEBRIS_HIGH_M), task.OFFSET_LIMIT_M, task.STEP_M]
        if bounds != ours:
            raise ModelFileError(f"{path}: trained for bounds {bounds}; allowed: {ours}")
        outputs, layers = 2 * design(about["mus"]).mu_count, networks.dense_layers(arrays)
        if not layers:
            raise ModelFileError(f"{path}: has no layers; allowed: weight_0, bias_0, ...")
        for k in range(layers):
            inputs = 3 if k == 0 else arrays[f"weight_{k - 1}"].shape[0]
            width = outputs if k == layers - 1 else None
            model_file.check_shapes(path, arrays, {f"weight_{k}": (width, inputs)})
            model_file.check_shapes(path, arrays, {f"bias_{k}": (arrays[f"weight_{k}"].shape[0],)})
        return cls(about["mus"], arrays, about["symmetry"], about)


def constant_policy(offsets: np.ndarray, symmetry: str = "none", about: dict[str, Any] | None = None) -> AimingPolicy:
    """A policy that always gives the same offsets.

    Args:
        offsets: [m], shape (M, 2), within 5 m.
        symmetry: one of :data:`.task.SYMMETRIES`; the offsets are those for the canonical quarter.
        about: facts for the model card.
    """
    flat = np.asarray(offsets, float).ravel() / task.OFFSET_LIMIT_M
    arrays = {"weight_0": np.zeros((len(flat), 3), np.float32), "bias_0": flat.astype(np.float32)}
    return AimingPolicy(len(flat) // 2, arrays, symmetry, about or {})
