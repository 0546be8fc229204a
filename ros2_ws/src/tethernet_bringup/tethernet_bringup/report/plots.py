"""Plots of a page: what is drawn against time, packed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tethernet_bringup.report.packing import pack

MOST_POINTS = 1500
"""Of one series; longer ones are drawn with the largest value of each interval, so that no peak is lost."""


@dataclass
class Line:
    """One series."""

    label: str
    values: np.ndarray
    """On the plot's times, NaN where nothing is known, shape (P,)."""
    color: str
    """unit-N for what belongs to unit N, else a name of the style sheet."""
    steps: bool = False
    """Each value holds until the next."""
    right: bool = False
    """Measured on the right axis."""


@dataclass
class Plot:
    """One panel."""

    title: str
    unit: str
    lines: list[Line] = field(default_factory=list)
    limits: list[tuple[float, str]] = field(default_factory=list)
    """Values that matter, on the left axis, with their names."""
    top: float | None = None
    """Where the left axis ends at most."""
    right_unit: str = ""

    def content(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "title": self.title,
            "unit": self.unit,
            "rightUnit": self.right_unit,
            "top": self.top,
            "limits": [{"value": value, "label": label} for value, label in self.limits],
            "lines": [
                {"label": line.label, "color": line.color, "steps": line.steps, "right": line.right}
                for line in self.lines
            ],
            "values": pack_lines(self.lines),
        }

    @property
    def known(self) -> bool:
        """Whether there is anything to see."""
        return any(np.isfinite(line.values).any() for line in self.lines)


def pack_lines(lines: list[Line]) -> list[dict[str, Any]]:
    """Each line packed by itself: their ranges differ."""
    return [pack(line.values[:, None]) for line in lines]


def times(end_s: float, period_s: float) -> np.ndarray:
    """Times of plots from launch to the end [s]: every period, or every so many."""
    stride = max(1, int(np.ceil(end_s / period_s / MOST_POINTS)))
    return np.arange(int(end_s / (period_s * stride)) + 1) * (period_s * stride)


def sampled(at: np.ndarray, time_s: np.ndarray, value: np.ndarray, *, hold: bool = False) -> np.ndarray:
    """A series on other times: in between straight, or each value until the next; NaN before, behind and where it is.

    Args:
        at: wanted times, ascending [s], shape (P,).
        time_s: ascending [s], shape (n,).
        value: shape (n,).
        hold: each value holds until the next, the last one for ever.
    """
    if not len(time_s):
        return np.full(len(at), np.nan)
    after = np.searchsorted(time_s, at + 1e-9, side="right")
    before = np.clip(after - 1, 0, len(time_s) - 1)
    if hold:
        return np.where(after > 0, value[before], np.nan)
    following = np.clip(after, 0, len(time_s) - 1)
    gap = time_s[following] - time_s[before]
    share = np.where(gap > 0.0, (at - time_s[before]) / np.where(gap > 0.0, gap, 1.0), 0.0)
    exact = np.abs(at - time_s[before]) < 1e-6
    between = np.where(exact, value[before], (1.0 - share) * value[before] + share * value[following])
    return np.where((after > 0) & (at <= time_s[-1] + 1e-6), between, np.nan)


def peaks(at: np.ndarray, time_s: np.ndarray, value: np.ndarray) -> np.ndarray:
    """The largest value since the time before; like :func:`sampled` where there is none in between."""
    result = sampled(at, time_s, value, hold=True)
    if len(at) < 2 or not len(time_s):
        return np.where(at <= time_s[-1] + 1.0, result, np.nan) if len(time_s) else result
    place = np.clip(np.searchsorted(at, time_s - 1e-9, side="left"), 0, len(at) - 1)
    largest = np.full(len(at), -np.inf)
    known = np.isfinite(value)
    np.maximum.at(largest, place[known], value[known])
    return np.where(np.isfinite(largest), largest, np.where(at <= time_s[-1] + 1e-6, result, np.nan))
