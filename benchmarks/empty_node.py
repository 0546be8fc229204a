"""One process of the baseline: a mission's node with empty callbacks, ``python -m benchmarks.empty_node FILE NAME``.

It imports what every node needs, rclpy and the messages, and nothing else. It has the mission node's publishers,
subscriptions, timers and services, takes part in the lock-step hand-shake, and answers at once with constant bytes,
those that the mission itself has published last. What a mission costs beyond this is its own work.
"""

from __future__ import annotations

import base64
import functools
import importlib
import json
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_srvs.srv import Trigger

SIM, PLANNER, RECORDER = "sim", "planner", "recorder"
START, PLAN = "/planner/start", "/planner/plan_aiming_points"
STATE, HEARTBEAT, NET_STATE, SIM_STATUS = "/mission/state", "/planner/heartbeat", "/net/state", "/sim/status"
RECORDER_DEPTH = 1000
_SPIN_S = 1.0

Description = dict[str, Any]
"""What :mod:`benchmarks.empty_graph` has written down: topics and nodes."""

_stopped = False


def message_class(name: str) -> Any:
    """The class of a message or service type such as ``nav_msgs/msg/Odometry``."""
    package, kind, short = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), short)


def quality(topic: Description, depth: int | None = None) -> QoSProfile:
    """Quality of service of a topic; ``depth`` where a subscription keeps more than the publisher."""
    latched = topic["latched"]
    return QoSProfile(
        history=QoSHistoryPolicy.KEEP_LAST,
        depth=depth or topic["depth"],
        reliability=QoSReliabilityPolicy.RELIABLE,
        durability=QoSDurabilityPolicy.TRANSIENT_LOCAL if latched else QoSDurabilityPolicy.VOLATILE,
    )


class Outlet:
    """One publisher and the bytes that it publishes, every so many rounds."""

    def __init__(self, publisher: Publisher, topic: Description):
        self._publisher = publisher
        self._data = base64.b64decode(topic["data"])
        self._every = topic["every"]
        self._round = 0

    def now(self) -> None:
        """Publish."""
        self._publisher.publish(self._data)

    def due(self) -> None:
        """Publish if it is this round's turn."""
        if self._every and self._round % self._every == 0:
            self._publisher.publish(self._data)
        self._round += 1


