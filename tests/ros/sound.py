"""Messages that keep their contracts, for tests that change one thing in them."""

from __future__ import annotations

import array

from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry

from tethernet_core.system import System
from tethernet_msgs.msg import MuStatus, NetState
from tethernet_ros import topics
from tethernet_ros.conversions import set_stamp


def net_state(system: System, stamp_ns: int, center=(0.0, 0.0, -10.0)) -> NetState:
    """A net of which all knots and units are in its centre."""
    x, y, z = center
    grid, knots = system.net.grid, system.net.node_count
    message = NetState(center_of_mass=Point(x=x, y=y, z=z))
    message.rows, message.columns = (0, 0) if grid is None else (grid.rows, grid.columns)
    message.header.frame_id = topics.FRAME
    set_stamp(message.header.stamp, stamp_ns)
    message.knot_positions = array.array("f", [x, y, z] * knots)
    message.knot_velocities = array.array("f", [0.0] * 3 * knots)
    message.mu_positions = array.array("f", [x, y, z] * system.unit_count)
    message.mu_velocities = array.array("f", [0.0] * 3 * system.unit_count)
    message.locked = [False] * system.closing.max_locked_pairs
    return message


def odometry(child: str, stamp_ns: int, place) -> Odometry:
    """A body that rests at a place."""
    message = Odometry(child_frame_id=child)
    message.header.frame_id = topics.FRAME
    set_stamp(message.header.stamp, stamp_ns)
    position = message.pose.pose.position
    position.x, position.y, position.z = place
    message.pose.pose.orientation.w = 1.0
    return message


def mu_status(mu: int, sequence: int, stamp_ns: int = 0) -> MuStatus:
    """A controller that echoes a state of the mission."""
    message = MuStatus(mu=mu, mission_sequence=sequence, aiming_source="x")
    message.header.frame_id = topics.FRAME
    set_stamp(message.header.stamp, stamp_ns)
    return message
