"""The functions that a shape's formulae are written with, beside + - * / and comparisons.

A formula is written once and serves arrays here and single numbers in the simulator, which compiles these names as
branch-free instructions.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def select(condition: Any, yes: Any, no: Any) -> Any:
    """``yes`` where the condition holds, else ``no``; both are evaluated."""
    return np.where(condition, yes, no)


def larger(a: Any, b: Any) -> Any:
    """The larger of two numbers."""
    return np.maximum(a, b)


def smaller(a: Any, b: Any) -> Any:
    """The smaller of two numbers."""
    return np.minimum(a, b)


def magnitude(a: Any) -> Any:
    """Absolute value."""
    return np.abs(a)


def root(a: Any) -> Any:
    """Square root."""
    return np.sqrt(a)


def whole(a: Any) -> Any:
    """The largest whole number that is not above ``a``, as an index."""
    return np.floor(a).astype(np.int64)
