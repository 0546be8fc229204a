"""Rows of numbers over time, as they are collected from a bag."""

from __future__ import annotations

from array import array

import numpy as np


class Series:
    """Rows of numbers over time, collected one by one."""

    def __init__(self, width: int):
        self._width = width
        self._stamps = array("q")
        self._values = array("d")

    def add(self, stamp_ns: int, *values: float) -> None:
        """Add one row.

        Args:
            stamp_ns: [ns]
            values: as many as the series is wide.
        """
        self._stamps.append(stamp_ns)
        self._values.extend(values)

    def __len__(self) -> int:
        return len(self._stamps)

    @property
    def stamps(self) -> np.ndarray:
        """Stamps, shape (n,) [ns]."""
        return np.array(self._stamps, dtype=np.int64)

    @property
    def values(self) -> np.ndarray:
        """Values, shape (n, width)."""
        return np.array(self._values).reshape(-1, self._width)

    def sorted(self) -> tuple[np.ndarray, np.ndarray]:
        """Stamps and values in the order of time, finite rows only, the last of several with one stamp."""
        stamps, values = self.stamps, self.values
        good = np.isfinite(values).all(axis=1)
        stamps, values = stamps[good], values[good]
        order = np.argsort(stamps, kind="stable")
        stamps, values = stamps[order], values[order]
        last = np.append(np.diff(stamps) > 0, True) if len(stamps) else np.zeros(0, bool)
        return stamps[last], values[last]

    @property
    def nonfinite(self) -> int:
        """Rows with NaN or infinity."""
        return int((~np.isfinite(self.values).all(axis=1)).sum())
