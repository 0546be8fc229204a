"""Whether the nodes of a mission have found each other, asked of each of them.

The middleware tells a node how many subscribers a publisher has found, not which. Only when it has found as many as
there are, it has found those that matter, whoever else listens.
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Collection, Mapping

from std_srvs.srv import Trigger

from tethernet_ros.connections import Connections, read_connections
from tethernet_ros.door import Asker
from tethernet_ros.well_formed import MessageError

_PATIENCE_S = 5.0
"""[s] After this time the mission waits no more for those who only look on: an onlooker that is not there yet, a
stranger's subscription that is seen but not found."""

_ASK_AGAIN_S = 1.0
"""[s] An answer is lost where a node has not found the reader for it yet."""


class ConnectionCheck:
    """Asks every node whether its publishers have found their subscribers, until they have."""

    def __init__(
        self,
        listeners: Mapping[str, Mapping[str, Collection[str]]],
        services: Mapping[str, Asker],
        seen: Callable[[str], int],
        onlookers: Mapping[str, Collection[str]] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ):
        """Args:
        listeners: names of the nodes that should be reached, by node and topic.
        services: of each node, to ask it.
        seen: how many subscriptions of a topic the graph shows.
        onlookers: names of those that should be reached too if they come soon, by topic.
        clock: wall time [s].
        """
        self._listeners = listeners
        self._askers = services
        self._seen = seen
        self._onlookers = onlookers or {}
        self._clock = clock
        self._lenient_at = clock() + _PATIENCE_S
        self._asked_at: dict[str, float] = {}
        self.missing = {node: list(topics) for node, topics in listeners.items()}
        """Topics that lack subscribers, by node."""
        self.pids: dict[str, int] = {}
        """Process ids of the nodes that have answered."""

    def update(self) -> bool:
        """Look at the answers, ask again where somebody is missing or none comes; true when nobody is missing."""
        for node in list(self.missing):
            service, asked_at = self._askers[node], self._asked_at.get(node, -math.inf)
            if self._clock() - asked_at >= _ASK_AGAIN_S and service.ready():
                self._asked_at[node] = self._clock()
                service.ask(Trigger.Request(), read_connections, functools.partial(self._take, node))
        return not self.missing

    def describe(self) -> str:
        """Who lacks whom, in words."""
        return "; ".join(
            f"{node} lacks subscribers of {', '.join(topics)}" if node in self.pids else f"{node} has not answered"
            for node, topics in self.missing.items()
        )

    def _take(self, node: str, told: Connections | MessageError) -> None:
        self._asked_at.pop(node, None)
        if isinstance(told, MessageError) or node not in self.missing:
            return  # dropped and counted at the door; it is asked again
        self.pids[node] = told.pid
        wanted = self._listeners[node]
        self.missing[node] = [topic for topic in wanted if told.subscribers.get(topic, 0) < self._least(topic, wanted)]
        if not self.missing[node]:
            del self.missing[node]

    def _least(self, topic: str, wanted: Mapping[str, Collection[str]]) -> int:
        """So many subscribers a publisher must have found to be sure that those who matter are among them."""
        own = len(wanted[topic])
        if self._clock() >= self._lenient_at:
            return own
        return max(own + len(self._onlookers.get(topic, ())), self._seen(topic))
