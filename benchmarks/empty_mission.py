"""The baseline's command, ``python -m benchmarks.empty_mission FILE``: starts the empty processes, lets them fly.

In the place of ``run_mission.py``: a node of its own that hears what the mission's command hears, asks every node
whether it has found the others, and tells the planner to start. Prints one line of JSON: when the first tick began
[s, time.monotonic], and how long it took from there to the last one [s].
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_srvs.srv import Trigger

from benchmarks.empty_node import SIM_STATUS, START, STATE, Description, message_class, nothing, quality

COMMAND = "run_mission"
TIMEOUT_S = 120.0
_SPIN_S = 0.05
_PULSE_S = 1.0


class EmptyCommand:
    """The command's own node."""

    def __init__(self, description: Description):
        rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(COMMAND, start_parameter_services=False)
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        self._states = 0
        self.launched_s = self.ended_s = 0.0
        heard = {STATE: self._on_state, SIM_STATUS: self._on_status}
        self._statuses = -(-description["ticks"] // description["topics"][SIM_STATUS]["every"]) + 1
        for topic in description["nodes"][COMMAND]["subscribes"]:
            described = description["topics"][topic]
            self._node.create_subscription(
                message_class(described["type"]), topic, heard.get(topic, nothing), quality(described), raw=True
            )
        self._start = self._node.create_client(Trigger, START)
        self._askers = {
            name: self._node.create_client(Trigger, f"/{name}/connections")
            for name in description["nodes"]
            if name != COMMAND
        }
        self._asked: dict[str, Future] = {}
        self._deadline = time.monotonic() + TIMEOUT_S

    def fly(self) -> None:
        """Wait for the graph, launch, wait for the end.

        Raises:
            TimeoutError: when it does not come.
        """
        missing = set(self._askers)
        while missing:
            missing -= self._ask(missing)
            self._spin("processes that find each other")
        answer = self._start.call_async(Trigger.Request())
        while not (answer.done() and self.ended_s):
            if time.monotonic() - self.launched_s > _PULSE_S:
                self._ask(set(self._askers))
            self._spin("the last tick")

    def _ask(self, names: set[str]) -> set[str]:
        """Ask nodes for their connections; returns those that have found theirs."""
        complete = set()
        for name in names:
            future = self._asked.get(name)
            if future is not None and future.done():
                del self._asked[name]
                if future.result().success:
                    complete.add(name)
            elif future is None and self._askers[name].service_is_ready():
                self._asked[name] = self._askers[name].call_async(Trigger.Request())
        return complete

    def _spin(self, awaited: str) -> None:
        self._executor.spin_until_future_complete(Future(), timeout_sec=_SPIN_S)
        if time.monotonic() > self._deadline:
            raise TimeoutError(f"no {awaited} within {TIMEOUT_S:g} s")

    def _on_state(self, _: bytes) -> None:
        self._states += 1
        if self._states == 2:
            self.launched_s = time.monotonic()

    def _on_status(self, _: bytes) -> None:
        self._statuses -= 1
        if not self._statuses:
            self.ended_s = time.monotonic()


def main() -> int:
    """Fly the empty mission; returns 0, 1 when it did not come to its end."""
    path = Path(sys.argv[1])
    description = json.loads(path.read_text(encoding="utf-8"))
    command = EmptyCommand(description)
    processes = [
        subprocess.Popen([sys.executable, "-P", *paths(), str(path), name, f"__node:={name}"], start_new_session=True)
        for name in description["nodes"]
        if name != COMMAND
    ]
    result: dict[str, Any] = {}
    try:
        command.fly()
        result = {"launched_s": command.launched_s, "wall_time_s": command.ended_s - command.launched_s}
    except TimeoutError as error:
        print(f"empty mission: {error}", file=sys.stderr)
    finally:
        for process in processes:
            process.send_signal(signal.SIGINT)
        for process in processes:
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
    print(json.dumps(result), flush=True)
    return 0 if result else 1


def paths() -> list[str]:
    """Starts an empty node from wherever this package lies: ``-P`` leaves out the working folder."""
    root = str(Path(__file__).resolve().parent.parent)
    start = f"import sys; sys.path.append({root!r}); from benchmarks.empty_node import main; sys.exit(main())"
    return ["-c", start]


if __name__ == "__main__":
    sys.exit(main())
