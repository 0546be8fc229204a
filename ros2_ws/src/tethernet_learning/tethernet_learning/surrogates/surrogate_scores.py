"""How good a surrogate is on scenarios that it has never seen."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np

from tethernet_core.capture_quality import tight
from tethernet_learning.data.data_set import Captures
from tethernet_learning.flown import CQI_LIMIT
from tethernet_planner.inference.surrogate_file import PredictionErrors, Predictions, Surrogate

_BINS = 10
"""Of the calibration."""


def with_errors(surrogate: Surrogate, test: Captures) -> Surrogate:
    """The surrogate with its errors on unseen scenarios: what learning draws its noise from."""
    predicted = surrogate.predict_many(test.features)
    inside = test.cqi < CQI_LIMIT
    near = tight(predicted.cqi, test.system)
    parts = {"all": inside, "near": inside & near, "far": inside & ~near}
    errors = {part: _errors(predicted, test, chosen) for part, chosen in parts.items()}
    return dataclasses.replace(surrogate, errors=errors)


def _errors(predicted: Predictions, test: Captures, chosen: np.ndarray) -> PredictionErrors:
    if not chosen.any():
        return PredictionErrors()
    cqi = (test.cqi - predicted.cqi)[chosen]
    pairs = (test.locked_pairs - predicted.locked_pairs)[chosen]
    return PredictionErrors(*(float(value) for value in (cqi.mean(), cqi.std(), pairs.mean(), pairs.std())))


def scores(surrogate: Surrogate, test: Captures) -> dict[str, Any]:
    """Scores as plain numbers.

    Args:
        surrogate: to be judged.
        test: scenarios that it has never seen.

    Returns:
        ``right``: share of the scenarios with closing begun that are rightly told captured or not by the predicted CQI
        and locked pairs [P], with its 95 % interval (Wilson); ``balanced``: mean of the shares among captured and
        failed ones; the same by the probability; ``all``: the same of all unseen scenarios, where those in which
        closing never began count as told "not captured" without asking the surrogate, as learning and the assessor do;
        ``brier`` and ``calibration_error`` of the probability; ``calibration``: its bins (predicted,
        observed, count); errors of CQI (below 20), locked pairs and fuel; ``always_captured``: the share that a model
        which always says "captured" tells rightly, of the same scenarios; in ``all`` too, where it is asked as seldom
        as the surrogate.
    """
    predicted = surrogate.predict_many(test.features)
    probability, true = predicted.capture_probability, test.captured
    said, likely = predicted.captured(test.system), probability > 0.5
    right = said == true
    always = _with_those_never_closed(np.ones_like(true), test)
    bins = _calibration(probability, true)
    inside = test.cqi < CQI_LIMIT
    every = _errors(predicted, test, inside)
    fuel_error = test.closing_fuel_kg - predicted.closing_fuel_kg
    return {
        "all": {
            **_with_those_never_closed(said, test),
            "always_captured": always["right"],
            "always_captured_balanced": always["balanced"],
        },
        "scenarios": len(true),
        "failures": int((~true).sum()),
        "always_captured": float(true.mean()),
        "right": float(right.mean()),
        "right_95": _wilson(int(right.sum()), len(right)),
        "balanced": _balanced(said, true),
        "right_by_probability": float((likely == true).mean()),
        "balanced_by_probability": _balanced(likely, true),
        "brier": float(np.mean((probability - true) ** 2)),
        "calibration_error": float(sum(n * abs(p - o) for p, o, n in bins) / len(true)),
        "calibration": bins,
        "cqi_error_mean": every.cqi_mean,
        "cqi_error_std": every.cqi_std,
        "cqi_error_median": float(np.median(np.abs(test.cqi - predicted.cqi))),
        "pairs_error_mean": every.pairs_mean,
        "pairs_error_std": every.pairs_std,
        "pairs_right": float((np.round(predicted.locked_pairs) == test.locked_pairs).mean()),
        "closing_fuel_error_std_kg": float(fuel_error.std()),
        "closing_fuel_error_captured_mean_kg": float(fuel_error[true].mean()) if true.any() else 0.0,
        "closing_fuel_error_captured_std_kg": float(fuel_error[true].std()) if true.any() else 0.0,
        "inference_ms": _inference_ms(surrogate, test.features[:1]),
    }


def _with_those_never_closed(said: np.ndarray, test: Captures) -> dict[str, Any]:
    never = np.zeros(test.scenarios - len(said), bool)
    said, true = np.concatenate([said, never]), np.concatenate([test.captured, never])
    right = said == true
    return {
        "scenarios": len(true),
        "failures": int((~true).sum()),
        "right": float(right.mean()),
        "right_95": _wilson(int(right.sum()), len(right)),
        "balanced": _balanced(said, true),
    }


def _balanced(said: np.ndarray, true: np.ndarray) -> float:
    """Mean of the shares rightly told among captured and failed ones; of one kind alone where the other is not."""
    return float(np.mean([(said == true)[true == kind].mean() for kind in (True, False) if (true == kind).any()]))


def _wilson(hits: int, count: int) -> list[float]:
    from scipy.stats import binomtest

    interval = binomtest(hits, count).proportion_ci(method="wilson")
    return [float(interval.low), float(interval.high)]


def _calibration(probability: np.ndarray, true: np.ndarray) -> list[tuple[float, float, int]]:
    number = np.minimum((probability * _BINS).astype(int), _BINS - 1)
    chosen = [number == b for b in range(_BINS) if (number == b).any()]
    return [(float(probability[c].mean()), float(true[c].mean()), int(c.sum())) for c in chosen]


def _inference_ms(surrogate: Surrogate, row: np.ndarray, times: int = 50) -> float:
    """Median wall time of one prediction [ms]."""
    taken = []
    for _ in range(times):
        began = time.perf_counter()
        surrogate.predict_many(row)
        taken.append(time.perf_counter() - began)
    return 1e3 * float(np.median(taken))
