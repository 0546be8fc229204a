"""Tools of the tests that talk over DDS: a probe that waits for events, processes whose exit status is checked."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import warnings
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_srvs.srv import Trigger

from tethernet_ros.connections import Connections, read_connections, service_name

PATIENCE_S = 30.0
"""Limit of every wait; reached only when something is broken."""
_ASK_AGAIN_S = 2.0


class Probe:
    """A node that publishes, listens and waits for events, in a context of its own."""

    def __init__(self, domain_id: int, name: str = "probe"):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain_id)
        self.node = rclpy.create_node(name, context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.received: dict[str, list] = defaultdict(list)
        self._publishers: dict[str, object] = {}
        self._connections_clients: dict[str, object] = {}

    def listen(self, topic: str, kind: type, qos: QoSProfile, callback: Callable | None = None) -> list:
        """Collect a topic's messages; returns the list that they go to."""

        def take(message) -> None:
            self.received[topic].append(message)
            if callback is not None:
                callback(message)

        self.node.create_subscription(kind, topic, take, qos)
        return self.received[topic]

    def publish(self, topic: str, message, qos: QoSProfile, reader: str = "") -> None:
        """Publish, the first time once both ends have found each other.

        Args:
            topic: where to.
            message: what.
            qos: of the publisher.
            reader: name of the node that shall hear it; a node of this project, which tells its connections.
        """
        if topic not in self._publishers:
            publisher = self._publishers[topic] = self.node.create_publisher(type(message), topic, qos)
            self.wait_for(lambda: publisher.get_subscription_count() >= 1, f"reader of {topic}")
            if reader:
                while not self._connections(reader).publishers.get(topic):
                    self.spin_for(0.01)
        self._publishers[topic].publish(message)

    def matched(self, topic: str, writer: str = "") -> None:
        """Wait until a publisher of a topic that is listened to is known.

        Args:
            topic: that is listened to.
            writer: name of the node that publishes, one of this project: then both ends have found each other.
        """
        self.wait_for(lambda: self.node.count_publishers(topic) >= 1, f"writer of {topic}")
        while writer and not self._connections(writer).subscribers.get(topic):
            self.spin_for(0.01)

    def _connections(self, node: str) -> Connections:
        if node not in self._connections_clients:
            self._connections_clients[node] = self.node.create_client(Trigger, service_name(node))
        client = self._connections_clients[node]
        self.wait_for(client.service_is_ready, f"connections of {node}")
        # An answer is lost where the server has not found this client's reader yet: ask again, as the command does.
        asked: list[Future] = []
        due = time.monotonic()

        def answered() -> bool:
            nonlocal due
            if time.monotonic() >= due:
                asked.append(client.call_async(Trigger.Request()))
                due += _ASK_AGAIN_S
            return any(future.done() for future in asked)

        self.wait_for(answered, f"connections of {node}")
        return read_connections(next(future.result() for future in asked if future.done()))

    def wait_for(self, condition: Callable[[], bool], what: str, timeout_s: float = PATIENCE_S) -> None:
        """Take messages until the condition holds.

        Raises:
            TimeoutError: naming what did not happen.
        """
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"{what}: did not happen within {timeout_s:g} s")
            self.executor.spin_once(timeout_sec=0.02)

    def spin_for(self, duration_s: float) -> None:
        """Take messages for a while: only to show that something does not happen."""
        deadline = time.monotonic() + duration_s
        while (left := deadline - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def call(self, name: str, kind: type, request=None):
        """Call a service; returns its response."""
        client = self.node.create_client(kind, name)
        self.wait_for(client.service_is_ready, f"service {name}")
        future = client.call_async(request or kind.Request())
        self.wait_for(future.done, f"answer of {name}")
        self.node.destroy_client(client)
        return future.result()

    def close(self) -> None:
        # Fast DDS 2.14 sometimes hangs where a participant leaves while others do: let those that end go first.
        # One that was killed never says that it has gone.
        deadline = time.monotonic() + 2.0
        while len(self.node.get_node_names()) > 1 and time.monotonic() < deadline:
            time.sleep(0.01)
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()


class Process:
    """A child process with its output in a file."""

    def __init__(self, name: str, command: list[str], folder: Path, environment: dict[str, str]):
        self.name, self.log = name, folder / f"{name}.log"
        with open(self.log, "wb") as log:
            self._popen = subprocess.Popen(
                command, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=True
            )
        self.expected: set[int] = {0}

    @property
    def output(self) -> str:
        return self.log.read_text(encoding="utf-8", errors="replace")

    @property
    def running(self) -> bool:
        return self._popen.poll() is None

    def send(self, number: signal.Signals) -> None:
        if self.running:
            self._popen.send_signal(number)

    def wait(self, timeout_s: float = PATIENCE_S) -> int:
        """The exit status; a process that does not end is killed and fails the test."""
        try:
            return self._popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self._popen.send_signal(signal.SIGABRT)  # faulthandler, where it is on, writes where the process stands
            time.sleep(0.5)
            self._popen.kill()
            self._popen.wait()
            raise AssertionError(f"{self.name} did not end within {timeout_s:g} s:\n{self.output}") from None

    def kill(self) -> None:
        """End it the hard way; that is then the expected end."""
        self.expected = {-signal.SIGKILL}
        self._popen.kill()
        self._popen.wait()


_hangs: list[str] = []
MOST_HANGS_IN_ALL = 2
"""In one run of the tests, which starts some hundred nodes."""


def count_hangs(nodes: list[str]) -> None:
    """Account for nodes that hung in the middleware after all that was their own to do, and were ended by SIGALRM.

    Only tethernet_ros.executor.bound_the_end sets that alarm, with nothing left but to leave the graph. It is
    the last resort against a known fault of Fast DDS: rare, said when it happens, and a failure when it is common.
    """
    for node in nodes:
        _hangs.append(node)
        warnings.warn(f"{node} hung in the middleware when it left, and was ended by SIGALRM", stacklevel=2)
    assert len(nodes) <= 1, f"hung in the middleware together: {nodes}"
    assert len(_hangs) <= MOST_HANGS_IN_ALL, f"the middleware hangs too often: {_hangs}"


class Processes:
    """Starts processes for one test, stops them with SIGINT at its end and checks how every one of them ended."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._all: list[Process] = []

    def start(self, name: str, *command: str, expected: int = 0, **environment: str) -> Process:
        """Start a Python program: ``start("planner", "-m", "tethernet_planner.planner_node", "--ros-args", ...)``.

        Args:
            name: of its log file.
            command: arguments of the interpreter.
            expected: the exit status it must end with.
            environment: variables set on top of the test's own.
        """
        full = {**os.environ, "ROS_LOG_DIR": str(self._folder), "PYTHONUNBUFFERED": "1", **environment}
        process = Process(name, [sys.executable, *command], self._folder, full)
        process.expected = {expected}
        self._all.append(process)
        return process

    def node(self, module: str, *parameters: str, name: str = "", **options) -> Process:
        """Start a node's module with parameters as ``"mu:=3"``."""
        arguments = [word for parameter in parameters for word in ("-p", parameter)]
        ros = ["--ros-args", *arguments] if arguments else []
        return self.start(name or module.rpartition(".")[2], "-m", module, *ros, **options)

    def stop(self) -> None:
        """Stop all and check their exit statuses and that no traceback was printed."""
        for process in self._all:
            process.send(signal.SIGINT)
        wrong, hung = [], []
        for process in self._all:
            status = process.wait()
            if status == -signal.SIGALRM and status not in process.expected:
                hung.append(process.name)
            elif status not in process.expected or "Traceback" in process.output:
                wrong.append(f"{process.name} ended with {status}, expected {process.expected}:\n{process.output}")
        assert not wrong, "\n\n".join(wrong)
        count_hangs(hung)
