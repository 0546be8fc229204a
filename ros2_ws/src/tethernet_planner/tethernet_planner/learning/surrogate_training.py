"""What all surrogates are trained with: split, scaling, mirrored copies, calibration of the probability."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .data_set import Captures
from .net_features import image_of_features
from .surrogate_file import PredictionErrors, Surrogate, forward, log_fuel
from .symmetry import GROUP

_VALIDATION = 0.1
"""Share of the training scenarios kept apart: chooses when to stop, calibrates, compares the models."""


@dataclass(frozen=True)
class Material:
    """Training and validation data, scaled; n rows for training, v for validation."""

    mus: int
    inputs: np.ndarray  # (n, 990 or 1014)
    """Standardised features."""
    targets: np.ndarray  # (n, 4)
    """log CQI, locked pairs, log of the fuel of closing, standardised; captured as 0 or 1."""
    held_inputs: np.ndarray  # (v, 990 or 1014)
    held_targets: np.ndarray  # (v, 4)
    scaling: dict[str, np.ndarray]
    """``input_mean``, ``input_scale``, ``output_mean``, ``output_scale`` of the surrogate's file."""

    def mirrored(self, which: np.ndarray) -> np.ndarray:
        """The training inputs in an image under the symmetries of the scene.

        Args:
            which: number of the symmetry for each row, shape (n,).

        Returns:
            Shape (n, 990 or 1014).
        """
        mean, scale = self.scaling["input_mean"], self.scaling["input_scale"]
        rows = self.inputs * scale + mean
        for number, mirror in enumerate(GROUP):
            rows[which == number] = image_of_features(mirror, rows[which == number], self.mus)
        return ((rows - mean) / scale).astype(np.float32)


def prepare(captures: Captures, seed: int) -> Material:
    """Split and scale.

    Args:
        captures: the training scenarios.
        seed: of the split.

    Raises:
        ValueError: when all or none of them were captured.
    """
    if captures.captured.all() or not captures.captured.any():
        kind = "captured" if captures.captured.all() else "failed"
        raise ValueError(f"all {len(captures.captured)} training scenarios {kind}; allowed: some of both")
    order = np.random.default_rng(seed).permutation(len(captures.captured))
    held = order[: max(2, round(_VALIDATION * len(order)))]
    kept = order[len(held) :]
    outputs = np.stack([np.log(captures.cqi), captures.locked_pairs, log_fuel(captures.closing_fuel_kg)], axis=1)
    images = np.concatenate([image_of_features(mirror, captures.features[kept], captures.mus) for mirror in GROUP])
    scaling = {
        "input_mean": images.mean(axis=0, dtype=float),
        "input_scale": np.maximum(images.std(axis=0, dtype=float), 1e-3),
        "output_mean": outputs[kept].mean(axis=0),
        "output_scale": np.where(outputs[kept].std(axis=0) > 1e-6, outputs[kept].std(axis=0), 1.0),
    }
    scaling = {name: values.astype(np.float32) for name, values in scaling.items()}
    inputs = ((captures.features - scaling["input_mean"]) / scaling["input_scale"]).astype(np.float32)
    scaled = (outputs - scaling["output_mean"]) / scaling["output_scale"]
    targets = np.hstack([scaled, captures.captured[:, None]]).astype(np.float32)
    return Material(captures.mus, inputs[kept], targets[kept], inputs[held], targets[held], scaling)


def finish(model: str, arrays: dict[str, np.ndarray], material: Material, about: dict) -> Surrogate:
    """Calibrate a trained model on the validation data and make it a surrogate, its errors not known yet."""
    logit = forward(model, material.mus, arrays, material.held_inputs)[:, 3]
    whole = {**arrays, **material.scaling, "calibration": _calibration(logit, material.held_targets[:, 3])}
    nothing = dict.fromkeys(("all", "near", "far"), PredictionErrors())
    return Surrogate(model, material.mus, whole, nothing, about)


def _calibration(logit: np.ndarray, captured: np.ndarray) -> np.ndarray:
    """Slope and shift of the logit that fit best (Platt), by Newton's method on the log-likelihood with a weak pull
    towards slope 1 and shift 0.
    """
    seen = np.stack([np.clip(logit, -30.0, 30.0), np.ones(len(logit))], axis=1)
    best, pull = np.array([1.0, 0.0]), 1.0
    for _ in range(50):
        probability = 1.0 / (1.0 + np.exp(-np.clip(seen @ best, -50.0, 50.0)))
        slope = seen.T @ (probability - captured) + pull * (best - [1.0, 0.0])
        curvature = (seen * (probability * (1 - probability))[:, None]).T @ seen + pull * np.eye(2)
        best = best - np.linalg.solve(curvature, slope)
    return best.astype(np.float32)
