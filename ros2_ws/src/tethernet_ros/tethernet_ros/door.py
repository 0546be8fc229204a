"""The only way into a node and out of it: what comes in is checked, what goes out is finite; what is not is dropped,
counted and reported.

A node makes one :class:`Door` and everything it subscribes, publishes, serves and asks goes through it; a test holds
that no node makes a subscription, a publisher, a service or a client by itself. Callbacks get values that have passed
their check in :mod:`.checks`. A callback that finds a sound message unfit all the same (stale, of another mission)
raises :class:`.well_formed.MessageError`, and it counts as the others do.

Subscriptions take bytes: those that are no such message are dropped like any other malformed message, and counted,
where the middleware would leave them out without a word.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from rclpy.client import Client
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.task import Future

from tethernet_core.shown import LONG, SHORT, shown
from tethernet_ros import any_quality
from tethernet_ros.checks import Check
from tethernet_ros.polled_group import PolledGroup
from tethernet_ros.qos import SERVICE
from tethernet_ros.stop_request import leave_if_asked
from tethernet_ros.template import Template
from tethernet_ros.well_formed import Message, MessageError, not_finite


class AnswerMessage(Message, Protocol):
    """A response that tells whether it was done, and what is said of it."""

    success: bool
    message: str


Checked = TypeVar("Checked")
Answer = TypeVar("Answer")
Request = TypeVar("Request", bound=Message)
Response = TypeVar("Response", bound=AnswerMessage)

_REPORT_PERIOD_S = 5.0
"""[s] wall time between two reports on one topic."""


@dataclass
class Drops:
    """What was dropped on one topic or service."""

    count: int = 0
    newest: str = ""
    """Why the newest one was."""
    reported_s: float = float("-inf")
    """Wall time of the last report."""


class Door:
    """Makes a node's subscriptions, publishers, services and clients, and keeps the account of what was dropped."""

    def __init__(self, node: Node):
        """Args:
        node: whose door it is.
        """
        self._node = node
        self.incoming: dict[str, Drops] = {}
        """Malformed messages, requests and answers, by topic or service."""
        self.outgoing: dict[str, Drops] = {}
        """Messages that were not published, because a number in them is not finite, by topic."""

    @property
    def dropped(self) -> int:
        """How many were dropped in all, coming or going."""
        return sum(drops.count for drops in (*self.incoming.values(), *self.outgoing.values()))

    @property
    def counts(self) -> Counter[str]:
        """How many were dropped, coming or going, by topic or service."""
        return Counter({name: drops.count for name, drops in self.incoming.items()}) + Counter(
            {name: drops.count for name, drops in self.outgoing.items()}
        )

    def subscribe(
        self,
        check: Check[Checked],
        topic: str,
        callback: Callable[[Checked], None],
        qos: QoSProfile,
        on_drop: Callable[[], None] | None = None,
    ) -> None:
        """Subscribe to a topic; every publisher of it is heard, whatever quality of service it offers.

        Args:
            check: of its messages.
            topic: its name.
            callback: gets what the check makes of a message; may raise MessageError to drop it.
            qos: quality of service that is asked for as long as all publishers offer it.
            on_drop: called after each message that was dropped.
        """
        take = self._taker(check, topic, callback, on_drop)
        any_quality.subscribe(self._node, check.kind, topic, take, qos, raw=True)

    def poll(
        self,
        check: Check[Checked],
        topic: str,
        callback: Callable[[Checked], None],
        qos: QoSProfile,
        on_drop: Callable[[], None] | None = None,
    ) -> Callable[[], None]:
        """The same for what need not be heard at once: no message wakes the node, which must be a
        :class:`.polled_group.PollingNode`.

        Returns:
            Hands the callback what has come since the last time, the oldest first, at most as many as ``qos`` keeps.
        """
        take = self._taker(check, topic, callback, on_drop)
        group = PolledGroup(events=True)
        heard = any_quality.subscribe(self._node, check.kind, topic, take, qos, raw=True, group=group)

        def look() -> None:
            for _ in range(qos.depth):
                taken = heard().handle.take_message(check.kind, True)
                if taken is None:
                    return
                take(taken[0])

        return look

    def _taker(
        self,
        check: Check[Checked],
        topic: str,
        callback: Callable[[Checked], None],
        on_drop: Callable[[], None] | None,
    ) -> Callable[[bytes], None]:
        def take(data: bytes) -> None:
            try:
                if len(data) > check.largest_bytes:
                    raise MessageError(f"{len(data)} bytes; allowed: up to {check.largest_bytes}")
                callback(check.read(data))
            except MessageError as error:
                self.drop(topic, error)
                if on_drop is not None:
                    on_drop()

        return take

    def publish(self, kind: type[Message], topic: str, qos: QoSProfile) -> GuardedPublisher:
        """A publisher that lets no number out that is not finite."""
        leave_if_asked()
        return GuardedPublisher(self._node.create_publisher(kind, topic, qos), topic, self)

    def serve(
        self,
        kind: type[Any],
        name: str,
        check: Callable[[Request], Checked],
        callback: Callable[[Checked, Response], Response],
    ) -> None:
        """Offer a service.

        Args:
            kind: of the service; its response has the fields ``success`` and ``message``.
            name: of the service.
            check: turns the request into checked values, or raises MessageError.
            callback: gets them and the response to fill, which it returns; may raise MessageError to refuse.
        """

        def answer(request: Request, response: Response) -> Response:
            try:
                filled = callback(check(request), response)
                if found := not_finite(filled):
                    raise MessageError(f"no answer can be given: {found}")
            except MessageError as error:
                self.drop(name, error)
                refusal: Response = kind.Response(success=False, message=shown(error))
                return refusal
            return filled

        leave_if_asked()
        self._node.create_service(kind, name, answer, qos_profile=SERVICE)

    def ask(self, kind: type[Any], name: str) -> Asker:
        """A client of a service."""
        leave_if_asked()
        return Asker(self._node.create_client(kind, name, qos_profile=SERVICE), name, self)

    def drop(self, name: str, reason: object, statistics: dict[str, Drops] | None = None) -> None:
        """Count something that is not used, and report it: the first at once, later ones now and then.

        Args:
            name: of the topic or service.
            reason: why it is not used.
            statistics: where it is counted; by default with what came in.
        """
        drops = (self.incoming if statistics is None else statistics).setdefault(name, Drops())
        drops.count += 1
        drops.newest = shown(reason)
        now = time.monotonic()
        if now - drops.reported_s >= _REPORT_PERIOD_S:
            drops.reported_s = now
            self._node.get_logger().warning(f"{name}: {drops.newest}; dropped ({drops.count} so far)")

    def summary(self) -> str:
        """The account in one line, for diagnostics; empty where nothing was dropped."""
        return shown(", ".join(f"{shown(name, SHORT)}: {count}" for name, count in sorted(self.counts.items())), LONG)


