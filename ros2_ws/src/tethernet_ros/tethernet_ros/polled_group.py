"""Subscriptions that wake nobody: a group for them, and nodes whose executor leaves them alone."""

from __future__ import annotations

from collections.abc import Iterator

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.subscription import Subscription


class PolledGroup(CallbackGroup):
    """For subscriptions that are looked into by hand: an executor that respects callback groups, as the
    SingleThreadedExecutor does, leaves them alone.
    """

    def __init__(self, events: bool = False):
        """Args:
        events: whether it is told of what happens to them, as a publisher that offers less than they ask for.
        """
        super().__init__()
        self._events = events

    def can_execute(self, entity: object) -> bool:
        return self._events and not isinstance(entity, Subscription)

    def beginning_execution(self, entity: object) -> bool:
        return self.can_execute(entity)

    def ending_execution(self, entity: object) -> None:
        return


class PollingNode(Node):
    """A node of which any executor leaves the subscriptions of a :class:`PolledGroup` alone: the EventsExecutor, which
    knows no groups, takes all that it is told of.
    """

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Those that an executor is to take messages from."""
        return (heard for heard in super().subscriptions if not isinstance(heard.callback_group, PolledGroup))


def all_subscriptions(node: Node) -> Iterator[Subscription]:
    """Those of a node that an executor takes messages from, and those that are polled."""
    return super(PollingNode, node).subscriptions if isinstance(node, PollingNode) else node.subscriptions
