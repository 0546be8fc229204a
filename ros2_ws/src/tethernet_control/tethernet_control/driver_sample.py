"""One odometry message as the driver contract looks at it, whether a controller would take it or not."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

from tethernet_control.driver_contract import Sample
from tethernet_ros.checks import Check
from tethernet_ros.conversions import coordinates, nanoseconds
from tethernet_ros.serialized import decoded

DRIVER_ODOMETRY: Check[Odometry] = Check(Odometry, lambda data: decoded(data, Odometry))
"""nav_msgs/Odometry whatever it says: for those who judge the driver."""

CLOCK: Check[int] = Check(Clock, lambda data: nanoseconds(decoded(data, Clock).clock))
"""rosgraph_msgs/Clock: the time [ns]."""


def driver_sample(message: Odometry, arrival_s: float, clock_ns: int | None) -> Sample:
    """What a driver said.

    Args:
        message: as it came.
        arrival_s: when, on the wall clock [s].
        clock_ns: when, on the mission's clock [ns]; None where that is not known.
    """
    pose, twist = message.pose, message.twist
    attitude = pose.pose.orientation
    linear = twist.twist.linear
    return Sample(
        arrival_s=arrival_s,
        stamp_ns=nanoseconds(message.header.stamp),
        frame=message.header.frame_id,
        child_frame=message.child_frame_id,
        position=coordinates(pose.pose.position),
        attitude=(attitude.x, attitude.y, attitude.z, attitude.w),
        velocity=(linear.x, linear.y, linear.z),
        pose_variances=_variances(pose.covariance),
        twist_variances=_variances(twist.covariance),
        clock_ns=clock_ns,
    )


def _variances(covariance: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    return (float(covariance[0]), float(covariance[7]), float(covariance[14]))
