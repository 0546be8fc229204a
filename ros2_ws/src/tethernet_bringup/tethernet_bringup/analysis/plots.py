"""Curves over the mission: tracking error and distance (the paper's figure), thrust, fuel, capture quality."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tethernet_bringup.analysis.metrics import (
    Curve,
    curve,
    enclosure,
    error_source,
    net_distance,
    quality,
    thrust_curve,
    tracking_error,
)
from tethernet_bringup.analysis.mission_data import MissionData
from tethernet_bringup.analysis.punctuality import closing_start, delay_text
from tethernet_bringup.analysis.scene import mu_color
from tethernet_core.mission import Phase

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_AXIS_COLORS = ("#D55E00", "#009E73", "#0072B2")
_CQI_SHOWN = 12.0
_BAND = 0.06
"""Height of the room for a band below a plot's zero, in heights of the plot."""


def mark_phases(axes: Axes, data: MissionData, *, named: bool = True) -> None:
    """Lines at the trigger, where closing begins, at the verdict where a hold test follows, where the mission ends.

    Args:
        axes: with the time since launch along x [s].
        data: the mission.
        named: write the names at the top.
    """
    for change in data.phases:
        if change.phase not in (Phase.CLOSING, Phase.HOLDING, Phase.COMPLETE, Phase.MISSED, Phase.ABORTED):
            continue
        time = float(data.seconds(change.time_ns))
        axes.axvline(time, color="black", linewidth=0.8, linestyle=":", zorder=1)
        if named:
            names = {Phase.CLOSING: _closing_name(data), Phase.HOLDING: _holding_name(data), Phase.COMPLETE: "end"}
            name = names.get(change.phase, change.phase.name.lower())
            axes.annotate(
                name, (time, 1.0), xycoords=("data", "axes fraction"), xytext=(-2, -3), textcoords="offset points",
                ha="right", va="top", fontsize=8, rotation=90,
            )  # fmt: skip


def _closing_name(data: MissionData) -> str:
    start = closing_start(data)
    return "closing" if start is None else f"trigger, closing {delay_text(start)} later"


def _holding_name(data: MissionData) -> str:
    tow = getattr(data.states[-1], "tow", 0.0) if data.states else 0.0
    return f"verdict, towed with {tow:g} N" if tow else "verdict, hold test"


def tracking(axes: Axes, data: MissionData) -> None:
    """Position error of each MU (left) and distance of net and debris (right) over time."""
    for mu in sorted(data.mus):
        error = tracking_error(data, mu)
        if error.known:
            axes.plot(error.time_s, error.value, color=mu_color(mu), linewidth=1.0, label=f"MU {mu}")
    axes.set_ylabel("position error of the units [m]" if data.mus else "")
    axes.set_ylim(bottom=0.0)
    if not data.mus:
        axes.set_yticks([])
    _time_axis(axes, data)
    errors = (
        f"Position error ({error_source(data)}) and distance to the debris" if data.mus else "Distance to the debris"
    )
    axes.set_title(errors, fontsize=10, loc="left")
    distance = net_distance(data)
    if distance.known:
        right = axes.twinx()
        right.plot(distance.time_s, distance.value, color="black", linewidth=1.8, linestyle="--")
        right.set_ylabel("distance of net and debris [m]")
        right.set_ylim(bottom=0.0)
        axes.plot([], [], color="black", linewidth=1.8, linestyle="--", label="net to debris")  # for the one legend
    if axes.get_legend_handles_labels()[0]:
        # There is always room left of the trigger, above the falling distance; and where a hold test is plotted.
        share = 1.0
        if data.closing_ns is not None and data.judged_ns is None:
            share = float(data.seconds(data.closing_ns)) / axes.get_xlim()[1]
        axes.legend(loc="upper right", bbox_to_anchor=(share - 0.02, 1.0), ncols=2, fontsize=8, frameon=False)
    mark_phases(axes, data)


