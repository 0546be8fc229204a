"""Maps of a campaign's page: where the debris was, how it lay, how it tumbled, who was lost when."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tethernet_core.system import System
from tethernet_learning import sphere
from tethernet_learning.campaigns import pictures
from tethernet_learning.campaigns.body_axis import body_axis
from tethernet_learning.campaigns.columns import Row
from tethernet_learning.campaigns.tumble_map import angles

_MARGIN = 0.06
_CIRCLES_DEG = (30.0, 60.0)


def maps(rows: Sequence[Row], systems: Sequence[System]) -> list[dict[str, Any]]:
    """What varies from mission to mission, a map each and for each system; ready for JSON.

    Args:
        rows: of outcomes.
        systems: of each row.
    """
    made = []
    for name, members in pictures.by_system(rows).items():
        places = [number for number, row in enumerate(rows) if row["system"] == name]
        for make in (_positions, _attitudes, _tumbles, _losses):
            found = make(members, systems[places[0]])
            if found is not None:
                made.append(_spread(found, places, len(rows)) | {"title": f"{name}: {found['title']}"})
    return made


def _spread(found: dict[str, Any], places: Sequence[int], count: int) -> dict[str, Any]:
    """A map with a place for every mission, null for those of other systems."""
    for axis in "xy":
        values: list[float | None] = [None] * count
        for place, value in zip(places, found[axis], strict=True):
            values[place] = round(float(value), 4) if math.isfinite(value) else None
        found[axis] = values
    return found


def _numbers(rows: Sequence[Row], *names: str) -> np.ndarray:
    return np.array([[math.nan if (v := row.get(name)) is None else v for name in names] for row in rows], float)


def _varies(values: np.ndarray) -> bool:
    known = values[np.isfinite(values).all(axis=1)]
    return len(known) > 1 and bool((np.ptp(known, axis=0) > 1e-6).any())


def _range(values: np.ndarray) -> list[float]:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = _MARGIN * max(high - low, 1e-6)
    return [low - margin, high + margin]


def _plane(title: str, x: np.ndarray, y: np.ndarray, x_label: str, y_label: str) -> dict[str, Any]:
    return {
        "title": title, "x": x, "y": y, "xLabel": x_label, "yLabel": y_label, "xRange": _range(x), "yRange": _range(y),
        "disc": False, "circles": [],
    }  # fmt: skip


def _positions(rows: Sequence[Row], system: System) -> dict[str, Any] | None:
    places = _numbers(rows, "debris_position_x", "debris_position_y")
    if not _varies(places):
        return None
    return _plane("where the debris was", places[:, 0], places[:, 1], "x [m]", "y [m]")


def _attitudes(rows: Sequence[Row], system: System) -> dict[str, Any] | None:
    attitudes = _numbers(rows, *(f"debris_attitude_{axis}" for axis in "xyzw"))
    if not _varies(attitudes):
        return None
    axis = body_axis(system)
    disc = sphere.equal_area(sphere.axes_of(attitudes, axis.direction))
    return {
        "title": f"direction of the debris' {axis.name}", "x": disc[:, 0], "y": disc[:, 1],
        "xLabel": "in the middle along the approach, at the rim across it", "yLabel": "",
        "xRange": [-1.05, 1.05], "yRange": [-1.05, 1.05], "disc": True,
        "circles": [math.sqrt(2.0) * math.sin(math.radians(angle) / 2.0) for angle in _CIRCLES_DEG],
    }  # fmt: skip


def _tumbles(rows: Sequence[Row], system: System) -> dict[str, Any] | None:
    axis = body_axis(system)
    rate, to_axis, _ = angles(rows, axis.direction)
    if not _varies(rate[:, None]):
        return None
    return _plane("how it tumbled", rate, to_axis, "rate [deg/s]", f"axis to the {axis.name} [deg]")


def _losses(rows: Sequence[Row], system: System) -> dict[str, Any] | None:
    losses = _numbers(rows, "failure_time_s", "failure_mu")
    if not _varies(losses):
        return None
    return _plane("which unit was lost when", losses[:, 0], losses[:, 1], "after launch [s]", "unit")
