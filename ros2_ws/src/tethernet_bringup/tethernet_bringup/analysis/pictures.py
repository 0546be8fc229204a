"""All pictures of a mission, as files."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tethernet_bringup.analysis import plots, scene, snapshots
from tethernet_bringup.analysis.metrics import SETTLED_S, net_distance, report, tracking_error
from tethernet_bringup.analysis.mission_data import MissionData
from tethernet_bringup.analysis.snapshots import Snapshot
from tethernet_bringup.analysis.table import verdict
from tethernet_bringup.bags.errors import BagError
from tethernet_bringup.bags.reader import BagReader

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_RESOLUTION_DPI = 130


def make(data: MissionData, bag: BagReader, folder: Path, extension: str = "png") -> list[Path]:
    """Make the pictures that the recording has something for.

    Args:
        data: the mission.
        bag: where it was read from; read again for the net.
        folder: for the files; made if need be.
        extension: png, svg or pdf.

    Returns:
        The files.

    Raises:
        BagError: when a file cannot be written or the bag cannot be read.
    """
    shots = snapshots.take(data, bag)
    visible = any(shot.knots is not None or shot.mus or shot.debris is not None for shot in shots)
    figures = {}
    if net_distance(data).known or any(tracking_error(data, mu).known for mu in data.mus):
        figures["tracking"] = _one(plots.tracking, data, 9.0, 5.0)
    if any(len(series.thrust) for series in data.mus.values()):
        figures["thrust"] = _thrust(data)
    if any((series.fuel.values > 0.0).any() for series in data.mus.values()):
        figures["fuel"] = _one(plots.fuel, data, 8.0, 4.5)
    if len(data.assessments) or len(data.locked):
        figures["capture"] = _one(plots.capture, data, 8.0, 4.5)
    if len(data.load_share) or len(data.contact):
        figures["loads"] = _one(plots.loads, data, 8.0, 4.5)
    if visible:
        figures["snapshots"] = _snapshots(data, shots)
    if visible and len(figures) > 1:
        figures["overview"] = _overview(data, shots)
    return [_save(figure, folder / f"{name}.{extension}") for name, figure in figures.items()]


def headline(data: MissionData) -> str:
    """System, policy, seed and verdict in one line."""
    name = data.facts.get("system") or (data.system.name if data.system else "")
    parts = [name] if name else []
    parts += [f"{data.mu_count} units"]
    parts += [f"{key} {data.facts[key]}" for key in ("policy", "seed") if data.facts.get(key)]
    held = f"\n{data.hold.message.hold_verdict}" if data.hold else ""
    return f"{', '.join(parts)} \N{EM DASH} {verdict(data)}{held}"


def _one(draw: Callable[[Axes, MissionData], None], data: MissionData, width: float, height: float) -> Figure:
    figure = plots.new_figure(width, height)
    draw(figure.add_subplot(), data)
    return figure


def _thrust(data: MissionData) -> Figure:
    figure = plots.new_figure(11.0, 1.5 + 1.1 * len(data.mus))
    plots.thrust(figure, data)
    return figure


def _snapshots(data: MissionData, shots: list[Snapshot]) -> Figure:
    """The whole way on top, what follows below it from nearby."""
    below: list[str] = list("bcd"[: max(len(shots) - 1, 2)])
    figure = plots.new_figure(13.0 if len(below) == 2 else 17.0, 10.5)
    panels = figure.subplot_mosaic([["a"] * len(below), [*below]], height_ratios=[0.75, 1.0])
    _draw_scenes(figure, [panels[key] for key in ("a", *below)], data, shots)
    figure.suptitle(headline(data), fontsize=11)
    return figure


def _overview(data: MissionData, shots: list[Snapshot]) -> Figure:
    held = len(shots) > 3  # a hold test: one scene more, and the loads below it
    figure = plots.new_figure(20.0 if held else 16.0, 9.0)
    above, below = [*"aaabbcc", *("dd" if held else "")], [*"tttffqq", *("ll" if held else "")]
    panels = figure.subplot_mosaic([above, below], height_ratios=[1.25, 1.0])
    _draw_scenes(figure, [panels[key] for key in ("abcd" if held else "abc")], data, shots)
    _facts(panels["a"], data)
    plots.tracking(panels["t"], data)
    plots.fuel(panels["f"], data)
    plots.capture(panels["q"], data)
    if held:
        plots.loads(panels["l"], data)
    figure.suptitle(headline(data), fontsize=14, fontweight="bold")
    return figure


def _facts(panel: Axes, data: MissionData) -> None:
    """The numbers that one asks for first, where the wide scene leaves room."""
    reports = [report(data, mu) for mu in sorted(data.mus)]
    fuel = sum(entry.fuel_kg for entry in reports)
    error = max((entry.max_error_m for entry in reports), default=math.nan)
    lines = []
    if data.closing_ns is not None:
        lines.append(f"trigger {float(data.seconds(data.closing_ns)):.1f} s after launch")
    if data.trigger and math.isfinite(data.trigger.message.mouth_area):
        lines.append(f"mouth {data.trigger.message.mouth_area:.0f} m² at the trigger")
    if math.isfinite(error):
        lines.append(f"position error at most {100.0 * error:.0f} cm from {SETTLED_S:g} s to the trigger")
    if reports and math.isfinite(fuel):
        lines.append(f"fuel {fuel:.2f} kg in all")
    panel.text(0.99, 0.97, "\n".join(lines), transform=panel.transAxes, ha="right", va="top", fontsize=9, color="0.25")


def _draw_scenes(figure: Figure, panels: Sequence[Axes], data: MissionData, shots: list[Snapshot]) -> None:
    for panel in panels:
        panel.set_axis_off()
    figure.draw_without_rendering()  # the scenes fit themselves to their panels: those must have their places
    for number, (panel, shot) in enumerate(zip(panels, shots, strict=False)):
        panel.set_axis_on()
        scene.draw(panel, shot, data.system, wide=number == 0)


def _save(figure: Figure, path: Path) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=_RESOLUTION_DPI)
    except OSError as error:
        raise BagError(f"cannot write {path}: {error.strerror or error}; give another folder with --output") from error
    return path
