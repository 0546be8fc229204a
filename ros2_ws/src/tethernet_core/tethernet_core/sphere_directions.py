"""Directions spread evenly over the sphere."""

from __future__ import annotations

import math

import numpy as np

GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))  # [rad]


def directions(count: int, hemisphere: bool = False) -> np.ndarray:
    """A Fibonacci lattice: every direction stands for the same solid angle.

    Args:
        count: how many.
        hemisphere: only those with z > 0: a cylinder's axis has no sign.

    Returns:
        Unit vectors, shape (count, 3).
    """
    number = np.arange(count)
    share = (number + 0.5) / count
    z = 1.0 - share if hemisphere else 1.0 - 2.0 * share
    around = np.sqrt(1.0 - z * z)
    return np.column_stack([around * np.cos(GOLDEN_ANGLE * number), around * np.sin(GOLDEN_ANGLE * number), z])
