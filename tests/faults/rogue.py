"""A foreign process in a mission's DDS domain: publishes hostile messages on the mission's topics, calls its services.

python -m tests.faults.rogue --seed 3 --seconds 5 --mus 8 [--kind topics|types|services|flood|abort]
"""

from __future__ import annotations

import argparse
import random
import time

import rclpy
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

from tethernet_msgs.msg import CaptureAssessment, MissionState, MuStatus, NetState, SimStatus
from tethernet_msgs.srv import PlanAimingPoints
from tethernet_ros import qos, topics

from . import hostile

KINDS = ("topics", "types", "services", "flood", "abort")


def mission_topics(mus: int) -> list[tuple[str, type, object]]:
    """Topic, type and quality of service of what nodes of a mission listen to."""
    found = [
        (topics.CLOCK, Clock, qos.CONTROL),
        (topics.MISSION_STATE, MissionState, qos.STATE),
        (topics.PLANNER_HEARTBEAT, Header, qos.CONTROL),
        (topics.DEBRIS_ODOMETRY, Odometry, qos.STATE_BACKLOG),
        (topics.NET_STATE, NetState, qos.BULK),
        (topics.SIM_STATUS, SimStatus, qos.STATE),
        (topics.CAPTURE_ASSESSMENT, CaptureAssessment, qos.STATE),
    ]
    for mu in range(1, mus + 1):
        found += [
            (topics.mu_odometry(mu), Odometry, qos.CONTROL),
            (topics.mu_thrust(mu), WrenchStamped, qos.CONTROL),
            (topics.mu_status(mu), MuStatus, qos.STATE),
        ]
    return found


class Rogue:
    """Publishes until its time is over."""

    def __init__(self, mus: int, seconds: float, generator: random.Random):
        self._generator, self._mus = generator, mus
        self._node = rclpy.create_node("rogue")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._end = time.monotonic() + seconds
        self._seen: dict[str, object] = {}

    def run(self, kind: str) -> None:
        """One kind of mischief."""
        getattr(self, kind)()

    def _spin(self, seconds: float) -> bool:
        """Take what comes in for a while; false when the time is over."""
        until = min(self._end, time.monotonic() + seconds)
        while (left := until - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)
        return time.monotonic() < self._end

    def topics(self) -> None:
        """One to three topics: random messages, and honest ones with one field changed."""
        chosen = self._generator.sample(mission_topics(self._mus), self._generator.choice((1, 1, 2, 3)))
        publishers = []
        for name, kind, profile in chosen:
            self._node.create_subscription(kind, name, lambda m, name=name: self._seen.__setitem__(name, m), profile)
            publishers.append((name, kind, self._node.create_publisher(kind, name, profile)))
        pause = 1.0 / self._generator.choice((2.0, 20.0, 100.0))
        while self._spin(pause):
            for name, kind, publisher in publishers:
                honest = self._seen.get(name)
                if honest is None or self._generator.random() < 0.2:
                    publisher.publish(hostile.fill(kind(), self._generator))
                else:
                    publisher.publish(hostile.mutate(honest, self._generator))

    def types(self) -> None:
        """Another message type on topics of the mission."""
        chosen = self._generator.sample(mission_topics(self._mus), 3)
        publishers = [self._node.create_publisher(String, name, profile) for name, _, profile in chosen]
        while self._spin(0.05):
            for publisher in publishers:
                publisher.publish(String(data="x" * 100))

    def flood(self) -> None:
        """One topic at some thousand hertz."""
        name, kind, profile = self._generator.choice(mission_topics(self._mus))
        publisher = self._node.create_publisher(kind, name, profile)
        message = hostile.fill(kind(), self._generator)
        while self._spin(0.0005):
            publisher.publish(message)

    def services(self) -> None:
        """Calls with random requests."""
        plan = self._node.create_client(PlanAimingPoints, topics.PLAN_AIMING_POINTS)
        start = self._node.create_client(Trigger, topics.START)
        while self._spin(0.02):
            if plan.service_is_ready():
                plan.call_async(hostile.fill(PlanAimingPoints.Request(), self._generator))
            if start.service_is_ready() and self._generator.random() < 0.1:
                start.call_async(Trigger.Request())

    def abort(self) -> None:
        """Ask for an abort, as anybody on this machine may."""
        asker = self._node.create_client(Trigger, topics.ABORT)
        answer = None
        while self._spin(0.02) and (answer is None or not answer.done()):
            if answer is None and asker.service_is_ready():
                answer = asker.call_async(Trigger.Request())


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--mus", type=int, default=8)
    parser.add_argument("--kind", choices=KINDS, default="topics")
    options = parser.parse_args()
    rclpy.init()
    Rogue(options.mus, options.seconds, random.Random(options.seed)).run(options.kind)


if __name__ == "__main__":
    main()
