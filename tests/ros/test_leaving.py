"""However a node's process ends, it leaves the graph first.

One that ends with a participant dies with that participant's threads in the middle of whatever they do: now and then
with the lock of a queue in shared memory, on which all others then wait for seconds.
"""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.ros

PROGRAM = """
import os, signal, sys
from nav_msgs.msg import Odometry
from rclpy.node import Node
from tethernet_ros import checks, qos
from tethernet_ros.door import Door
from tethernet_ros.executor import run
from tethernet_ros.parameters import NODE_OPTIONS

HOW = sys.argv[1]


def threads():
    folder = "/proc/self/task"
    names = [open(f"{folder}/{task}/comm").read().strip() for task in os.listdir(folder)]
    return sorted(name for name in names if name.startswith("dds.") and name != "dds.shm.wdog")


def interrupt():
    os.kill(os.getpid(), signal.SIGINT)


class Leaver(Node):
    def __init__(self):
        super().__init__("leaver", **NODE_OPTIONS)
        door = Door(self)
        self.out = door.publish(Odometry, "/mu1/odometry", qos.CONTROL)
        assert threads(), "or this program looks for the wrong names"
        if HOW == "while it is made":
            interrupt()
        if HOW == "by a fault while it is made":
            raise RuntimeError("as asked for")
        door.subscribe(checks.odometry(), "/debris/odometry", lambda _: self.get_clock(), qos.CONTROL)
        print("made")
        self.create_timer(0.1, self.end)

    def end(self):
        if HOW == "by a fault":
            raise RuntimeError("as asked for")
        interrupt()


status = run(Leaver, ["leaver"])
print("left behind:", *threads())
sys.exit(status)
"""
WAYS = {"by a signal": 0, "while it is made": 0, "by a fault": 1, "by a fault while it is made": 1}


@pytest.mark.parametrize("executor", ["events", "single"])
@pytest.mark.parametrize("how", WAYS)
def test_a_node_leaves_nothing_behind(domain_id, how, executor):
    environment = os.environ | {"TETHERNET_EXECUTOR": executor, "ROS_DOMAIN_ID": str(domain_id)}
    command = [sys.executable, "-P", "-c", PROGRAM, how]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == WAYS[how], done.stderr
    lines = done.stdout.splitlines()
    assert lines == ([] if "made" in how else ["made"]) + ["left behind:"], done.stderr
