"""A trained surrogate: what the capture will come to, from the net at the start of closing. NumPy only.

Its members, models of one kind that were each trained without another part of the data, predict together.
"""

from __future__ import annotations

import functools
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.capture_quality import captured, tight
from tethernet_core.system import System
from tethernet_planner.inference import model_file, net_features, networks
from tethernet_planner.inference.model_file import MadeFor, ModelFileError

KIND = "surrogate"

MODELS = ("rnn", "mlp", "trees")

OUTPUTS = ("log_cqi", "locked_pairs", "log_closing_fuel", "captured_logit")
"""What a network puts out, the first three standardised. Fuel of closing and the probability of capture are our
additions: the 8 MUs spend fuel after the trigger, where the paper's surrogate predicts none."""

_FUEL_FLOOR_KG = 1e-3
"""Added to the fuel before its logarithm is taken: with 4 MUs there is none."""


def log_fuel(fuel_kg: np.ndarray) -> np.ndarray:
    """What the third output stands for, any shape.

    A logarithm, because the fuel of closing reaches from 0.07 kg in good captures to ten times as much in lost ones:
    squared errors in kg are those of the lost ones alone, and a policy chooses among the good ones.

    Args:
        fuel_kg: total of all MUs, start of closing to end [kg].
    """
    return np.log(np.asarray(fuel_kg) + _FUEL_FLOOR_KG)


def _fuel(log: np.ndarray) -> np.ndarray:
    """The fuel [kg] that an output stands for, any shape."""
    return np.maximum(np.exp(np.clip(log, -10.0, 10.0)) - _FUEL_FLOOR_KG, 0.0)


@dataclass(frozen=True)
class PredictionErrors:
    """Error of a prediction on unseen scenarios, true minus predicted, those with a CQI below 20 [P]."""

    cqi_mean: float = 0.0
    cqi_std: float = 0.0
    pairs_mean: float = 0.0
    pairs_std: float = 0.0


NOISES = ("split", "paper", "none")
"""Gaussian errors that learning adds to predictions. ``paper``: one for all; ``split``: one where the predicted CQI is
that of a capture and one where it is not, because failed captures are predicted far worse; ``none``."""


@dataclass(frozen=True)
class Predictions:
    """Predictions for n nets; all arrays have shape (n,)."""

    cqi: np.ndarray
    """Settled Capture Quality Index [-]."""
    locked_pairs: np.ndarray
    """Not rounded."""
    closing_fuel_kg: np.ndarray
    """Total of all MUs, start of closing to end [kg]."""
    capture_probability: np.ndarray
    """Calibrated, 0 to 1."""

    def captured(self, system: System) -> np.ndarray:
        """The paper's decision: predicted CQI and rounded pairs against the system's thresholds."""
        return captured(self.cqi, np.round(self.locked_pairs), system)


