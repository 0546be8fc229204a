"""What a page shows of one flight in three dimensions."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tethernet_bringup.report.packing import pack, rounded

FINEST_M = 1e-3
"""Positions are rounded to this, or to what 16 bits allow [m]."""


@dataclass
class Flight:
    """Moments of a flight, one every ``step_s``; NaN where something is not known. F moments, N knots, M units."""

    title: str
    system: str
    """Key of its geometry on the page."""
    start_s: float
    """First moment after launch [s]."""
    step_s: float
    """From moment to moment [s]."""
    knots: np.ndarray | None = None
    """[m], shape (F, N, 3)."""
    units: np.ndarray | None = None
    """[m], shape (F, M, 3)."""
    thrust: np.ndarray | None = None
    """Commanded force [N], shape (F, M, 3)."""
    debris: np.ndarray | None = None
    """Position [m] and attitude x y z w, shape (F, 7)."""
    chaser: np.ndarray | None = None
    """Likewise."""
    locked: np.ndarray | None = None
    """Which closing pairs hold, 1 or 0, shape (F, R)."""
    debris_place: np.ndarray | None = None
    """Where the debris was taken to be [m], shape (3,), where nobody measured it."""
    aiming: np.ndarray | None = None
    """Aiming points [m], shape (M, 3)."""
    closing: list[tuple[float, np.ndarray]] = field(default_factory=list)
    """Closing points [m], shape (M, 3), each set with the time from which on it holds [s]."""
    phases: list[tuple[str, float]] = field(default_factory=list)
    """Names of the phases and when they began [s]."""
    shown: np.ndarray | None = None
    """Numbers of the knots that ``knots`` holds, where these are not all, shape (N,)."""

    @property
    def count(self) -> int:
        """F."""
        tracks = (self.knots, self.units, self.debris, self.chaser)
        return max((len(track) for track in tracks if track is not None), default=0)

    def thinned(self) -> Flight:
        """Every other moment."""
        names = ("knots", "units", "thrust", "debris", "chaser", "locked")
        tracks = {name: getattr(self, name) for name in names}
        halves: dict[str, Any] = {name: None if track is None else track[::2] for name, track in tracks.items()}
        return dataclasses.replace(self, step_s=2.0 * self.step_s, **halves)

    def content(self, finest_m: float = FINEST_M) -> dict[str, Any]:
        """Ready for JSON.

        Args:
            finest_m: positions are rounded to this [m].
        """
        return {
            "title": self.title,
            "system": self.system,
            "start": self.start_s,
            "step": self.step_s,
            "count": self.count,
            "knots": _points(self.knots, finest_m),
            "units": _points(self.units, finest_m),
            "thrust": _points(self.thrust, 1e-3),
            "debris": _body(self.debris, finest_m),
            "chaser": _body(self.chaser, finest_m),
            "locked": None if self.locked is None or not self.locked.shape[1] else pack(self.locked, finest=1.0),
            "debrisPlace": None if self.debris_place is None else rounded(self.debris_place),
            "aiming": None if self.aiming is None else rounded(self.aiming, 3),
            "closing": [{"time": round(time, 3), "points": rounded(points, 3)} for time, points in self.closing],
            "phases": [{"name": name, "time": round(time, 3)} for name, time in self.phases],
            "shown": None if self.shown is None else [int(knot) for knot in self.shown],
        }


def _points(track: np.ndarray | None, finest: float) -> dict[str, Any] | None:
    if track is None or not track.size or not np.isfinite(track).any():
        return None
    return pack(track.reshape(len(track), -1), period=3, finest=finest)


def _body(track: np.ndarray | None, finest: float) -> dict[str, Any] | None:
    if track is None or not np.isfinite(track).any():
        return None
    return {"position": pack(track[:, :3], period=3, finest=finest), "attitude": pack(track[:, 3:])}


def size_of(content: dict[str, Any] | None) -> int:
    """About how many characters a flight takes on the page."""
    if content is None:
        return 0
    return sum(
        len(value) if isinstance(value, str) else size_of(value) if isinstance(value, dict) else 8
        for value in content.values()
    )
