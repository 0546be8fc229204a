"""Pictures of the world for RViz, Foxglove and Rerun: whatever net, units, debris and chaser the system has.

Markers are named by a namespace each, with the id 0, and vanish by themselves when no more come. Their colours are
opaque enough to be seen, their quaternions normalised, and no scale is set that a marker's type does not use: RViz
warns of all that.
"""

from __future__ import annotations

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from tethernet_core.rotation import matrix
from tethernet_core.settings import NANOSECOND_S
from tethernet_core.system import System
from tethernet_ros import qos, topics
from tethernet_ros.door import Door
from tethernet_ros.template import Template
from tethernet_sim.state import ATTITUDE, CHASER, DEBRIS, POSITION
from tethernet_sim.world import World

Color = tuple[float, float, float, float]

_FLOAT_BYTES = 4
_SHOWN_PERIODS = 10
"""A marker is shown for so many times the period of pictures: viewers may be late, and a simulation slow."""

_NET: Color = (0.15, 0.45, 0.85, 1.0)
_UNIT: Color = (0.9, 0.35, 0.1, 1.0)
_MASS: Color = (0.5, 0.25, 0.6, 1.0)
_DEBRIS: Color = (0.6, 0.6, 0.6, 0.8)
_CHASER: Color = (0.85, 0.7, 0.2, 0.9)
_LINE_SHARE, _SEEN_SHARE = 0.0014, 0.018
"""Width of a line, and of what would be too small to be seen, in widths of the flat net."""


class Pictures:
    """All pictures of the world, each on its topic."""

    def __init__(self, system: System, period_s: float, door: Door):
        """Args:
        system: that is flown.
        period_s: time between two pictures [s].
        door: the node's own.
        """
        self._pictures = (
            (Markers(system, _SHOWN_PERIODS * period_s), door.publish(MarkerArray, topics.NET_MARKERS, qos.BULK)),
            (NetPoints(system), door.publish(PointCloud2, topics.NET_POINTS, qos.BULK)),
        )

    def publish(self, stamp_ns: int, world: World) -> None:
        """Publish those of the present state."""
        for picture, publisher in self._pictures:
            publisher.publish_template(picture.fill(stamp_ns, world))


class Markers:
    """Net, units, masses, debris, chaser and main tether; particles are numbered nodes first, then units."""

    def __init__(self, system: System, lifetime_s: float):
        """Args:
        system: that is flown.
        lifetime_s: so long each picture is shown if no other comes [s].
        """
        net = system.net
        self._anchor = system.particle_count
        """Index of the main tether's end at the chaser, behind all particles."""
        markers, drawn = _drawn(system, self._anchor)
        for marker in markers:
            marker.lifetime = _duration(lifetime_s)
        template = self._template = Template(MarkerArray(markers=markers))
        self._points = [
            (template.doubles(f"markers[{i}].points[0].x", 3 * len(indices)).reshape(-1, 3), indices)
            for i, indices in enumerate(drawn)
            if len(indices)
        ]
        self._places = np.zeros((self._anchor + 1, 3))
        self._node_count = net.node_count
        names = [marker.ns for marker in markers]
        self._bodies = [
            (
                template.doubles(f"markers[{names.index(name)}].pose.position.x", 3),
                template.doubles(f"markers[{names.index(name)}].pose.orientation.x", 4),
                body,
                offset,
            )
            for name, body, offset in (
                ("debris", DEBRIS, -system.debris.center_of_mass),
                ("chaser", CHASER, np.zeros(3)),
            )
        ]

    def fill(self, stamp_ns: int, world: World) -> Template:
        """The pictures of the present state."""
        state, places = world.state, self._places
        places[: self._node_count] = state.knot_pos[0].T
        places[self._node_count : self._anchor] = state.mu_pos[0]
        places[self._anchor] = world.tether_anchor(0)
        for points, indices in self._points:
            points[:] = places[indices]
        for position, orientation, body, offset in self._bodies:
            attitude = state.bodies[0, body, ATTITUDE]
            position[:] = state.bodies[0, body, POSITION] + matrix(attitude) @ offset
            orientation[:] = attitude
        self._template.stamp(stamp_ns)
        return self._template


