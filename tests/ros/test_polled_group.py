"""Polled subscriptions wake nobody, whichever executor runs the node, and lose nothing until they are looked at."""

from __future__ import annotations

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data
from rclpy.task import Future
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from tethernet_ros import checks, topics
from tethernet_ros.connections import read_connections, serve_connections, service_name
from tethernet_ros.conversions import set_stamp
from tethernet_ros.door import Door
from tethernet_ros.polled_group import PollingNode
from tethernet_ros.qos import CONTROL

pytestmark = pytest.mark.ros
experimental = pytest.importorskip("rclpy.experimental")
TOPIC, AWAKE = "/beat", "/awake"


def beat(number: int, frame: str = topics.FRAME) -> Header:
    message = Header(frame_id=frame)
    set_stamp(message.stamp, number)
    return message


class Polling:
    """A node that polls one topic and is woken by another."""

    def __init__(self, domain_id: int, executor: type):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain_id)
        self.node = PollingNode("polling", context=self.context)
        serve_connections(self.node)
        self.executor = executor(context=self.context)
        self.heard: list[int] = []
        self.awake: list[int] = []
        self.drops = 0
        self.door = Door(self.node)
        self.look = self.door.poll(checks.HEARTBEAT, TOPIC, self.heard.append, CONTROL, self._on_drop)
        self.door.subscribe(checks.HEARTBEAT, AWAKE, self.awake.append, CONTROL)
        self.executor.add_node(self.node)

    def _on_drop(self) -> None:
        self.drops += 1

    def spin(self) -> None:
        self.executor.spin_until_future_complete(Future(), timeout_sec=0.02)


@pytest.fixture(params=[experimental.EventsExecutor, SingleThreadedExecutor], ids=["events", "single"])
def polling(request, domain_id):
    node = Polling(domain_id, request.param)
    yield node
    node.executor.remove_node(node.node)
    node.node.destroy_node()
    rclpy.shutdown(context=node.context)


def tell(probe, polling, numbers, publisher) -> None:
    """Publish on the polled topic, then wake the node by the other."""
    for number in numbers:
        publisher.publish(beat(number))
    awake = probe.node.create_publisher(Header, AWAKE, CONTROL)
    probe.wait_for(lambda: polling.spin() or awake.get_subscription_count() == 1, "the node")
    probe.wait_for(lambda: awake.publish(beat(1)) or polling.spin() or polling.awake, "the node is woken")


def test_what_has_come_waits_until_it_is_looked_at(probe, polling):
    publisher = probe.node.create_publisher(Header, TOPIC, CONTROL)
    probe.wait_for(lambda: polling.spin() or publisher.get_subscription_count() == 1, "the node")
    probe.wait_for(lambda: polling.spin() or polling.node.count_publishers(TOPIC) == 1, "the publisher")
    first = 0

    def arrived() -> bool:
        nonlocal first
        first += 1
        publisher.publish(beat(first))
        polling.look()
        return bool(polling.heard)

    probe.wait_for(arrived, "both ends have found each other")
    polling.look()
    polling.heard.clear()
    tell(probe, polling, range(1000, 1020), publisher)
    publisher.publish(beat(2000, "moon"))
    publisher.publish(beat(3000))
    assert polling.heard == []
    probe.wait_for(lambda: polling.spin() or polling.look() or 3000 in polling.heard, "the last one")
    assert [number for number in polling.heard if number >= 1000] == [*range(1000, 1020), 3000]
    assert (polling.drops, polling.door.counts[TOPIC]) == (1, 1)


def test_the_node_tells_of_the_publishers_that_it_polls(probe, polling):
    probe.node.create_publisher(Header, TOPIC, CONTROL)
    probe.wait_for(lambda: polling.spin() or polling.node.count_publishers(TOPIC) == 1, "the publisher")
    client = probe.node.create_client(Trigger, service_name("polling"))
    probe.wait_for(lambda: polling.spin() or client.service_is_ready(), "the service")

    def told() -> bool:
        answer = client.call_async(Trigger.Request())
        probe.wait_for(lambda: polling.spin() or answer.done(), "the answer")
        return read_connections(answer.result()).publishers.get(TOPIC) == 1

    probe.wait_for(told, "the polled topic's publisher")


def test_a_publisher_that_offers_less_is_polled_all_the_same(probe, polling):
    weak = probe.node.create_publisher(Header, TOPIC, qos_profile_sensor_data)
    probe.wait_for(
        lambda: weak.publish(beat(7)) or polling.spin() or polling.look() or 7 in polling.heard, "the weak offer"
    )
    polling.heard.clear()
    for number in range(100, 105):
        weak.publish(beat(number))
    probe.wait_for(lambda: polling.spin() or polling.look() or 104 in polling.heard, "the last one")
    assert [number for number in polling.heard if number >= 100] == [*range(100, 105)]
