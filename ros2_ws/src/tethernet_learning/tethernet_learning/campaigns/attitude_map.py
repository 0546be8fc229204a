"""Picture: how often debris is captured and held, over the direction of its long axis, or another one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tethernet_core import sphere_directions
from tethernet_learning import sphere
from tethernet_learning.campaigns import pictures
from tethernet_learning.campaigns.body_axis import body_axis
from tethernet_learning.campaigns.columns import Row
from tethernet_learning.campaigns.flown_systems import FlownSystems

LARGEST_CELLS = 600
"""More directions than these are gathered in cells of equal size."""
CELLS = 200
PIXELS = 500
CIRCLES_DEG = (30, 60)
MARKS = {"row (x)": 0.0, "diagonal": 45.0, "column (y)": 90.0, "other diagonal": 135.0}
"""Directions across the approach [deg from x]."""


def draw(rows: Sequence[Row], systems: FlownSystems) -> Any:
    """Draw the map, one column of panels for each system: captured above, held below it where that was tested, locked
    pairs at the bottom.

    Args:
        rows: of outcomes, at least one.
        systems: that they are of.

    Returns:
        A matplotlib figure.
    """
    groups = pictures.by_system(rows)
    shares = [pictures.CAPTURED, *([pictures.HELD] if pictures.tested(rows) else [])]
    figure = pictures.new_figure(5.6 * len(groups) + 0.4, 4.9 * (len(shares) + 1) + 0.6)
    panels = figure.subplots(len(shares) + 1, len(groups), squeeze=False)
    for column, (name, flown) in zip(panels.T, groups.items(), strict=True):
        system = systems.of_row(flown[0])
        axis = body_axis(system)
        axes, cell = _cells(flown, axis.direction)
        count = np.bincount(cell, minlength=len(axes))
        good = [np.bincount(cell, pictures.judged(flown, what), len(axes)) / np.maximum(count, 1) for what in shares]
        pairs_locked = np.array([row["locked_pairs"] for row in flown], float)
        locked = np.bincount(cell, pairs_locked, len(axes)) / np.maximum(count, 1)
        used = count > 0
        each = f"{count[used].min()}" if np.ptp(count[used]) == 0 else f"{count[used].min()} to {count[used].max()}"
        pairs, needed = system.closing.max_locked_pairs, system.capture.required_locked_pairs
        for panel, value, top, label in (
            *((column[i], 100.0 * good[i], 100.0, f"{what} [%]") for i, what in enumerate(shares)),
            (column[-1], locked, max(pairs, 1), f"locked pairs, mean (of {pairs}; {needed} needed)"),
        ):
            image = _paint(panel, axes[used], value[used], top)
            figure.colorbar(image, ax=panel, label=label, orientation="horizontal", shrink=0.8, pad=0.02)
        column[0].set_title(
            f"{name}: {pictures.counts_text(flown)}\n{axis.name}, {used.sum()} directions; missions for each: {each}",
            fontsize=10,
        )
    figure.suptitle(
        "Direction of the debris' axis, either end of it,\n"
        "on an equal-area map of the hemisphere:\n"
        "along the approach in the middle, across it at the rim",
        fontsize=11,
    )
    return figure


def _cells(rows: Sequence[Row], axis: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Directions that stand for the missions, shape (n, 3), and the number of each mission's one, shape (missions,)."""
    attitudes = np.array([[row[f"debris_attitude_{axis}"] for axis in "xyzw"] for row in rows], float)
    axes = sphere.axes_of(attitudes, axis)
    directions, cell = np.unique(np.round(axes, 6), axis=0, return_inverse=True)
    if len(directions) > LARGEST_CELLS:
        directions = sphere_directions.directions(CELLS, hemisphere=True)
        cell = _nearest(axes, directions)
    return directions, cell.reshape(-1)


def _nearest(axes: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The number of the direction that is nearest to each axis, either end of it."""
    return np.argmax(np.abs(axes @ directions.T), axis=1)


def _paint(panel: Any, directions: np.ndarray, value: np.ndarray, top: float) -> Any:
    grid = (np.arange(PIXELS) + 0.5) / PIXELS * 2.0 - 1.0
    places = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    axes = sphere.from_equal_area(places)
    inside = ~np.isnan(axes[:, 2])
    colour = np.full(len(axes), np.nan)
    colour[inside] = value[_nearest(axes[inside], directions)]
    image = panel.imshow(
        colour.reshape(PIXELS, PIXELS), origin="lower", extent=(-1, 1, -1, 1), vmin=0.0, vmax=top,
        cmap=pictures.COLOURS, interpolation="nearest",
    )  # fmt: skip
    panel.plot(*sphere.equal_area(directions).T, ".", color="black", markersize=2.0, alpha=0.6)
    around = np.linspace(0.0, 2.0 * np.pi, 200)
    for circle in (*CIRCLES_DEG, 90):
        radius = np.sqrt(2.0) * np.sin(np.radians(circle) / 2.0)
        panel.plot(radius * np.cos(around), radius * np.sin(around), color="black", linewidth=0.6, linestyle=":")
        panel.annotate(
            f"{circle}°", (0.0, -radius), fontsize=8, ha="center", va="center",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.8},
        )  # fmt: skip
    for name, angle in MARKS.items():
        x, y = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        panel.plot([x, -x], [y, -y], color="black", linewidth=0.4, alpha=0.5)
        panel.annotate(
            name, (1.04 * x, 1.04 * y), fontsize=8, va="center" if abs(y) < 0.9 else "bottom",
            ha="center" if abs(x) < 0.1 else "left" if x > 0 else "right",
        )  # fmt: skip
    panel.set_xlim(-1.45, 1.45)
    panel.set_ylim(-1.1, 1.15)
    panel.set_aspect("equal")
    panel.axis("off")
    return image
