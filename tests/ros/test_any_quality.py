"""What is published with less than what is asked for is heard all the same."""

import json
import signal

import pytest
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import Header

from tethernet_ros import any_quality, topics
from tethernet_ros.conversions import nanoseconds, set_stamp
from tethernet_ros.qos import CONTROL, RECORD_LATCHED, STATE_BACKLOG

from .graph import Probe

pytestmark = pytest.mark.ros
VOLATILE = QoSProfile(depth=10, reliability=QoSReliabilityPolicy.RELIABLE, durability=QoSDurabilityPolicy.VOLATILE)


@pytest.fixture
def other(domain_id):
    node = Probe(domain_id, "other")
    yield node
    node.close()


@pytest.mark.parametrize("offer", [qos_profile_sensor_data, VOLATILE])
@pytest.mark.parametrize("asked", [CONTROL, STATE_BACKLOG])
def test_every_publisher_is_heard_once(probe, other, asked, offer):
    heard = []
    any_quality.subscribe(probe.node, Header, "/told", lambda message: heard.append(message.frame_id), asked)
    weak = other.node.create_publisher(Header, "/told", offer)
    probe.wait_for(lambda: weak.publish(Header(frame_id="weak")) or "weak" in heard, "the weak offer")
    strong = other.node.create_publisher(Header, "/told", RECORD_LATCHED)
    probe.wait_for(lambda: strong.get_subscription_count() >= 1, "a match")
    probe.wait_for(lambda: strong.publish(Header(frame_id="strong")) or "strong" in heard, "the strong offer")
    heard.clear()
    for number in range(20):
        strong.publish(Header(frame_id=str(number)))
    probe.wait_for(lambda: "19" in heard, "the last one")
    assert [text for text in heard if text.isdigit()] == [str(number) for number in range(20)]


def test_a_controller_answers_a_driver_that_publishes_as_sensors_do(probe, processes):
    processes.node("tethernet_control.controller_node", "mu:=3", name="controller")
    thrust = probe.listen(topics.mu_thrust(3), WrenchStamped, CONTROL)
    odometry = probe.node.create_publisher(Odometry, topics.mu_odometry(3), qos_profile_sensor_data)
    message = Odometry(child_frame_id="mu3")
    message.header.frame_id = topics.FRAME
    message.pose.pose.orientation.w = 1.0
    ticks = iter(range(1, 10_000))

    def tell() -> None:
        set_stamp(message.header.stamp, next(ticks) * 50_000_000)
        odometry.publish(message)

    probe.wait_for(lambda: tell() or thrust, "thrust")
    assert nanoseconds(thrust[-1].header.stamp) % 50_000_000 == 0


def test_the_recorder_keeps_what_is_published_best_effort(probe, processes, tmp_path):
    recorder = processes.node(
        "tethernet_bringup.recorder.recorder_node", f"output:={tmp_path / 'bag'}", "system:=zenit_4mu"
    )
    odometry = probe.node.create_publisher(Odometry, topics.mu_odometry(3), qos_profile_sensor_data)
    probe.wait_for(lambda: odometry.get_subscription_count() == 1, "the recorder")
    for tick in range(1, 21):
        message = Odometry()
        set_stamp(message.header.stamp, tick * 50_000_000)
        odometry.publish(message)
        probe.spin_for(0.01)
    recorder.send(signal.SIGINT)
    assert recorder.wait() == 0
    assert json.loads((tmp_path / "recorder.json").read_text())["messages"]["/mu3/odom"] > 10