@dataclass(frozen=True)
class Surrogate:
    """Models with their scaling and their errors."""

    model: str
    """One of MODELS."""
    made_for: MadeFor
    max_locked_pairs: int
    """Of the system."""
    arrays: dict[str, np.ndarray]
    """``k.NAME``: those of member k, see :mod:`.networks`; ``input_mean``, ``input_scale``, shape (inputs,);
    ``nodes``, those of the net that are seen, see :class:`.net_features.Seen`; ``sectors``, see
    :func:`.net_features.sector_nodes`;
    ``output_mean``, ``output_scale``, shape (3,); ``calibration``, slope and shift of the logit, shape (2,)."""
    errors: dict[str, PredictionErrors]
    """``all``; ``near``, where the predicted CQI is below the threshold; ``far``, where it is not."""
    about: dict[str, Any]
    """Data, training, scores: facts for the model card."""

    @property
    def mus(self) -> int:
        """Number of units."""
        return self.made_for.units

    def check_system(self, system: System) -> None:
        """Make sure that the surrogate was made for this system.

        Raises:
            ModelFileError: when it was not; names both.
        """
        self.made_for.check(system, KIND)

    def predict_many(self, rows: np.ndarray) -> Predictions:
        """Predict.

        Args:
            rows: features as of :func:`.net_features.features`, shape (n, inputs).

        Raises:
            ValueError: for a wrong shape.
        """
        rows = np.asarray(rows, np.float32)
        expected = len(self.arrays["input_mean"])
        if rows.ndim != 2 or rows.shape[1] != expected:
            raise ValueError(f"features of shape {rows.shape}; allowed: (n, {expected}) for {self.made_for.system}")
        arrays = self.arrays
        inputs = (rows - arrays["input_mean"]) / arrays["input_scale"]
        raw = np.stack([forward(self.model, self.arrays["sectors"], member, inputs) for member in self.members]).astype(
            float
        )
        values = raw[:, :, :3].mean(axis=0) * arrays["output_scale"] + arrays["output_mean"]
        return Predictions(
            np.exp(np.clip(values[:, 0], -10.0, 10.0)),
            np.clip(values[:, 1], 0.0, self.max_locked_pairs),
            _fuel(values[:, 2]),
            probability(raw[:, :, 3], arrays["calibration"]).mean(axis=0),
        )

    @functools.cached_property
    def members(self) -> list[networks.Arrays]:
        """The arrays of each member."""
        numbers = sorted({int(name.partition(".")[0]) for name in self.arrays if "." in name})
        return [
            {name.partition(".")[2]: array for name, array in self.arrays.items() if name.startswith(f"{number}.")}
            for number in numbers
        ]

    def draw_errors(
        self, predicted: Predictions, draws: np.ndarray, noise: str, system: System
    ) -> tuple[np.ndarray, np.ndarray]:
        """Errors to add to predictions.

        Args:
            predicted: n predictions.
            draws: of the standard normal distribution, shape (n, 2).
            noise: one of NOISES.
            system: gives the threshold between near and far.

        Returns:
            For CQI and locked pairs, each of shape (n,).

        Raises:
            ValueError: for an unknown noise.
        """
        if noise not in NOISES:
            raise ValueError(f"noise {noise!r}; allowed: {', '.join(NOISES)}")
        if noise == "none":
            return np.zeros(len(draws)), np.zeros(len(draws))
        near, far = (self.errors["near"], self.errors["far"]) if noise == "split" else (self.errors["all"],) * 2
        is_near = tight(predicted.cqi, system)
        cqi = [error.cqi_mean + error.cqi_std * draws[:, 0] for error in (near, far)]
        pairs = [error.pairs_mean + error.pairs_std * draws[:, 1] for error in (near, far)]
        return np.where(is_near, *cqi), np.where(is_near, *pairs)

    def save(self, path: Path) -> None:
        """Write the surrogate to a file; see :mod:`.model_file`."""
        about = {
            **self.about,
            "model": self.model,
            "max_locked_pairs": self.max_locked_pairs,
            **self.made_for.as_json(),
            "errors": {part: asdict(error) for part, error in self.errors.items()},
        }
        model_file.write(path, KIND, self.arrays, about)

    @classmethod
    def load(cls, path: Path) -> Surrogate:
        """Read a surrogate from a file.

        Raises:
            ModelFileError: when it is none, or is damaged.
        """
        arrays, about = model_file.read(path, KIND)
        made_for, pairs = MadeFor.from_json(about, path), about.get("max_locked_pairs")
        if about.get("model") not in MODELS or not isinstance(pairs, int) or pairs < 0:
            found = f"model {about.get('model')!r}, at most {pairs!r} locked pairs"
            raise ModelFileError(f"{path}: {found}; allowed: {', '.join(MODELS)} and a whole number of pairs")
        model_file.check_shapes(path, arrays, {"nodes": (None,), "sectors": (None, None)})
        nodes = len(arrays["nodes"]) + made_for.units
        inputs = (net_features.NUMBERS * nodes,)
        for name, beyond in (("nodes", None), ("sectors", nodes + 1)):
            numbers = arrays[name]
            if numbers.dtype.kind not in "iu" or not ((numbers >= 0) & (beyond is None or numbers < beyond)).all():
                raise ModelFileError(f"{path}: array {name!r} does not hold numbers of nodes")
        shapes = {"input_mean": inputs, "input_scale": inputs, "output_mean": (3,), "output_scale": (3,)}
        model_file.check_shapes(path, arrays, {**shapes, "calibration": (2,)})
        try:
            errors = {part: PredictionErrors(**about["errors"][part]) for part in ("all", "near", "far")}
            surrogate = cls(about["model"], made_for, pairs, arrays, errors, about)
            if not surrogate.members:
                raise ValueError("it has no members; train it again with tethernet train surrogate")
            surrogate.predict_many(np.zeros((1, *inputs)))
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise ModelFileError(f"{path} does not make a {about['model']}: {error}") from error
        return surrogate


def seen_arrays(system: System) -> dict[str, np.ndarray]:
    """What a surrogate's file holds of what it sees of its system: ``nodes`` and ``sectors``."""
    return {"nodes": net_features.seen(system).nodes, "sectors": net_features.sector_nodes(system)}


def probability(logit: np.ndarray, calibration: np.ndarray) -> np.ndarray:
    """The calibrated probability of capture, any shape; ``calibration`` is slope and shift of the logit."""
    slope, shift = calibration
    return 1.0 / (1.0 + np.exp(-np.clip(slope * logit + shift, -50.0, 50.0)))


def forward(model: str, sectors: np.ndarray, arrays: networks.Arrays, inputs: np.ndarray) -> np.ndarray:
    """A model's raw outputs.

    Args:
        model: one of MODELS.
        sectors: see :func:`.net_features.sector_nodes`.
        arrays: the model's.
        inputs: standardised features, shape (n, inputs).

    Returns:
        Shape (n, 4), see OUTPUTS.
    """
    if model == "rnn":
        return networks.recurrent(arrays, networks.sector_inputs(inputs, sectors))
    if model == "mlp":
        return networks.dense(arrays, inputs)
    return networks.boosted_trees(arrays, inputs)
