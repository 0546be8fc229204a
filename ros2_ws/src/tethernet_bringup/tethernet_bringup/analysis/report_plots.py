"""The plots of a mission's page."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from tethernet_bringup.analysis.metrics import (
    Curve,
    curve,
    enclosure,
    net_distance,
    quality,
    thrust_curve,
    tracking_error,
)
from tethernet_bringup.analysis.mission_data import MissionData
from tethernet_bringup.report.plots import Line, Plot, peaks, sampled, times

PERIOD_S = 0.05
CQI_SHOWN = 12.0
"""Beyond this the CQI says no more than that the net is not there yet."""


def plots(data: MissionData, end_s: float) -> dict[str, Any] | None:
    """Ready for JSON; None where there is nothing to see.

    Args:
        data: the mission.
        end_s: of the flight [s after launch].
    """
    at = times(end_s, PERIOD_S)
    made = (_distance, _errors, _thrust, _fuel, _quality, _pairs, _loads)
    panels = [plot for plot in (make(data, at) for make in made) if plot.known]
    if not panels or len(at) < 2:
        return None
    return {
        "start": 0.0, "step": float(at[1] - at[0]), "count": len(at), "panels": [plot.content() for plot in panels],
    }  # fmt: skip


def _linear(at: np.ndarray, series: Curve, scale: float = 1.0) -> np.ndarray:
    return scale * sampled(at, series.time_s, series.value)


def _held(at: np.ndarray, series: Curve, scale: float = 1.0) -> np.ndarray:
    with np.errstate(over="ignore"):  # of a broken message; what is too large is not shown
        return scale * sampled(at, series.time_s, series.value, hold=True)


def _of_units(data: MissionData, make: Callable[[int], np.ndarray]) -> Iterable[Line]:
    for mu in sorted(data.mus):
        values = make(mu)
        if np.isfinite(values).any():
            yield Line(f"MU {mu}", values, f"unit-{mu}")


def _distance(data: MissionData, at: np.ndarray) -> Plot:
    return Plot("Distance of net and debris", "m", [Line("net to debris", _linear(at, net_distance(data)), "distance")])


def _errors(data: MissionData, at: np.ndarray) -> Plot:
    return Plot(
        "Position error of the units", "m",
        list(_of_units(data, lambda mu: _linear(at, tracking_error(data, mu)))),
    )  # fmt: skip


def _thrust(data: MissionData, at: np.ndarray) -> Plot:
    def magnitude(mu: int) -> np.ndarray:
        force = thrust_curve(data, mu)
        return peaks(at, force.time_s, np.linalg.norm(force.value.reshape(-1, 3), axis=1))

    return Plot("Commanded thrust", "N", list(_of_units(data, magnitude)))


def _fuel(data: MissionData, at: np.ndarray) -> Plot:
    used = _of_units(data, lambda mu: _held(at, curve(data, data.mus[mu].fuel), 1e3))
    return Plot("Fuel used", "g", list(used))


def _quality(data: MissionData, at: np.ndarray) -> Plot:
    cqi, _ = quality(data)
    _, mcqi = enclosure(data)
    lines = [Line("CQI", _held(at, cqi), "cqi")] if cqi.known else []
    lines += [Line("MCQI", _held(at, mcqi), "mcqi")] if mcqi.known else []
    threshold = data.system.capture.cqi_threshold if data.system else None
    limits = [] if threshold is None else [(threshold, f"captured below {threshold:g}")]
    return Plot("Capture quality", "-", lines, limits, top=CQI_SHOWN)


def _pairs(data: MissionData, at: np.ndarray) -> Plot:
    _, pairs = quality(data)
    inside, _ = enclosure(data)
    lines = [Line("locked pairs", _held(at, pairs), "pairs", steps=True)]
    lines += [Line("enclosed (1: yes)", _held(at, inside), "good", steps=True)] if inside.known else []
    system = data.system
    required = system.capture.required_locked_pairs if system else 0
    return Plot("Locked pairs", "pairs", lines, [(required, f"{required} needed")] if required else [])


def _loads(data: MissionData, at: np.ndarray) -> Plot:
    share, force, tether = (curve(data, series) for series in (data.load_share, data.contact, data.tether))
    lines = []
    if share.known:
        lines.append(Line("largest tension over strength", 100.0 * peaks(at, share.time_s, share.value), "load"))
    for each, label, color in ((force, "contact on the debris", "contact"), (tether, "main tether", "tether")):
        if each.known and (np.nan_to_num(each.value) > 0.0).any():
            lines.append(Line(label, peaks(at, each.time_s, each.value), color, right=share.known))
    plot = Plot("Loads", "% of strength" if share.known else "N", lines)
    plot.right_unit = "N" if any(line.right for line in lines) else ""
    return plot