class NetPoints:
    """The net's nodes as a cloud of points, which viewers draw that know no markers."""

    def __init__(self, system: System):
        """Args:
        system: whose net it is.
        """
        count = system.net.node_count
        message = PointCloud2(height=1, width=count, is_bigendian=False, is_dense=True)
        message.header.frame_id = topics.FRAME
        message.fields = [
            PointField(name=name, offset=axis * _FLOAT_BYTES, datatype=PointField.FLOAT32, count=1)
            for axis, name in enumerate("xyz")
        ]
        message.point_step = len(message.fields) * _FLOAT_BYTES
        message.row_step = count * message.point_step
        message.data = bytes(message.row_step)
        self._template = Template(message)
        self._points = self._template.floats("data[0]", 3 * count).reshape(-1, 3)

    def fill(self, stamp_ns: int, world: World) -> Template:
        """The cloud of the present state."""
        self._points[:] = world.knots_as_published(0)
        self._template.stamp(stamp_ns)
        return self._template


def _drawn(system: System, anchor: int) -> tuple[list[Marker], list[np.ndarray]]:
    """All markers, and for each one the particles that its points are; none where its points stay as they are."""
    net, nodes = system.net, system.net.node_count
    width = float(np.ptp(net.nodes, axis=0).max())
    line, seen = _LINE_SHARE * width, _SEEN_SHARE * width
    side = system.chaser.side_m
    still = np.zeros(0, int)
    result = [
        (_line("net", _NET, line), net.threads.ravel()),
        (surface("debris", system), still),
        (_marker("chaser", Marker.CUBE, _CHASER, side, side, side), still),
    ]
    if system.units:
        hang = [number for m, unit in enumerate(system.units) for number in (nodes + m, unit.node)]
        result.append((_line("unit_threads", _UNIT, line), np.array(hang)))
    boxes: dict[tuple[float, ...], list[int]] = {}
    for m, unit in enumerate(system.units):
        boxes.setdefault(unit.box_m, []).append(nodes + m)
    for number, (box, units) in enumerate(boxes.items()):
        larger = max(1.0, seen / max(box))
        name = "units" if len(boxes) == 1 else f"units{number}"
        scale = tuple(larger * length for length in box)
        result.append((_marker(name, Marker.CUBE_LIST, _UNIT, *scale), np.array(units)))
    if net.point_masses:
        masses = np.array([mass.node for mass in net.point_masses])
        result.append((_marker("masses", Marker.SPHERE_LIST, _MASS, seen, seen, seen), masses))
    if system.tether.stiffness_n_m > 0.0:
        result.append((_line("tether", _CHASER, line), np.array([anchor, net.center_node])))
    for marker, particles in result:
        if len(particles):
            marker.points = [Point() for _ in particles]
    return [marker for marker, _ in result], [particles for _, particles in result]


def surface(name: str, system: System) -> Marker:
    """The debris' surface as triangles, in the frame of its shape."""
    vertices, faces = system.debris.shape.triangles()
    marker = _marker(name, Marker.TRIANGLE_LIST, _DEBRIS, 1.0, 1.0, 1.0)
    corners = [Point(x=x, y=y, z=z) for x, y, z in vertices.tolist()]
    marker.points = [corners[corner] for corner in faces.ravel().tolist()]
    return marker


def _marker(name: str, kind: int, color: Color, x: float, y: float, z: float) -> Marker:
    marker = Marker(ns=name, type=kind, action=Marker.ADD)
    marker.header.frame_id = topics.FRAME
    marker.scale.x, marker.scale.y, marker.scale.z = x, y, z
    marker.color = ColorRGBA(r=color[0], g=color[1], b=color[2], a=color[3])
    return marker


def _duration(time_s: float) -> Duration:
    seconds, rest = divmod(round(time_s / NANOSECOND_S), 1_000_000_000)
    return Duration(sec=seconds, nanosec=rest)


def _line(name: str, color: Color, width: float) -> Marker:
    return _marker(name, Marker.LINE_LIST, color, width, 0.0, 0.0)  # a line has but its width, x
