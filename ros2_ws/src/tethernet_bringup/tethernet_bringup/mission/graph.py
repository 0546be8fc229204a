"""Which node publishes and subscribes what: the graph that has to be complete before a mission starts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tethernet_bringup.nodes import ASSESSOR, MONITOR, PLANNER, RECORDER, SIM, controller
from tethernet_core.system import System
from tethernet_ros import topics


@dataclass(frozen=True)
class Endpoint:
    """One end of a topic."""

    topic: str
    node: str
    publishes: bool

    def __str__(self) -> str:
        return f"{self.node} does not {'publish' if self.publishes else 'subscribe to'} {self.topic}"


def expected(system: System, external: Iterable[int], simulated: bool) -> list[Endpoint]:
    """The endpoints that a mission needs.

    Args:
        system: that is flown: one controller for each unit, none for a net without units.
        external: units whose odometry somebody else publishes.
        simulated: whether the simulator runs.
    """
    external = set(external)
    mus = range(1, system.unit_count + 1)
    publishers = {
        topics.MISSION_STATE: [PLANNER],
        topics.PLANNER_HEARTBEAT: [PLANNER],
        topics.CAPTURE_ASSESSMENT: [ASSESSOR],
    }
    subscribers: dict[str, list[str]] = {
        topics.MISSION_STATE: [ASSESSOR, *(controller(mu) for mu in mus)],
        topics.PLANNER_HEARTBEAT: [controller(mu) for mu in mus],
    }
    for mu in mus:
        publishers[topics.mu_thrust(mu)] = [controller(mu)]
        publishers[topics.mu_status(mu)] = [controller(mu)]
        subscribers[topics.mu_odometry(mu)] = [controller(mu)]
        if not simulated or system.closing.kind == "docking":
            subscribers[topics.mu_odometry(mu)].append(PLANNER)
        subscribers[topics.mu_status(mu)] = [PLANNER]
    if simulated:
        for topic in (
            topics.CLOCK,
            topics.DEBRIS_ODOMETRY,
            topics.CHASER_ODOMETRY,
            topics.NET_STATE,
            topics.TF,
            topics.SIM_STATUS,
        ):
            publishers[topic] = [SIM]
        for mu in set(mus) - external:
            publishers[topics.mu_odometry(mu)] = [SIM]
        for mu in mus:
            subscribers[topics.mu_thrust(mu)] = [SIM]
        for mu in external:
            subscribers[topics.mu_odometry(mu)].append(SIM)
        subscribers[topics.MISSION_STATE].append(SIM)
        subscribers[topics.PLANNER_HEARTBEAT].append(SIM)
        subscribers[topics.DEBRIS_ODOMETRY] = [PLANNER, ASSESSOR]
        subscribers[topics.NET_STATE] = [PLANNER, ASSESSOR]
    for topic in publishers:
        subscribers.setdefault(topic, []).append(RECORDER)
    for mu in external:
        subscribers[topics.mu_odometry(mu)].append(RECORDER)
    for topic in (topics.MISSION_STATE, topics.CAPTURE_ASSESSMENT, *(topics.mu_status(mu) for mu in mus)):
        subscribers[topic].append(MONITOR)
    result = [Endpoint(topic, node, True) for topic, nodes in publishers.items() for node in nodes]
    return result + [Endpoint(topic, node, False) for topic, nodes in subscribers.items() for node in nodes]


def looked_at(system: System) -> list[str]:
    """Topics that a viewer listens to: nobody needs it, but what is published before it listens is not shown."""
    units = range(1, system.unit_count + 1)
    per_unit = (topics.mu_odometry, topics.mu_thrust, topics.mu_status)
    bodies = (topics.DEBRIS_ODOMETRY, topics.CHASER_ODOMETRY)
    told = (topics.MISSION_STATE, topics.CAPTURE_ASSESSMENT)
    return [*told, *bodies, topics.NET_STATE, *(topic(mu) for mu in units for topic in per_unit)]


def exclusive_topics(system: System, external: Iterable[int], simulated: bool) -> list[str]:
    """Topics that only the mission's own nodes may publish.

    Not among them: transforms and diagnostics, which are everybody's, and what drivers and their trackers publish.

    Args:
        system: that is flown.
        external: units whose odometry somebody else publishes.
        simulated: whether the simulator runs.
    """
    published = {endpoint.topic for endpoint in expected(system, external, simulated) if endpoint.publishes}
    if simulated:
        published |= {topics.NET_MARKERS, topics.NET_POINTS}
    return sorted(published - {topics.TF})


@dataclass(frozen=True)
class Publisher:
    """One publisher of a topic, as the graph shows it."""

    node: str
    """Name of its node, as it gives it."""
    gid: bytes
    """Its identity, which no other has."""


class UnexpectedPublisherWatch:
    """Finds publishers that are no part of the mission; names each of them once.

    They are told by their identity, not by their name: a second ``mu3_controller`` is a stranger.
    """

    def __init__(
        self,
        watched: Iterable[str],
        count: Callable[[str], int],
        publishers: Callable[[str], Iterable[Publisher]],
    ):
        """Args:
        watched: topics that should have one publisher each, and have it now.
        count: gives how many publish a topic; asked at every look, so it must be cheap.
        publishers: gives all of them.
        """
        self._count, self._publishers = count, publishers
        self._known: dict[str, set[bytes]] = {}
        self.crowded: dict[str, list[str]] = {}
        """Topics that have several publishers from the start, and the names of their nodes."""
        for topic in watched:
            there = list(publishers(topic))
            self._known[topic] = {publisher.gid for publisher in there}
            if len(there) > 1:
                self.crowded[topic] = sorted(publisher.node for publisher in there)
        self._most = {topic: len(known) for topic, known in self._known.items()}

    def update(self) -> list[tuple[str, str]]:
        """Look again; returns (node, topic) of each stranger that has not been named before."""
        found = []
        for topic, known in self._known.items():
            count = self._count(topic)
            if count <= self._most[topic]:
                self._most[topic] = count  # one has gone: another may come in its place
                continue
            new = [publisher for publisher in self._publishers(topic) if publisher.gid not in known]
            found += [(publisher.node, topic) for publisher in new]
            known.update(publisher.gid for publisher in new)
            self._most[topic] = count
        return found


class GraphCheck:
    """Compares what should be there with what is; asks only after what was not there the last time."""

    def __init__(
        self,
        endpoints: Iterable[Endpoint],
        publishers: Callable[[str], Iterable[str]],
        subscribers: Callable[[str], Iterable[str]],
    ):
        """Args:
        endpoints: from :func:`expected`.
        publishers: gives the names of the nodes that publish a topic, one for each endpoint.
        subscribers: the same for those that subscribe.
        """
        self._endpoints = tuple(endpoints)
        self.missing = list(self._endpoints)
        self._publishers = publishers
        self._subscribers = subscribers

    def update(self) -> bool:
        """Look again; true when nothing is missing any more."""
        if self.missing:
            names = {}
            for key in {(endpoint.topic, endpoint.publishes) for endpoint in self.missing}:
                names[key] = set((self._publishers if key[1] else self._subscribers)(key[0]))
            self.missing = [e for e in self.missing if e.node not in names[(e.topic, e.publishes)]]
        return not self.missing

    def listeners(self) -> dict[str, dict[str, frozenset[str]]]:
        """The nodes that each node's publishers should reach, by node and topic."""
        found: dict[str, dict[str, frozenset[str]]] = {}
        for endpoint in self._endpoints:
            if endpoint.publishes:
                nodes = (e.node for e in self._endpoints if e.topic == endpoint.topic and not e.publishes)
                found.setdefault(endpoint.node, {})[endpoint.topic] = frozenset(nodes)
        return found

    @property
    def waiting_for(self) -> str:
        """The nodes of which something is missing."""
        return ", ".join(sorted({endpoint.node for endpoint in self.missing}))

    def describe(self, limit: int = 6) -> str:
        """What is missing, in words."""
        silent: dict[str, int] = {}
        for endpoint in self.missing:
            silent[endpoint.node] = silent.get(endpoint.node, 0) + 1
        lines = [str(endpoint) for endpoint in self.missing[:limit]]
        if len(self.missing) > limit:
            lines.append(f"... {len(self.missing)} in all, of {', '.join(sorted(silent))}")
        return "; ".join(lines)
