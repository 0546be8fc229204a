"""Subscriptions that hear every publisher of their topic, whatever quality of service it offers.

DDS lets a reliable reader hear only reliable writers, and one that wants latched samples only those that latch. What
comes from outside (drivers, trackers) is often published best effort, as sensors are. A reader that asks for nothing
hears everybody, but then nobody sends it again what was lost on the way. So a subscription asks for what it would like,
and where a publisher offers less, a second one that asks for nothing takes its place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.event_handler import QoSRequestedIncompatibleQoSInfo, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.subscription import Subscription

from tethernet_ros.stop_request import leave_if_asked
from tethernet_ros.well_formed import Message


def undemanding(qos: QoSProfile) -> QoSProfile:
    """A profile as deep as this one that every publisher's offer is good enough for."""
    return QoSProfile(
        history=qos.history,
        depth=qos.depth,
        reliability=QoSReliabilityPolicy.BEST_EFFORT,
        durability=QoSDurabilityPolicy.VOLATILE,
    )


def quality_text(qos: QoSProfile) -> str:
    """What matters of a profile, in words: ``reliable, volatile``."""
    return ", ".join(policy.name.lower().replace("_", " ") for policy in (qos.reliability, qos.durability))


def subscribe(
    node: Node,
    kind: type[Message],
    topic: str,
    callback: Callable[[Any], None],
    qos: QoSProfile,
    raw: bool = False,
    group: CallbackGroup | None = None,
) -> Callable[[], Subscription]:
    """Subscribe so that every publisher of the topic is heard.

    Args:
        node: that hears.
        kind: type of the messages.
        topic: its name.
        callback: gets each message, or its bytes.
        qos: what is asked of publishers, as long as all of them offer it.
        raw: whether the callback gets bytes.
        group: of the subscription; None for the node's own.

    Returns:
        Gives the subscription that hears all.
    """
    replaced = False
    heard: Subscription

    def take(message: Any) -> None:
        if not replaced:  # else a publisher that offers enough would be heard twice
            callback(message)

    def on_incompatible(_: QoSRequestedIncompatibleQoSInfo) -> None:
        nonlocal replaced, heard
        if not replaced:
            replaced = True
            node.get_logger().info(f"a publisher of {topic} offers less than asked for: all are heard as they come")
            heard = node.create_subscription(kind, topic, callback, undemanding(qos), callback_group=group, raw=raw)

    leave_if_asked()
    events = SubscriptionEventCallbacks(incompatible_qos=on_incompatible)
    heard = node.create_subscription(kind, topic, take, qos, callback_group=group, raw=raw, event_callbacks=events)
    return lambda: heard
