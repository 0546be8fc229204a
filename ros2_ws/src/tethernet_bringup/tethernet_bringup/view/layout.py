"""How Rerun's window is laid out: the scene on the left, plots and words on the right."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tethernet_bringup.analysis.scene import Camera
from tethernet_bringup.view.snapshot import Snapshot

if TYPE_CHECKING:
    import rerun.blueprint

_PLOTS = {
    "distance": "distance [m]", "tracking_error": "tracking error [m]", "thrust": "thrust [N]", "fuel": "fuel [kg]",
    "cqi": "CQI [-]", "locked_pairs": "locked pairs",
}  # fmt: skip
_AWAY = 1.3
"""Distance of the eye from what it looks at, in lengths of the flight."""
_SHORTEST_M = 5.0


def layout(first: Snapshot) -> rerun.blueprint.Blueprint:
    """The layout for a mission.

    Args:
        first: its first moment that shows anything: the eye sees all of the flight from where it begins to the debris.
    """
    import rerun.blueprint as rrb

    begin = np.nanmean(first.units if first.knots is None else first.knots, axis=0)
    end = first.planned_debris if first.debris is None else first.debris.position
    end = begin if end is None else end
    middle, length = 0.5 * (begin + end), max(_SHORTEST_M, float(np.linalg.norm(end - begin)))
    eye = rrb.EyeControls3D(
        position=middle + _AWAY * length * Camera().axes[2], look_target=middle, eye_up=[0.0, 1.0, 0.0]
    )
    scene = rrb.Spatial3DView(origin="scene", name="flight", eye_controls=eye, line_grid=False)
    # The units' numbers in the scene have the colours of their lines: legends would only hide these.
    legend = rrb.PlotLegend(visible=False)
    plots = [
        rrb.TimeSeriesView(origin=f"plots/{name}", name=title, plot_legend=legend) for name, title in _PLOTS.items()
    ]
    pairs = [rrb.Horizontal(*plots[i : i + 2]) for i in range(0, len(plots), 2)]
    words = rrb.TextLogView(origin="events", name="events")
    return rrb.Blueprint(
        rrb.Horizontal(scene, rrb.Vertical(*pairs, words), column_shares=[3, 2]),
        rrb.TimePanel(state="collapsed", timeline="mission"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
    )
