"""Messages from and to the project's plain types, with the checks that stand at every node's edge."""

from __future__ import annotations

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry

from tethernet_control import rotation
from tethernet_control.mission import Mission, Phase
from tethernet_msgs.msg import MissionState

from .topics import FRAME

_SECOND_NS = 1_000_000_000

Vector = tuple[float, float, float]


class MessageError(ValueError):
    """A message breaks the contract of its topic and is not used."""


def nanoseconds(stamp: Time) -> int:
    """A stamp as one number [ns]; all arithmetic with stamps is done in these."""
    return stamp.sec * _SECOND_NS + stamp.nanosec


def set_stamp(stamp: Time, time_ns: int) -> None:
    """Write a time [ns] into a stamp that is there already."""
    stamp.sec, stamp.nanosec = divmod(time_ns, _SECOND_NS)


def time_message(time_ns: int) -> Time:
    """A new stamp for a time [ns]."""
    seconds, rest = divmod(time_ns, _SECOND_NS)
    return Time(sec=seconds, nanosec=rest)


def point_message(point) -> Point:
    """A new Point for x y z [m]."""
    x, y, z = point
    return Point(x=float(x), y=float(y), z=float(z))


def coordinates(point: Point) -> tuple[float, float, float]:
    """Numbers x y z [m] of a Point."""
    return (point.x, point.y, point.z)


def odometry_values(message: Odometry) -> tuple[int, Vector, Vector]:
    """What an odometry message says, in frame launch.

    The twist of nav_msgs/Odometry is in the child's frame: it is turned into frame launch where the attitude is not
    identity. Numbers that are not finite pass: their user drops and counts them.

    Args:
        message: nav_msgs/Odometry in frame launch.

    Returns:
        Stamp [ns], position [m], velocity [m/s], both in frame launch.

    Raises:
        MessageError: for another frame or a quaternion that is no attitude.
    """
    header, pose, linear = message.header, message.pose.pose, message.twist.twist.linear
    attitude = pose.orientation
    return checked_odometry(
        header.frame_id,
        nanoseconds(header.stamp),
        coordinates(pose.position),
        (attitude.x, attitude.y, attitude.z, attitude.w),
        (linear.x, linear.y, linear.z),
    )


def checked_odometry(
    frame: str, stamp_ns: int, position: Vector, attitude: tuple[float, float, float, float], velocity: Vector
) -> tuple[int, Vector, Vector]:
    """The rules of :func:`odometry_values`, on the message's parts.

    Raises:
        MessageError: likewise.
    """
    if frame != FRAME:
        raise MessageError(f"odometry in frame {frame!r}; allowed: {FRAME!r}")
    if attitude[3] != 1.0:  # the usual case costs one comparison and keeps the bits
        try:
            velocity = rotation.turned(rotation.unit(attitude), velocity)
        except ValueError as error:
            raise MessageError(str(error)) from error
    return stamp_ns, position, velocity


def finite(*values: float) -> bool:
    """True when every number is finite; a sum would do, were it not for overflow."""
    return all(map(math.isfinite, values))


def mission_message(mission: Mission, stamp_ns: int, confirmed: bool, reason: str = "") -> MissionState:
    """The mission as a message.

    Args:
        mission: what it tells.
        stamp_ns: odometry time the decision was made at [ns].
        confirmed: every reachable controller has echoed it.
        reason: replaces the mission's own where given (who did not confirm).
    """
    message = MissionState(
        phase=int(mission.phase),
        sequence=mission.sequence,
        confirmed=confirmed,
        mission_id=mission.mission_id,
        mu_count=mission.mu_count,
        policy=mission.policy,
        launch_time=time_message(mission.launch_ns),
        closing_time=time_message(mission.closing_ns),
        end_time=time_message(mission.end_ns),
        debris_position=point_message(mission.debris_position),
        closing_points=[point_message(point) for point in mission.closing_points],
        closing_duration=float(mission.closing_duration_s),
        points_time=time_message(mission.points_ns),
        docked_times=[time_message(time_ns) for time_ns in mission.docked_ns],
        reason=reason or mission.reason,
    )
    set_stamp(message.header.stamp, stamp_ns)
    message.header.frame_id = FRAME
    return message


def mission_from(message: MissionState) -> Mission:
    """The mission that a message tells of.

    Raises:
        MessageError: for a phase that does not exist, or closing points nobody can fly to.
    """
    try:
        phase = Phase(message.phase)
    except ValueError:
        raise MessageError(
            f"mission state {message.sequence} has phase {message.phase}; allowed: 0 to {max(Phase)}"
        ) from None
    points = tuple(coordinates(point) for point in message.closing_points)
    if points and (len(points) != message.mu_count or not all(finite(*point) for point in points)):
        raise MessageError(
            f"mission state {message.sequence} has closing points {points}; allowed: none, or a finite one for each MU"
        )
    if len(message.docked_times) not in (0, message.mu_count):
        raise MessageError(
            f"mission state {message.sequence} says of {len(message.docked_times)} MUs whether they have docked; "
            f"allowed: none or {message.mu_count}"
        )
    return Mission(
        mu_count=message.mu_count,
        phase=phase,
        sequence=message.sequence,
        mission_id=message.mission_id,
        policy=message.policy,
        launch_ns=nanoseconds(message.launch_time),
        closing_ns=nanoseconds(message.closing_time),
        end_ns=nanoseconds(message.end_time),
        debris_position=coordinates(message.debris_position),
        closing_points=points,
        closing_duration_s=message.closing_duration,
        points_ns=nanoseconds(message.points_time),
        docked_ns=tuple(map(nanoseconds, message.docked_times)),
        reason=message.reason,
    )
