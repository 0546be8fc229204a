"""Messages that tell of the world. Each object makes its message once and fills it again at every control tick."""

from __future__ import annotations

import array
from collections.abc import Iterable

import numpy as np
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from tethernet_core.layout import KNOT_ROWS
from tethernet_core.settings import ControlParameters
from tethernet_msgs.msg import NetState
from tethernet_ros import topics
from tethernet_ros.conversions import set_stamp
from tethernet_sim.state import ATTITUDE, CHASER, DEBRIS, POSITION
from tethernet_sim.world import World

UNKNOWN_VARIANCE = 1e6
"""Variance of what is not measured: an MU's attitude [rad^2] and angular rate [rad^2/s^2]."""


def set_xyz(target: Point | Vector3, values: Iterable[float]) -> None:
    """Write three Python floats into a Point or Vector3."""
    target.x, target.y, target.z = values


def set_quaternion(target: Quaternion, values: Iterable[float]) -> None:
    """Write x y z w, Python floats, into a Quaternion."""
    target.x, target.y, target.z, target.w = values


class MuOdometry:
    """An MU's measured position and velocity."""

    def __init__(self, mu: int, control: ControlParameters):
        self.message = Odometry()
        self.message.header.frame_id = topics.FRAME
        self.message.child_frame_id = topics.mu_frame(mu)
        self.message.pose.covariance[:] = _diagonal(control.position_sigma_m**2, UNKNOWN_VARIANCE)
        self.message.twist.covariance[:] = _diagonal(control.velocity_sigma_m_s**2, UNKNOWN_VARIANCE)

    def fill(self, stamp_ns: int, position: Iterable[float], velocity: Iterable[float]) -> Odometry:
        """The message for a measured position [m] and velocity [m/s]; the child's axes are those of frame launch."""
        set_stamp(self.message.header.stamp, stamp_ns)
        set_xyz(self.message.pose.pose.position, position)
        set_xyz(self.message.twist.twist.linear, velocity)
        return self.message


class BodyOdometry:
    """True motion of debris or chaser."""

    def __init__(self, body: int, frame: str):
        """Args:
        body: DEBRIS or CHASER.
        frame: its child frame.
        """
        self._body = body
        self.message = Odometry()
        self.message.header.frame_id = topics.FRAME
        self.message.child_frame_id = frame

    def fill(self, stamp_ns: int, world: World) -> Odometry:
        """The message for the body's present motion; the twist is in its own frame, as nav_msgs defines it."""
        position, attitude, linear, angular = world.body_motion(0, self._body)
        message = self.message
        set_stamp(message.header.stamp, stamp_ns)
        set_xyz(message.pose.pose.position, position)
        set_quaternion(message.pose.pose.orientation, attitude)
        set_xyz(message.twist.twist.linear, linear)
        set_xyz(message.twist.twist.angular, angular)
        return message


class NetStateMessage:
    """The whole net."""

    def __init__(self) -> None:
        self.message = NetState(rows=KNOT_ROWS, columns=KNOT_ROWS, center_of_mass_all_valid=True)
        self.message.header.frame_id = topics.FRAME

    def fill(self, stamp_ns: int, world: World) -> NetState:
        """The message for the net's present state."""
        message = self.message
        set_stamp(message.header.stamp, stamp_ns)
        set_xyz(message.center_of_mass, world.net_center(0))
        set_xyz(message.center_of_mass_all, world.net_center_all(0))
        # Buffers, not lists: setting long lists element by element is slow.
        message.knot_positions = _floats(world.knots_as_published(0))
        message.knot_velocities = _floats(world.knot_velocities_as_published(0))
        message.mu_positions = _floats(world.mus_as_published(0))
        message.mu_velocities = _floats(world.mu_velocities_as_published(0))
        message.locked = world.state.locked[0].tolist()
        message.tether_length, message.tether_tension = world.tether(0)
        return message


class Transforms:
    """/tf: where MUs, net centre, debris and chaser are."""

    def __init__(self, mu_count: int):
        self._frames = [topics.mu_frame(mu) for mu in range(1, mu_count + 1)] + ["net", "debris", "chaser"]
        self.message = TFMessage(transforms=[TransformStamped(child_frame_id=frame) for frame in self._frames])
        for transform in self.message.transforms:
            transform.header.frame_id = topics.FRAME

    def fill(self, stamp_ns: int, world: World) -> TFMessage:
        """The message for the present state."""
        bodies = world.state.bodies[0]
        places = [*world.state.mu_pos[0].tolist(), world.net_center(0), *bodies[:, POSITION].tolist()]
        for transform, place in zip(self.message.transforms, places, strict=True):
            set_stamp(transform.header.stamp, stamp_ns)
            set_xyz(transform.transform.translation, place)
        set_quaternion(self.message.transforms[-2].transform.rotation, bodies[DEBRIS, ATTITUDE].tolist())
        set_quaternion(self.message.transforms[-1].transform.rotation, bodies[CHASER, ATTITUDE].tolist())
        return self.message


def _diagonal(linear: float, angular: float) -> np.ndarray:
    return np.diag([linear] * 3 + [angular] * 3).ravel()


def _floats(values: np.ndarray) -> array.array[float]:
    return array.array("f", values.tobytes())
