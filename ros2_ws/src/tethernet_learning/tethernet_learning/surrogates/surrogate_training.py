"""What all surrogates are trained with: folds, scaling, mirrored copies, calibration of the probability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tethernet_core.system import System
from tethernet_learning.data.data_set import Captures
from tethernet_learning.symmetries import seen_group
from tethernet_planner.inference.model_file import MadeFor
from tethernet_planner.inference.net_features import image_of_features
from tethernet_planner.inference.surrogate_file import (
    PredictionErrors,
    Surrogate,
    forward,
    log_fuel,
    probability,
    seen_arrays,
)
from tethernet_planner.inference.symmetry import Symmetry

FOLDS = 4
"""Parts of the training scenarios. Each member of a surrogate is trained without one of them, which tells when to stop;
what the members say of the parts that they have not seen calibrates and compares the models."""


@dataclass(frozen=True)
class Material:
    """What one member is trained with, scaled: n rows to learn from, v held back."""

    system: System
    images: tuple[Symmetry, ...]
    """Maps under which a mission and its image are the same, the identity first."""
    inputs: np.ndarray  # (n, inputs)
    """Standardised features."""
    targets: np.ndarray  # (n, 4)
    """log CQI, locked pairs, log of the fuel of closing, standardised; captured as 0 or 1."""
    held_inputs: np.ndarray  # (v, inputs)
    held_targets: np.ndarray  # (v, 4)
    scaling: dict[str, np.ndarray]
    """``input_mean``, ``input_scale``, ``output_mean``, ``output_scale`` of the surrogate's file."""

    def mirrored(self, which: np.ndarray) -> np.ndarray:
        """The training inputs in an image under the symmetries of the scene.

        Args:
            which: number of the symmetry for each row, shape (n,).

        Returns:
            Shape (n, inputs).
        """
        mean, scale = self.scaling["input_mean"], self.scaling["input_scale"]
        rows = self.inputs * scale + mean
        for number, mirror in enumerate(self.images):
            rows[which == number] = image_of_features(mirror, rows[which == number], self.system)
        return ((rows - mean) / scale).astype(np.float32)


def prepare(captures: Captures, seed: int) -> list[Material]:
    """Split and scale.

    Args:
        captures: the training scenarios.
        seed: of the split.

    Returns:
        One for each fold, all scaled alike.

    Raises:
        ValueError: when all or none of them were captured, or all or none of what a member would learn from.
    """
    if captures.captured.all() or not captures.captured.any():
        kind = "captured" if captures.captured.all() else "failed"
        raise ValueError(f"all {len(captures.captured)} training scenarios {kind}; allowed: some of both")
    outputs = np.stack([np.log(captures.cqi), captures.locked_pairs, log_fuel(captures.closing_fuel_kg)], axis=1)
    group = seen_group(captures.system)
    images = np.concatenate([image_of_features(mirror, captures.features, captures.system) for mirror in group])
    scaling = {
        "input_mean": images.mean(axis=0, dtype=float),
        "input_scale": np.maximum(images.std(axis=0, dtype=float), 1e-3),
        "output_mean": outputs.mean(axis=0),
        "output_scale": np.where(outputs.std(axis=0) > 1e-6, outputs.std(axis=0), 1.0),
    }
    scaling = {name: values.astype(np.float32) for name, values in scaling.items()}
    inputs = ((captures.features - scaling["input_mean"]) / scaling["input_scale"]).astype(np.float32)
    scaled = (outputs - scaling["output_mean"]) / scaling["output_scale"]
    targets = np.hstack([scaled, captures.captured[:, None]]).astype(np.float32)
    part = np.random.default_rng(seed).permutation(len(targets)) % FOLDS
    for f in range(FOLDS):
        if not 0.0 < captures.captured[part != f].mean() < 1.0:
            raise ValueError(
                f"too few of the {len(part)} training scenarios in which closing began captured or failed: without one "
                f"of {FOLDS} parts none is left; allowed: some of both in the rest, so make more scenarios"
            )
    return [
        Material(
            captures.system, group, inputs[part != f], targets[part != f], inputs[part == f], targets[part == f],
            scaling,
        )
        for f in range(FOLDS)
    ]  # fmt: skip


def finish(
    model: str, members: list[dict[str, np.ndarray]], materials: list[Material], about: dict[str, Any]
) -> Surrogate:
    """Make members a surrogate, calibrated on what each of them has not seen; its errors are not known yet.

    Args:
        model: rnn, mlp or trees.
        members: arrays of the trained members.
        materials: what each of them was trained with.
        about: facts for the model card; ``validation_brier``, by which models are compared, is added.
    """
    system = materials[0].system
    seen = seen_arrays(system)
    logits, truths = [], []
    for arrays, material in zip(members, materials, strict=True):
        logits.append(forward(model, seen["sectors"], arrays, material.held_inputs)[:, 3].astype(float))
        truths.append(material.held_targets[:, 3])
    logit, truth = np.concatenate(logits), np.concatenate(truths)
    calibration = _calibration(logit, truth)
    brier = float(((probability(logit, calibration) - truth) ** 2).mean())
    named = {f"{k}.{name}": array for k, arrays in enumerate(members) for name, array in arrays.items()}
    nothing = dict.fromkeys(("all", "near", "far"), PredictionErrors())
    whole = {**named, **materials[0].scaling, "calibration": calibration, **seen}
    facts = {**about, "members": len(members), "validation_brier": brier}
    return Surrogate(model, MadeFor.of(system), system.closing.max_locked_pairs, whole, nothing, facts)


def _calibration(logit: np.ndarray, captured: np.ndarray) -> np.ndarray:
    """Slope and shift of the logit that fit best (Platt): the most likely ones, with a weak pull towards slope 1 and
    shift 0.

    Raises:
        RuntimeError: they are not found.
    """
    from scipy.optimize import minimize

    seen = np.stack([logit, np.ones(len(logit))], axis=1)
    begin, pull = np.array([1.0, 0.0]), 1.0

    def cost(line: np.ndarray) -> float:
        odds = seen @ line
        return float((np.logaddexp(0.0, odds) - captured * odds).sum() + 0.5 * pull * ((line - begin) ** 2).sum())

    def slope(line: np.ndarray) -> np.ndarray:
        return seen.T @ (probability(logit, line) - captured) + pull * (line - begin)

    def curvature(line: np.ndarray) -> np.ndarray:
        told = probability(logit, line)
        return (seen * (told * (1.0 - told))[:, None]).T @ seen + pull * np.eye(2)

    # Newton's method alone leaves for ever where a sure model is wrong now and then: its curvature is next to nothing.
    found = minimize(cost, begin, jac=slope, hess=curvature, method="trust-exact")
    if not found.success:
        raise RuntimeError(f"the probability of capture cannot be calibrated: {found.message}")
    return np.asarray(found.x, np.float32)
