"""Model files that know nothing but are whole: for tests of what stands around trained models."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tethernet_core.system import System
from tethernet_planner.inference.model_file import MadeFor
from tethernet_planner.inference.net_features import feature_count
from tethernet_planner.inference.policy_file import constant_policy
from tethernet_planner.inference.surrogate_file import PredictionErrors, Surrogate, log_fuel, seen_arrays
from tethernet_planner.inference.task import task_of


def policy(path: Path, system: System, dx: float = 0.5, dy: float = -0.3) -> Path:
    """A policy that always moves every aiming point by (dx, dy) [m]."""
    offsets = np.tile([dx, dy], (system.unit_count, 1))
    constant_policy(system, task_of(system), offsets, {"method": "none", "commit": "abc"}).save(path)
    return path


def surrogate(path: Path, system: System, cqi: float = 1.5, pairs: float = 7.2, seen: int | None = None) -> Path:
    """A surrogate that always predicts the same, and a capture with probability one half.

    With ``seen`` the predicted number of locked pairs is ``pairs`` plus that one of its inputs.
    """
    inputs = feature_count(system)
    weight = np.zeros((4, inputs))
    if seen is not None:
        weight[1, seen] = 1.0
    arrays = {
        "0.weight_0": weight,
        "0.bias_0": np.array([np.log(cqi), pairs, log_fuel(0.02), 0.0]),
        "input_mean": np.zeros(inputs),
        "input_scale": np.ones(inputs),
        "output_mean": np.zeros(3),
        "output_scale": np.ones(3),
        "calibration": np.array([1.0, 0.0]),
        **seen_arrays(system),
    }
    errors = {part: PredictionErrors() for part in ("all", "near", "far")}
    most = system.closing.max_locked_pairs
    Surrogate("mlp", MadeFor.of(system), most, arrays, errors, {"commit": "abc"}).save(path)
    return path
