"""Whether a node's publishers have found their subscribers: only the node itself knows.

That a third party sees both ends of a topic does not mean that they see each other, and what is published before they
do is lost. So every node tells on ``/NODE/connections`` (std_srvs/Trigger) how many subscribers each of its publishers
has; whoever starts a mission asks before the first tick.
"""

from __future__ import annotations

import json

from rclpy.node import Node
from std_srvs.srv import Trigger


def service_name(node: str) -> str:
    """Name of the service of the node with this name."""
    return f"/{node}/connections"


def serve_connections(node: Node) -> None:
    """Offer the service on a node."""

    def tell(_, response: Trigger.Response) -> Trigger.Response:
        counts = {publisher.topic_name: publisher.get_subscription_count() for publisher in node.publishers}
        response.success, response.message = True, json.dumps(counts)
        return response

    node.create_service(Trigger, service_name(node.get_name()), tell)


def read_connections(response: Trigger.Response) -> dict[str, int]:
    """Subscribers by topic, from a service's answer.

    Raises:
        ValueError: when it is no such answer.
    """
    counts = json.loads(response.message)
    if not isinstance(counts, dict):
        raise ValueError(f"not a mapping from topics to numbers: {response.message}")
    return {str(topic): int(count) for topic, count in counts.items()}
