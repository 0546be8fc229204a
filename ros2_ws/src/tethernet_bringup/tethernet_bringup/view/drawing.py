"""Draws snapshots of a mission into a Rerun recording: the one place that says what is drawn, live and from a bag.

=====================  ==========================================================================================
entity                 what it is
=====================  ==========================================================================================
/scene/net/threads     all threads, line strips; /scene/net/knots its nodes; /scene/net/masses what is fixed to it
/scene/net/locked      closing pairs that hold
/scene/units           the units, each with its number; /scene/units/threads what they hang on
/scene/units/thrust    the commanded forces, arrows
/scene/debris          pose of its centre of mass; /scene/debris/shape its described shape
/scene/debris/planned  where the planner takes it to be, in missions in which nothing measures it
/scene/chaser          pose; /scene/chaser/shape; /scene/tether the main tether
/scene/aiming          points that the units fly to until closing; /scene/closing where they meet
/plots/...             distance, tracking_error, thrust, fuel, cqi, locked_pairs over the mission's time
/events                phases, verdicts, warnings, in words
=====================  ==========================================================================================

Frame launch, in metres; the time line ``mission`` counts from the launch, what was before it is at 0.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tethernet_bringup.analysis.scene import mu_color
from tethernet_bringup.view.layout import layout
from tethernet_bringup.view.snapshot import Pose, Snapshot
from tethernet_bringup.view.strands import strands
from tethernet_core.rotation import rotate
from tethernet_core.system import System

if TYPE_CHECKING:
    import rerun

TIMELINE = "mission"
_NET, _MASS, _LOCKED = (110, 150, 215), (160, 90, 190), (60, 200, 90)
_DEBRIS, _CHASER, _TETHER = (190, 180, 165), (225, 190, 100), (200, 160, 60)
_AIMING, _CLOSING = (250, 210, 60), (60, 200, 90)
_THIN, _THICK = 0.6, 1.5
"""Widths of lines on the screen [points], whatever the distance."""
_ARROW_SHARE = 0.4
"""Length of the arrow of the largest thrust along one axis, in widths of the flat net."""


class Drawing:
    """One mission in one recording."""

    def __init__(self, recording: rerun.RecordingStream, system: System):
        """Args:
        recording: gets it.
        system: that is flown.
        """
        import rerun

        self._rr: Any = rerun
        self._recording = recording
        self._system = system
        net, nodes = system.net, system.net.node_count
        self._strands = strands(net.threads, net.nodes)
        self._masses = np.array([mass.node for mass in net.point_masses], int)
        self._hang = np.array([unit.node for unit in system.units], int)
        self._pairs = system.closing.pairs if system.closing.ring else np.zeros((0, 2), int)
        self._particles = np.full((nodes + system.unit_count, 3), np.nan)
        width = float(np.ptp(net.nodes, axis=0).max())
        self._arrow_m_n = _ARROW_SHARE * width / max((unit.thrust_limit_n for unit in system.units), default=1.0)
        colors = [bytes.fromhex(mu_color(mu).lstrip("#")) for mu in range(1, system.unit_count + 1)]
        self._colors = np.array([list(color) for color in colors], np.uint8).reshape(-1, 3)
        self._numbers = [str(mu) for mu in range(1, system.unit_count + 1)]
        self._laid_out = False
        recording.set_log_time_enabled(False)
        recording.set_log_tick_enabled(False)
        self._draw_what_stays()

    def draw(self, snapshot: Snapshot) -> None:
        """Draw one moment."""
        if not self._laid_out and (snapshot.knots is not None or np.isfinite(snapshot.units).any()):
            self._laid_out = True
            self._recording.send_blueprint(layout(snapshot))
        for event in snapshot.events:
            self._set_time(event.time_ns)
            level = self._rr.TextLogLevel.WARN if event.warning else self._rr.TextLogLevel.INFO
            self._log("events", self._rr.TextLog(event.text, level=level))
        self._set_time(snapshot.time_ns)
        self._draw_body("scene/debris", snapshot.debris)
        measured = snapshot.debris is not None or not snapshot.time_ns  # what measures it does so from the launch on
        if not measured and snapshot.planned_debris is not None:
            self._points("scene/debris/planned", snapshot.planned_debris[None], _DEBRIS, 6.0, labels=["debris"])
        self._draw_body("scene/chaser", snapshot.chaser)
        if snapshot.knots is not None:
            self._draw_net(snapshot, snapshot.knots)
        if np.isfinite(snapshot.units).any():
            self._draw_units(snapshot)
        self._plot("distance", snapshot.distance)
        self._plot("cqi", snapshot.cqi)
        if len(self._pairs):
            self._plot("locked_pairs", snapshot.locked_pairs)

    def _draw_what_stays(self) -> None:
        rr, system = self._rr, self._system
        self._log("scene", rr.ViewCoordinates.RIGHT_HAND_Y_UP, static=True)
        vertices, faces = system.debris.shape.triangles()
        corners = vertices[faces.ravel()] - system.debris.center_of_mass
        sides = corners.reshape(-1, 3, 3)
        normals = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        shape = rr.Mesh3D(
            vertex_positions=corners.astype(np.float32),
            vertex_normals=np.repeat(normals, 3, axis=0).astype(np.float32),
            albedo_factor=_DEBRIS,
        )
        self._log("scene/debris/shape", shape, static=True)
        chaser = rr.Boxes3D(half_sizes=[[0.5 * system.chaser.side_m] * 3], colors=[_CHASER], fill_mode="solid")
        self._log("scene/chaser/shape", chaser, static=True)
        lines = {"distance": ["net to debris [m]"], "cqi": ["CQI [-]"], "locked_pairs": ["locked pairs"]}
        for name, titles in lines.items():
            self._log(f"plots/{name}", rr.SeriesLines(names=titles, widths=[_THICK]), static=True)
        if system.units:
            for name in ("tracking_error", "thrust", "fuel"):
                self._log(
                    f"plots/{name}",
                    rr.SeriesLines(names=[f"MU {number}" for number in self._numbers], colors=self._colors),
                    static=True,
                )

    def _draw_body(self, path: str, pose: Pose | None) -> None:
        if pose is not None:
            turn = self._rr.Quaternion(xyzw=pose.attitude)
            self._log(path, self._rr.Transform3D(translation=pose.position, quaternion=turn))

    def _draw_net(self, snapshot: Snapshot, knots: np.ndarray) -> None:
        system = self._system
        self._strips("scene/net/threads", [knots[strand] for strand in self._strands], _NET, _THIN)
        self._points("scene/net/knots", knots, _NET, 1.0)
        if len(self._masses):
            self._points("scene/net/masses", knots[self._masses], _MASS, 5.0)
        particles = self._particles
        particles[: len(knots)], particles[len(knots) :] = knots, snapshot.units
        if len(self._pairs):
            hold = particles[self._pairs[snapshot.locked]]
            self._strips("scene/net/locked", list(hold), _LOCKED, _THICK)
        if system.units:
            hang = np.stack([snapshot.units, knots[self._hang]], axis=1)
            self._strips("scene/units/threads", list(hang), _NET, _THIN)
        if system.tether.stiffness_n_m > 0.0 and snapshot.chaser is not None:
            chaser = snapshot.chaser
            anchor = chaser.position + rotate(chaser.attitude, np.array([0.0, 0.0, system.chaser.anchor_m]))
            self._strips("scene/tether", [np.stack([anchor, knots[system.net.center_node]])], _TETHER, _THICK)

    def _draw_units(self, snapshot: Snapshot) -> None:
        rr = self._rr
        units = rr.Points3D(
            snapshot.units, radii=rr.Radius.ui_points(5.0), colors=self._colors, labels=self._numbers, show_labels=True
        )
        self._log("scene/units", units)
        thrust = rr.Arrows3D(
            origins=snapshot.units, vectors=np.nan_to_num(self._arrow_m_n * snapshot.thrusts), colors=self._colors,
            radii=rr.Radius.ui_points(1.5),
        )  # fmt: skip
        self._log("scene/units/thrust", thrust)
        aims = snapshot.aiming_points[np.isfinite(snapshot.aiming_points).all(axis=1)]
        self._points("scene/aiming", aims, _AIMING, 4.0)
        self._points("scene/closing", snapshot.closing_points, _CLOSING, 6.0)
        self._plot("tracking_error", snapshot.tracking_errors)
        self._plot("thrust", np.linalg.norm(snapshot.thrusts, axis=1))
        self._plot("fuel", snapshot.fuel)

    def _plot(self, name: str, values: float | np.ndarray) -> None:
        if np.isfinite(values).any():
            self._log(f"plots/{name}", self._rr.Scalars(values))

    def _points(
        self, path: str, points: np.ndarray, color: tuple[int, int, int], size: float, labels: list[str] | None = None
    ) -> None:
        radius = self._rr.Radius.ui_points(size)
        self._log(path, self._rr.Points3D(points, radii=radius, colors=[color], labels=labels))

    def _strips(self, path: str, strips: list[np.ndarray], color: tuple[int, int, int], width: float) -> None:
        radius = self._rr.Radius.ui_points(width)
        self._log(path, self._rr.LineStrips3D(strips, radii=[radius], colors=[color]))

    def _log(self, path: str, what: Any, static: bool = False) -> None:
        self._recording.log(path, what, static=static)

    def _set_time(self, time_ns: int) -> None:
        self._recording.set_time(TIMELINE, duration=np.timedelta64(time_ns, "ns"))
