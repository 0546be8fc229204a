"""Run by ``colcon test``: what the build has installed lies where ROS 2 looks for it, and works."""

from __future__ import annotations

from ament_index_python.packages import get_package_prefix
from rclpy.serialization import deserialize_message, serialize_message

from tethernet_msgs.msg import MissionState
from tethernet_ros import topics


def test_the_messages_are_those_of_this_workspace_and_travel():
    assert get_package_prefix("tethernet_msgs")
    state = MissionState(phase=MissionState.DEPLOYING)
    assert deserialize_message(serialize_message(state), MissionState) == state
    assert topics.mu_thrust(3) == "/mu3/thrust"
