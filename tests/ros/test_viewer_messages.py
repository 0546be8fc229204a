"""No message ends the viewer, and none holds its pictures up: a viewer in this process, fed with random bytes."""

import os
import random
from types import SimpleNamespace

import pytest
import rclpy
from rclpy.serialization import serialize_message

from tests.faults import hostile
from tests.ros.test_door import MANY, PERIOD, honest_messages
from tethernet_core.system import load_system
from tethernet_ros import topics
from tethernet_ros.polled import Polled

from .sound import net_state

pytest.importorskip("rerun")
from tethernet_bringup.view.viewer_node import Viewer  # needs it

pytestmark = pytest.mark.ros


@pytest.fixture
def viewer(monkeypatch, domain_id, tmp_path):
    """A viewer, and by topic the check of its messages and what waits to be taken."""
    waiting = {}
    subscribe = Polled.__init__

    def remember(polled, node, door, check, topic, *rest):
        subscribe(polled, node, door, check, topic, *rest)
        queue = []
        polled._subscription = SimpleNamespace(
            handle=SimpleNamespace(take_message=lambda *_: (queue.pop(0), None) if queue else None)
        )
        waiting[topic] = (check, queue)

    monkeypatch.setattr(Polled, "__init__", remember)
    monkeypatch.setattr(os, "nice", lambda _: 0)  # this process goes on with other tests
    rclpy.init(args=["--ros-args", "-p", f"output:={tmp_path / 'a.rrd'}"])
    made = Viewer()
    try:
        yield made, waiting
    finally:
        made.finish(lambda: False)
        made.destroy_node()
        rclpy.try_shutdown()
    assert made.fault == ""


def ill(generator, check, example):
    """Bytes that seldom keep the contract of a topic."""
    if example is None or generator.random() < 0.2:
        message = hostile.fill(check.kind(), generator)
    else:
        message = hostile.mutate(example, generator)
    data = serialize_message(message)
    return data[: generator.randrange(len(data))] if generator.random() < 0.1 else data


def test_no_message_ends_the_viewer_or_holds_its_pictures_up(viewer):
    made, waiting = viewer
    generator = random.Random("viewer")
    for count in range(MANY):
        honest = honest_messages(count // 10)
        topic = generator.choice(sorted(waiting))
        check, queue = waiting[topic]
        queue.append(ill(generator, check, honest.get(topic)))
        made.look()
    assert made._door.dropped > MANY // 3
    system, last = load_system("zenit_8mu"), 200
    for tick in range(last + 1):
        waiting[topics.NET_STATE][1].append(serialize_message(net_state(system, tick * PERIOD)))
        made.look()
    assert made._observer.newest_ns == last * PERIOD, "what is newest is newest"