class EmptyNode(Node):
    """A node with the endpoints of the mission's; its callbacks count and answer, no more."""

    def __init__(self, name: str, description: Description):
        super().__init__(name)
        self.graph, own = description, description["nodes"][name]
        kinds = {topic: message_class(described["type"]) for topic, described in description["topics"].items()}
        self.outlets = {
            topic: Outlet(
                self.create_publisher(kinds[topic], topic, quality(description["topics"][topic])),
                description["topics"][topic],
            )
            for topic in own["publishes"]
        }
        heard = self.callbacks()
        depth = RECORDER_DEPTH if name == RECORDER else None
        self.inlets = [
            self.create_subscription(
                kinds[topic], topic, heard.get(topic, nothing), quality(description["topics"][topic], depth), raw=True
            )
            for topic in own["subscribes"]
        ]
        self.kinds = [kinds[topic] for topic in own["subscribes"]]
        self._wanted = own["wanted"]
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        for period in own["timers"]:
            self.create_timer(period, lambda: None, clock=wall)
        self.create_service(Trigger, f"/{name}/connections", self._connected)

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        """What happens when a message arrives, by topic; nothing for the others."""
        return {}

    def _connected(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = all(
            publisher.get_subscription_count() >= self._wanted.get(publisher.topic_name, 0)
            for publisher in self.publishers
        )
        return response


def nothing(_: bytes) -> None:
    """The empty callback."""


class Sim(EmptyNode):
    """Publishes a tick when the commands and the heartbeat of the last one are in."""

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        self._states = self._ticks = self._pending = 0
        commands = [topic for topic in self.graph["nodes"][SIM]["subscribes"] if topic not in (STATE, HEARTBEAT)]
        self._answers = len(commands) + 1
        return {STATE: self._on_state, HEARTBEAT: self._on_answer, **dict.fromkeys(commands, self._on_answer)}

    def _on_state(self, _: bytes) -> None:
        self._states += 1
        if self._states == 2:  # the first one arms, the second one launches
            self._tick()

    def _on_answer(self, _: bytes) -> None:
        self._pending -= 1
        if not self._pending:
            self._tick()

    def _tick(self) -> None:
        self._ticks += 1
        self._pending = self._answers
        if self._ticks > self.graph["ticks"]:
            self.outlets[SIM_STATUS].now()  # behind the last: the mission is over
            return
        for outlet in self.outlets.values():
            outlet.due()


class Planner(EmptyNode):
    """Starts the mission and answers every complete tick with a heartbeat."""

    def __init__(self, name: str, description: Description):
        super().__init__(name, description)
        self._echoes: set[str] = set()
        self.create_service(Trigger, START, self._on_start)
        kind = message_class(description["plan_type"])
        self.create_service(kind, PLAN, lambda _, response: response)

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        subscribes = self.graph["nodes"][PLANNER]["subscribes"]
        statuses = [topic for topic in subscribes if topic.endswith("/status")]
        measured = [topic for topic in subscribes if topic not in statuses]
        self._measurements, self._count, self._controllers = len(measured), 0, len(statuses)
        self._started = self._launched = False
        return {
            **dict.fromkeys(measured, self._on_measurement),
            **{topic: functools.partial(self._on_status, topic) for topic in statuses},
        }

    def _on_start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._started = True
        self.outlets[STATE].now()
        self._launch()
        response.success = True
        return response

    def _on_status(self, topic: str, _: bytes) -> None:
        if self._started and not self._launched:
            self._echoes.add(topic)
            self._launch()

    def _launch(self) -> None:
        if not self._launched and len(self._echoes) == self._controllers:
            self._launched = True
            self.outlets[STATE].now()

    def _on_measurement(self, _: bytes) -> None:
        self._count += 1
        if self._count == self._measurements:
            self._count = 0
            self.outlets[HEARTBEAT].now()


class Controller(EmptyNode):
    """Asks for its aiming point, then answers every odometry with thrust, and now and then with its status."""

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        mu = f"/{self.get_name().removesuffix('_controller')}"
        self._asked = False
        self._status_topic = f"{mu}/status"
        self._kind = message_class(self.graph["plan_type"])
        self._plans = self.create_client(self._kind, PLAN)
        return {STATE: self._on_state, f"{mu}/odom": self._on_odometry}

    def _on_state(self, _: bytes) -> None:
        if not self._asked:
            self._asked = True
            self._plans.call_async(self._kind.Request()).add_done_callback(self._on_plan)

    def _on_plan(self, _: Future) -> None:
        self.outlets[self._status_topic].now()

    def _on_odometry(self, _: bytes) -> None:
        for outlet in self.outlets.values():
            outlet.due()


class Assessor(EmptyNode):
    """Reports now and then on the net's state."""

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        return {NET_STATE: self._on_net}

    def _on_net(self, _: bytes) -> None:
        for outlet in self.outlets.values():
            outlet.due()


def node_class(name: str) -> type[EmptyNode]:
    """What stands in for the node of this name."""
    if name.endswith("_controller"):
        return Controller
    return {SIM: Sim, PLANNER: Planner, RECORDER: EmptyNode}.get(name, Assessor)


def spin(node: Node) -> None:
    """Run the callbacks on the executor of the mission's nodes, see :mod:`tethernet_ros.executor`."""
    executor = EventsExecutor()
    executor.add_node(node)
    while rclpy.ok() and not _stopped:
        executor.spin_until_future_complete(Future(), timeout_sec=_SPIN_S)


def record(node: EmptyNode, period_s: float) -> None:
    """Empty the queues as the mission's recorder does, without an executor, and throw away what was in them."""
    answers = SingleThreadedExecutor()
    answers.add_node(node)
    takes = [(inlet.handle.take_message, kind) for inlet, kind in zip(node.inlets, node.kinds, strict=True)]
    while not _stopped:
        for take, kind in takes:
            while take(kind, True) is not None:
                pass
        answers.spin_once(timeout_sec=0.0)
        time.sleep(period_s)


def main() -> int:
    """Run the node until a signal comes."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _on_signal)
    path, name = sys.argv[1:3]
    description = json.loads(Path(path).read_text(encoding="utf-8"))
    rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], signal_handler_options=SignalHandlerOptions.NO)
    node = node_class(name)(name, description)
    if name == RECORDER:
        record(node, description["take_period_s"])
    else:
        spin(node)
    return 0


def _on_signal(_number: int, _frame: FrameType | None) -> None:
    global _stopped
    _stopped = True


if __name__ == "__main__":
    sys.exit(main())
