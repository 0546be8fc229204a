"""Log times: the mission's own clock, whatever a publisher stamps."""

import pytest
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from tethernet_bringup.bags.message_definitions import installed_type
from tethernet_bringup.recorder.recorded_topics import extra_topics, mission_topics
from tethernet_bringup.recorder.timeline import FARTHEST_NS, StampReader, Timeline
from tethernet_core.parameters import ParameterError

WALL_NS = 1_790_000_000_000_000_000


def reader(name):
    return StampReader.of(installed_type(name))


def stamped(message, header, sec, nanosec):
    header.stamp.sec, header.stamp.nanosec = sec, nanosec
    header.frame_id = "launch"
    return serialize_message(message)


def test_stamps_are_found_in_headers_clocks_and_arrays():
    odometry = Odometry()
    assert reader("nav_msgs/msg/Odometry")(stamped(odometry, odometry.header, 3, 50_000_000)) == 3_050_000_000
    clock = Clock()
    clock.clock.sec = 7
    assert reader("rosgraph_msgs/msg/Clock")(serialize_message(clock)) == 7_000_000_000
    transforms = TFMessage(transforms=[TransformStamped()])
    assert reader("tf2_msgs/msg/TFMessage")(stamped(transforms, transforms.transforms[0].header, 2, 1)) == 2_000_000_001


def test_every_topic_of_a_mission_has_a_stamp():
    assert all(reader(topic.type_name).offset is not None for topic in mission_topics(8))


def test_what_has_no_stamp_gives_none():
    assert reader("std_msgs/msg/String")(serialize_message(String(data="hello hello hello"))) is None
    assert reader("tf2_msgs/msg/TFMessage")(serialize_message(TFMessage())) is None
    odometry = Odometry()
    assert reader("nav_msgs/msg/Odometry")(stamped(odometry, odometry.header, -1, 0)) is None
    assert reader("nav_msgs/msg/Odometry")(stamped(odometry, odometry.header, 0, 0)) is None, "nobody has set it"
    assert reader("nav_msgs/msg/Odometry")(stamped(odometry, odometry.header, 0, 1)) == 1
    assert reader("nav_msgs/msg/Odometry")(b"\x00\x01\x00\x00\x01") is None


def test_a_message_is_logged_at_its_stamp():
    line = Timeline()
    assert line.log_time(5) is None
    line.tell(1_000, clock=False)
    assert line.log_time(5) == 5
    assert line.log_time(None) == 1_000


def test_another_clock_is_logged_at_the_missions_time():
    line = Timeline()
    line.tell(10_000_000_000, clock=True)
    assert line.log_time(WALL_NS) == 10_000_000_000
    line.tell(WALL_NS, clock=False)  # an odometry on the wall clock does not overrule /clock
    assert line.now == 10_000_000_000
    assert line.log_time(10_000_000_000 + FARTHEST_NS) == 10_000_000_000 + FARTHEST_NS


def test_without_clock_the_odometry_tells_the_time():
    line = Timeline()
    line.tell(WALL_NS, clock=False)
    line.tell(WALL_NS - 5, clock=False)
    line.tell(None, clock=False)
    assert line.now == WALL_NS
    assert line.log_time(None) == WALL_NS  # a state published before anybody knew the time


def test_extra_topics_are_read():
    first, second = extra_topics(" /a std_msgs/msg/String , /b/c nav_msgs/msg/Odometry latched,")
    assert (first.name, first.type_name, first.latched) == ("/a", "std_msgs/msg/String", False)
    assert (second.name, second.type_name, second.latched) == ("/b/c", "nav_msgs/msg/Odometry", True)
    assert extra_topics("") == []


@pytest.mark.parametrize("text", ["/a", "a std_msgs/msg/String", "/a std_msgs/msg/String forever", "/a b c d"])
def test_extra_topics_that_cannot_be_meant_are_named(text):
    with pytest.raises(ParameterError, match=r"extra_topics: .* cannot be read; allowed"):
        extra_topics(text)


def test_each_unit_has_three_topics():
    assert len(mission_topics(8)) - len(mission_topics(4)) == 12
    assert len(mission_topics(24)) - len(mission_topics(0)) == 72
    assert not any(topic.name.startswith("/mu") for topic in mission_topics(0))


@pytest.mark.parametrize("clock", [True, False])
def test_one_stamp_from_the_future_does_not_move_the_missions_time(clock):
    line = Timeline()
    for tick in range(100):
        line.tell(tick * 50_000_000, clock=clock)
        if tick == 50:
            line.tell(10**18, clock=clock)
            assert line.now == tick * 50_000_000
    assert line.now == 99 * 50_000_000
    for tick in range(60):
        line.tell(WALL_NS + tick * 50_000_000, clock=clock)
    assert line.now == WALL_NS + 59 * 50_000_000, "a clock that was really set anew is followed"
