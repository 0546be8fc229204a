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

    def tell(_, response: Trigger.Response) -> Trigger.Response:
        content = {
            "pid": os.getpid(),
            "subscribers": {out.topic_name: out.get_subscription_count() for out in node.publishers},
            "publishers": {heard.topic_name: heard.get_publisher_count() for heard in node.subscriptions},
        }
        response.success, response.message = True, json.dumps(content)
        return response

    node.create_service(Trigger, service_name(node.get_name()), tell)


def read_connections(response: Trigger.Response) -> Connections:
    """What a service answered.

    Raises:
        ValueError: when it is no such answer.
    """
    try:
        content = json.loads(response.message)
        subscribers, publishers = (
            {str(topic): int(count) for topic, count in content[side].items()} for side in ("subscribers", "publishers")
        )
        return Connections(int(content["pid"]), subscribers, publishers)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise ValueError(f"no answer of a connections service: {response.message!r}") from error
