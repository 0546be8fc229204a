"""Messages from the project's plain types; the way back is through :mod:`tethernet_ros.checks`."""

from __future__ import annotations

import math
from collections.abc import Iterable

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point

from tethernet_core.mission import Mission
from tethernet_core.shown import LONG, shown
from tethernet_msgs.msg import MissionState
from tethernet_ros.topics import FRAME

_SECOND_NS = 1_000_000_000

Vector = tuple[float, float, float]


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


def point_message(point: Iterable[float]) -> Point:
    """A new Point for x y z [m]."""
    x, y, z = point
    return Point(x=float(x), y=float(y), z=float(z))


def coordinates(point: Point) -> tuple[float, float, float]:
    """Numbers x y z [m] of a Point."""
    return (point.x, point.y, point.z)


def mission_message(mission: Mission, stamp_ns: int, confirmed: bool, reason: str = "") -> MissionState:
    """The mission as a message.

    Args:
        mission: what it tells.
        stamp_ns: odometry time the decision was made at [ns].
        confirmed: every reachable controller has echoed it.
        reason: replaces the mission's own where given (who did not confirm).
    """
    known = all(map(math.isfinite, mission.debris_position))  # it is not before the mission is armed
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
        debris_position=point_message(mission.debris_position if known else (0.0, 0.0, 0.0)),
        closing_points=[point_message(point) for point in mission.closing_points],
        closing_duration=float(mission.closing_duration_s),
        points_time=time_message(mission.points_ns),
        hold_duration=float(mission.hold_s),
        tow=float(mission.tow_n),
        hold_time=time_message(mission.hold_ns),
        hold_end_time=time_message(mission.hold_end_ns),
        docked_times=[time_message(time_ns) for time_ns in mission.docked_ns],
        reason=shown(reason or mission.reason, LONG),
    )
    set_stamp(message.header.stamp, stamp_ns)
    message.header.frame_id = FRAME
    return message
