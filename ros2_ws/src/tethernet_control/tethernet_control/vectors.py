"""Types of the vectors of control law and estimator: lists in a controller, rows of arrays in the batch engine."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import MutableSequence, Sequence

    import numpy as np
    import numpy.typing as npt

Vector: TypeAlias = "Sequence[float] | npt.NDArray[np.float64]"
"""Numbers that are read."""

Output: TypeAlias = "MutableSequence[float] | npt.NDArray[np.float64]"
"""Numbers that are written in place."""