class GuardedPublisher:
    """Publishes messages whose numbers are all finite; others are dropped and counted."""

    def __init__(self, publisher: Publisher, topic: str, door: Door):
        """Args:
        publisher: the node's own.
        topic: its topic.
        door: keeps the account.
        """
        self._publish, self._topic, self._door = publisher.publish, topic, door
        self.get_subscription_count = publisher.get_subscription_count

    def publish(self, message: Message) -> bool:
        """Publish; returns false where the message was dropped."""
        if found := not_finite(message):
            self._door.drop(self._topic, f"not published: {found}", self._door.outgoing)
            return False
        self._publish(message)
        return True

    def publish_template(self, template: Template) -> bool:
        """The same for a message that is written over in place."""
        if not template.finite:
            self._door.drop(self._topic, "not published: a number is not finite", self._door.outgoing)
            return False
        self._publish(template.bytes())
        return True


class Asker:
    """Asks one service; answers are checked."""

    def __init__(self, client: Client, name: str, door: Door):
        """Args:
        client: the node's own.
        name: of the service.
        door: keeps the account.
        """
        self._client, self._name, self._door = client, name, door
        self.ready = client.service_is_ready
        """Whether the service is there."""

    def ask(
        self, request: Message, check: Callable[[Any], Answer], callback: Callable[[Answer | MessageError], None]
    ) -> None:
        """Send a request.

        Args:
            request: what is asked.
            check: turns the response into checked values, or raises MessageError.
            callback: gets them once they are there, or the reason why they are of no use.
        """

        def take(future: Future) -> None:
            answer: Answer | MessageError
            try:
                if future.exception() is not None:
                    raise MessageError(str(future.exception()))
                answer = check(future.result())
            except MessageError as error:
                self._door.drop(self._name, error)
                answer = error
            callback(answer)

        self._client.call_async(request).add_done_callback(take)
