"""Picture: how often debris is captured and held, over its tumble rate and the axis it tumbles about."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from tethernet_learning import sphere
from tethernet_learning.campaigns import pictures
from tethernet_learning.campaigns.body_axis import body_axis
from tethernet_learning.campaigns.columns import Row
from tethernet_learning.campaigns.flown_systems import FlownSystems
from tethernet_learning.campaigns.statistics import share

LARGEST_RATES = 14
"""More rates than these are gathered in steps of RATE_STEP_DEG_S."""
RATE_STEP_DEG_S = 0.5
ANGLES_DEG = (0.0, 48.19, 70.53, 90.0)
"""Classes of an axis' angle, each a third of the sphere."""
STILL_DEG_S = 1e-6
"""Slower than this there is no axis."""


def draw(rows: Sequence[Row], systems: FlownSystems) -> Any:
    """Draw the map, one line of panels for each system: captured over the rate; over rate and axis. A second line
    below it shows what was held, where that was tested.

    Args:
        rows: of outcomes, at least one.
        systems: that they are of.

    Returns:
        A matplotlib figure.
    """
    groups = pictures.by_system(rows)
    shares = [pictures.CAPTURED, *([pictures.HELD] if pictures.tested(rows) else [])]
    shown = [(name, flown, what) for name, flown in groups.items() for what in shares]
    figure = pictures.new_figure(15.0, 4.6 * len(shown) + 0.6)
    panels = figure.subplots(len(shown), 3, squeeze=False, width_ratios=(1.0, 1.25, 1.25))
    image = None
    for line, (name, flown, what) in zip(panels, shown, strict=True):
        axis = body_axis(systems.of_row(flown[0]))
        good = pictures.judged(flown, what)
        rate, to_long_axis, to_approach = angles(flown, axis.direction)
        rate = _classes(rate)
        _curve(line[0], rate, good, what)
        line[0].set_title(f"{name}: {pictures.counts_text(flown)}", fontsize=10)
        for panel, angle, to in ((line[1], to_long_axis, f"the {axis.name}"), (line[2], to_approach, "the approach")):
            drawn = _cells(panel, rate, angle, good)
            image = drawn if drawn is not None else image
            panel.set_ylabel(f"angle of the tumble axis to {to} [deg]")
            panel.set_title(f"{name}, {what}: tumble axis and {to}", fontsize=10)
    names = " and ".join(shares)
    if image is not None:
        figure.colorbar(image, ax=list(panels[:, 1:].flat), label=f"{names} [%]", shrink=0.8)
    figure.suptitle(
        f"{names.capitalize()} over the debris' tumble rate and the direction of its tumble axis at launch", fontsize=12
    )
    return figure


def angles(rows: Sequence[Row], axis: Sequence[float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rates [deg/s] and the angles of the tumble axis to the long axis and to the approach, 0 to 90 [deg]; NaN where
    nothing tumbles.
    """
    attitudes = np.array([[row[f"debris_attitude_{axis}"] for axis in "xyzw"] for row in rows], float)
    rates = np.array([[row[f"debris_rate_{axis}"] for axis in "xyz"] for row in rows], float)
    size = np.linalg.norm(rates, axis=1)
    moving = np.degrees(size) > STILL_DEG_S
    axes = rates / np.where(moving, size, np.nan)[:, None]
    along = np.abs(np.column_stack([axes @ np.asarray(axis), sphere.in_launch_frame(attitudes, axes)[:, 2]]))
    angles = np.degrees(np.arccos(np.clip(along, 0.0, 1.0)))
    return np.degrees(size), angles[:, 0], angles[:, 1]


def _classes(rate: np.ndarray) -> np.ndarray:
    """Rates rounded to those that were flown, or to steps when these are many [deg/s]."""
    rounded = np.round(rate, 3)
    if len(np.unique(rounded)) <= LARGEST_RATES:
        return rounded
    return np.round(rate / RATE_STEP_DEG_S) * RATE_STEP_DEG_S


def _curve(panel: Any, rate: np.ndarray, good: np.ndarray, what: str) -> None:
    rates = np.unique(rate)
    shares = [share(int(good[rate == r].sum()), int((rate == r).sum())) for r in rates]
    value, low, high = (100.0 * np.array([getattr(s, name) for s in shares]) for name in ("value", "low", "high"))
    panel.errorbar(rates, value, np.maximum([value - low, high - value], 0.0), marker="o", capsize=3, color="#0072B2")
    for r, place in zip(rates, low, strict=True):
        panel.annotate(
            f"n = {(rate == r).sum()}", (r, place), xytext=(0, -4), textcoords="offset points",
            ha="center", va="top", fontsize=8,
        )  # fmt: skip
    panel.set_ylim(-8.0, 104.0)
    panel.margins(x=0.1)
    panel.set_xlabel("tumble rate [deg/s]")
    panel.set_ylabel(f"{what}, with 95 % interval [%]")
    panel.grid(alpha=0.25)


def _cells(panel: Any, rate: np.ndarray, angle: np.ndarray, judged: np.ndarray) -> Any:
    """Rate along x, angle along y; None where nothing tumbles."""
    moving = ~np.isnan(angle)
    rates = np.unique(rate[moving])
    panel.set_xlabel("tumble rate [deg/s]")
    if not len(rates):
        panel.set(xticks=[], yticks=[])
        panel.text(0.5, 0.5, "nothing tumbles", ha="center", transform=panel.transAxes)
        return None
    column = np.searchsorted(rates, np.where(moving, rate, rates[0]))
    row = np.clip(np.searchsorted(ANGLES_DEG, np.where(moving, angle, 0.0), side="right") - 1, 0, len(ANGLES_DEG) - 2)
    shape = (len(ANGLES_DEG) - 1, len(rates))
    count, good = np.zeros(shape, int), np.zeros(shape, int)
    np.add.at(count, (row[moving], column[moving]), 1)
    np.add.at(good, (row[moving], column[moving]), judged[moving])
    percent = np.where(count > 0, 100.0 * good / np.maximum(count, 1), np.nan)
    image = panel.imshow(percent, origin="lower", aspect="auto", vmin=0.0, vmax=100.0, cmap=pictures.COLOURS)
    for (i, j), value in np.ndenumerate(percent):
        text = "not flown" if np.isnan(value) else f"{value:.0f} %\n{good[i, j]} of {count[i, j]}"
        panel.text(
            j,
            i,
            text,
            ha="center",
            va="center",
            fontsize=8,
            color="white" if value <= 60.0 else "black",
        )
    panel.set_xticks(range(len(rates)), [f"{r:g}" for r in rates])
    panel.set_yticks(range(shape[0]), [f"{a:.0f} to {b:.0f}" for a, b in pairwise(ANGLES_DEG)])
    return image
