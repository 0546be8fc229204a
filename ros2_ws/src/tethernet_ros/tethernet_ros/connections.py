"""Whether a node's publishers have found their subscribers: only the node itself knows.

That a third party sees both ends of a topic does not mean that they see each other, and what is published before they
do is lost. So every node tells on ``/NODE/connections`` (std_srvs/Trigger) how many subscribers each of its publishers
has, and which process it is; whoever starts a mission asks before the first tick.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass

from rclpy.node import Node
from std_srvs.srv import Trigger

from tethernet_core.shown import SHORT, shown
from tethernet_ros.checks import trigger_request
from tethernet_ros.door import Door
from tethernet_ros.polled_group import all_subscriptions
from tethernet_ros.well_formed import MessageError

_LONGEST_TEXT = 100_000  # [characters] of an answer; a recorder's, with all topics of 8 MUs, has 1500


@dataclass(frozen=True)
class Connections:
    """What a node knows of its own place in the graph."""

    pid: int
    """Process id of the node."""
    subscribers: dict[str, int]
    """Subscribers that each of its publishers has found, by topic."""
    publishers: dict[str, int]
    """Publishers that each of its subscriptions has found, by topic."""


def service_name(node: str) -> str:
    """Name of the service of the node with this name."""
    return f"/{node}/connections"


def serve_connections(node: Node) -> None:
    """Offer the service on a node."""

    def tell(_: None, response: Trigger.Response) -> Trigger.Response:
        content = {
            "pid": os.getpid(),
            "subscribers": {out.topic_name: out.get_subscription_count() for out in node.publishers},
            "publishers": {heard.topic_name: heard.get_publisher_count() for heard in all_subscriptions(node)},
        }
        response.success, response.message = True, json.dumps(content)
        return response

    Door(node).serve(Trigger, service_name(node.get_name()), trigger_request, tell)


def read_connections(response: Trigger.Response) -> Connections:
    """What a service answered.

    Raises:
        MessageError: when it is no such answer.
    """
    text = response.message
    try:
        if len(text) > _LONGEST_TEXT:
            raise ValueError
        content = json.loads(text)
        subscribers, publishers = (
            {str(topic): int(count) for topic, count in content[side].items()} for side in ("subscribers", "publishers")
        )
        return Connections(int(content["pid"]), subscribers, publishers)
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError) as error:
        raise MessageError(f"no answer of a connections service: {shown(text, SHORT)}") from error