def thrust(figure: Figure, data: MissionData) -> None:
    """Commanded force per axis, one panel for each MU."""
    mus = sorted(mu for mu, series in data.mus.items() if len(series.thrust))
    columns = 2 if len(mus) > 1 else 1
    panels = figure.subplots(-(-len(mus) // columns), columns, sharex=True, sharey=True, squeeze=False)
    for panel, mu in zip(panels.flat, mus, strict=False):
        force = thrust_curve(data, mu)
        for axis, color in enumerate(_AXIS_COLORS):
            panel.step(
                force.time_s,
                force.value[:, axis],
                where="post",
                color=color,
                linewidth=0.7,
                label="xyz"[axis],
                alpha=0.85,
            )
        limit = data.system.units[mu - 1].thrust_limit_n if data.system and mu <= data.system.unit_count else None
        for sign in (-1.0, 1.0):
            if limit is not None:
                panel.axhline(sign * limit, color="gray", linewidth=0.7, linestyle="--")
        panel.set_title(f"MU {mu}", fontsize=9, loc="left", color=mu_color(mu), fontweight="bold")
        mark_phases(panel, data, named=mu == mus[0])
        panel.grid(alpha=0.25)
    for panel in panels.flat[len(mus) :]:
        panel.set_visible(False)
    lines, names = panels.flat[0].get_legend_handles_labels()
    figure.legend(lines, names, loc="outside upper right", ncols=3, fontsize=9, frameon=False)
    panels.flat[0].set_xlim(0.0, max(float(data.seconds(data.end_ns)), 0.1))
    figure.supxlabel("time since launch [s]", fontsize=10)
    figure.supylabel("commanded thrust [N]" + (", dashed: limit" if data.system else ""), fontsize=10)


def fuel(axes: Axes, data: MissionData) -> None:
    """Fuel used by each MU over time."""
    if not data.mus:
        axes.text(0.5, 0.5, "no units", transform=axes.transAxes, ha="center", color="gray")
    for mu, series in sorted(data.mus.items()):
        used = curve(data, series.fuel)
        if used.known:
            axes.plot(used.time_s, 1e3 * used.value, color=mu_color(mu), linewidth=1.3, label=f"MU {mu}")
    axes.set_ylabel("fuel used [g]")
    axes.set_ylim(bottom=0.0)
    _time_axis(axes, data)
    axes.set_title("Fuel of each MU", fontsize=10, loc="left")
    if axes.get_legend_handles_labels()[0]:
        rest = {"ncols": 2, "fontsize": 8, "frameon": False}
        if data.judged_ns is None:
            axes.legend(loc="upper left", **rest)
        else:
            axes.legend(loc="lower right", **rest)
    mark_phases(axes, data)


def capture(axes: Axes, data: MissionData) -> None:
    """CQI, MCQI, whether the debris is enclosed (left) and locked pairs (right) over time."""
    cqi, pairs = quality(data)
    inside, mcqi = enclosure(data)
    threshold = data.system.capture.cqi_threshold if data.system else None
    if cqi.known:
        axes.plot(cqi.time_s, cqi.value, color="#0072B2", linewidth=1.6)
        if threshold is not None:
            axes.axhline(threshold, color="#0072B2", linewidth=0.8, linestyle="--")
            axes.annotate(
                f"captured below {threshold:g}", (0.02, threshold), xycoords=("axes fraction", "data"), xytext=(0, 2),
                textcoords="offset points", fontsize=8, color="#0072B2",
            )  # fmt: skip
    else:
        axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", color="#0072B2")
    if mcqi.known:
        axes.plot(mcqi.time_s, mcqi.value, color="#0072B2", linewidth=1.2, linestyle="-.")
        last = int(np.flatnonzero(np.isfinite(mcqi.value))[-1])
        axes.annotate(
            "MCQI", (mcqi.time_s[last], mcqi.value[last]), xytext=(-2, 4), textcoords="offset points", ha="right",
            fontsize=8, color="#0072B2",
        )  # fmt: skip
    axes.set_ylabel("CQI [-]" if not mcqi.known else "CQI, MCQI (dash-dotted) [-]", color="#0072B2")
    below = _BAND if inside.known else 0.0
    axes.set_ylim(-below * _CQI_SHOWN, 1.05 * _CQI_SHOWN)
    if inside.known:
        _enclosed_band(axes, inside)
    _time_axis(axes, data)
    axes.set_title("Capture quality and locked pairs", fontsize=10, loc="left")
    right = axes.twinx()
    system = data.system
    if len(pairs.time_s):
        right.step(pairs.time_s, pairs.value, where="post", color="#D55E00", linewidth=1.6)
    if system is not None:
        required = system.capture.required_locked_pairs
        right.axhline(required, color="#D55E00", linewidth=0.8, linestyle="--")
        right.annotate(
            f"at least {required} needed", (0.02, required),
            xycoords=("axes fraction", "data"), xytext=(0, 2), textcoords="offset points", fontsize=8, color="#D55E00",
        )  # fmt: skip
        most = max(system.closing.max_locked_pairs, 1)
        right.set_ylim(-below * most, 1.05 * most)
    right.set_ylabel("locked pairs", color="#D55E00")
    mark_phases(axes, data)


def _enclosed_band(axes: Axes, inside: Curve) -> None:
    """A band below the curves: dark while the closed net goes round the whole debris, light while it does not."""
    steps = np.append(inside.time_s, inside.time_s[-1])
    for value, color, name in ((1.0, "#009E73", "enclosed"), (0.0, "0.85", "not enclosed")):
        where = np.append(inside.value, inside.value[-1]) == value
        if where.any():
            axes.fill_between(
                steps, -0.9 * _BAND * _CQI_SHOWN, -0.3 * _BAND * _CQI_SHOWN, where=where, step="post", color=color,
                linewidth=0.0, label=name,
            )  # fmt: skip
    axes.legend(loc="center left", fontsize=8, frameon=False)


def loads(axes: Axes, data: MissionData) -> None:
    """Largest tension over strength (left), force of contact and tension of the main tether (right) over time."""
    share, force, tether = (curve(data, series) for series in (data.load_share, data.contact, data.tether))
    if share.known:
        axes.plot(share.time_s, 100.0 * share.value, color="#0072B2", linewidth=1.0)
    else:
        axes.text(0.02, 0.5, "strength not known", transform=axes.transAxes, color="#0072B2")
    axes.set_ylabel("largest tension over strength [%]", color="#0072B2")
    axes.set_ylim(bottom=0.0)
    _time_axis(axes, data)
    axes.set_title("Loads", fontsize=10, loc="left")
    right = axes.twinx()
    for each, color, style, name in (
        (force, "#D55E00", "-", "contact on the debris"), (tether, "#7a5c00", "--", "main tether"),
    ):  # fmt: skip
        if each.known:
            right.plot(each.time_s, each.value, color=color, linewidth=1.0, linestyle=style, label=name, alpha=0.8)
    right.set_ylabel("force [N]", color="#D55E00")
    right.set_ylim(bottom=0.0)
    right.legend(loc="center left", fontsize=8, frameon=False)
    mark_phases(axes, data)


def _time_axis(axes: Axes, data: MissionData) -> None:
    axes.set_xlabel("time since launch [s]")
    axes.set_xlim(0.0, max(float(data.seconds(data.end_ns)), 0.1))
    axes.grid(alpha=0.25)


def new_figure(width: float, height: float) -> Figure:
    """A figure that needs no display.

    Args:
        width: [inch]
        height: [inch]
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure
