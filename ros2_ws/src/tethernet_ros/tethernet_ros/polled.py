"""Subscriptions that nobody is woken by: whoever is interested looks when it suits, and finds the newest message.

For nodes that only look on. What they do not look at costs them next to nothing: the middleware keeps the newest and
drops the rest. What is published at every tick they hear best effort, so that nobody sends them anything again.
"""

from __future__ import annotations

from typing import Generic, TypeVar

from rclpy.node import Node
from rclpy.qos import QoSProfile

from tethernet_ros.checks import Check
from tethernet_ros.door import Door
from tethernet_ros.polled_group import PolledGroup
from tethernet_ros.qos import NEWEST
from tethernet_ros.stop_request import leave_if_asked
from tethernet_ros.well_formed import MessageError

Checked = TypeVar("Checked")


class Polled(Generic[Checked]):
    """The newest messages of one topic, checked."""

    def __init__(self, node: Node, door: Door, check: Check[Checked], topic: str, qos: QoSProfile = NEWEST):
        """Subscribe.

        Args:
            node: that looks; its executor must respect callback groups, as the SingleThreadedExecutor does.
            door: of the node: counts what is dropped.
            check: of the messages.
            topic: its name.
            qos: what is asked of its publishers, and how many messages are kept for the next look.
        """
        self._door, self._check, self._topic, self._depth = door, check, topic, qos.depth
        leave_if_asked()
        self._subscription = node.create_subscription(
            check.kind, topic, lambda _: None, qos, callback_group=PolledGroup(), raw=True
        )

    def take(self) -> list[Checked]:
        """What has come since the last look, the oldest first; malformed messages are left out and counted."""
        found = []
        for _ in range(self._depth):
            taken = self._subscription.handle.take_message(self._check.kind, True)
            if taken is None:
                break
            data = taken[0]
            try:
                if len(data) > self._check.largest_bytes:
                    raise MessageError(f"{len(data)} bytes; allowed: up to {self._check.largest_bytes}")
                found.append(self._check.read(data))
            except MessageError as error:
                self._door.drop(self._topic, error)
        return found
