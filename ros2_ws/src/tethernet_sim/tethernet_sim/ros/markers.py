"""Pictures of the world for RViz."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from tethernet_core.layout import KNOT_ROWS
from tethernet_ros import topics
from tethernet_ros.conversions import set_stamp
from tethernet_sim.ros.messages import set_quaternion, set_xyz
from tethernet_sim.state import ATTITUDE, CHASER, DEBRIS, POSITION
from tethernet_sim.world import World

_NET = (0.15, 0.45, 0.85, 1.0)
_MU = (0.9, 0.35, 0.1, 1.0)
_DEBRIS = (0.6, 0.6, 0.6, 0.8)
_CHASER = (0.85, 0.7, 0.2, 0.9)


def serpentine() -> tuple[np.ndarray, np.ndarray]:
    """Knot numbers along the rows and along the columns, turning at every end: two lines that draw all threads."""
    index = np.arange(KNOT_ROWS * KNOT_ROWS).reshape(KNOT_ROWS, KNOT_ROWS)
    rows, columns = index.copy(), index.T.copy()
    rows[1::2] = rows[1::2, ::-1]
    columns[1::2] = columns[1::2, ::-1]
    return rows.ravel(), columns.ravel()


class Markers:
    """Net, MUs, debris, chaser and main tether."""

    def __init__(self, world: World):
        mus = len(world.model.arrays.mu_knot)
        # The markers share the Point objects: one write moves a knot in all of them.
        self._knots = [Point() for _ in range(KNOT_ROWS * KNOT_ROWS)]
        self._mus = [Point() for _ in range(mus)]
        self._anchor = Point()
        rows, columns = serpentine()
        radius, half_length = world.system.debris.shape.numbers.tolist()
        side = world.system.chaser.side_m
        threads = [
            end
            for mu, knot in zip(self._mus, world.model.arrays.mu_knot, strict=True)
            for end in (mu, self._knots[knot])
        ]
        cylinder = _marker("debris", Marker.CYLINDER, _DEBRIS, 2.0 * radius, 2.0 * half_length)
        cube = _marker("chaser", Marker.CUBE, _CHASER, side, side)
        self.message = MarkerArray(
            markers=[
                _line("rows", Marker.LINE_STRIP, _NET, [self._knots[i] for i in rows]),
                _line("columns", Marker.LINE_STRIP, _NET, [self._knots[i] for i in columns]),
                _line("mu_threads", Marker.LINE_LIST, _MU, threads),
                _line("tether", Marker.LINE_LIST, _CHASER, [self._anchor, self._knots[world.system.net.center_node]]),
                _marker("mus", Marker.CUBE_LIST, _MU, 0.4, 0.4),  # drawn larger than they are, to be seen
                cylinder,
                cube,
            ]
        )
        self.message.markers[4].points = self._mus
        self._bodies = ((cylinder, DEBRIS), (cube, CHASER))

    def fill(self, stamp_ns: int, world: World) -> MarkerArray:
        """The pictures of the present state."""
        state = world.state
        for points, places in ((self._knots, state.knot_pos[0].T.tolist()), (self._mus, state.mu_pos[0].tolist())):
            for point, (x, y, z) in zip(points, places, strict=True):
                point.x, point.y, point.z = x, y, z
        set_xyz(self._anchor, world.tether_anchor(0))
        for marker, body in self._bodies:
            set_xyz(marker.pose.position, state.bodies[0, body, POSITION].tolist())
            set_quaternion(marker.pose.orientation, state.bodies[0, body, ATTITUDE].tolist())
        for marker in self.message.markers:
            set_stamp(marker.header.stamp, stamp_ns)
        return self.message


def _marker(name: str, kind: int, color: Sequence[float], width: float, height: float) -> Marker:
    marker = Marker(ns=name, type=kind, action=Marker.ADD)
    marker.header.frame_id = topics.FRAME
    marker.scale.x, marker.scale.y, marker.scale.z = width, width, height
    marker.color = ColorRGBA(r=color[0], g=color[1], b=color[2], a=color[3])
    return marker


def _line(name: str, kind: int, color: Sequence[float], points: list[Point]) -> Marker:
    marker = _marker(name, kind, color, 0.03, 0.0)
    marker.scale.y = 0.0  # a line has but its width, x
    marker.points = points
    return marker
