"""The steps before launch: a domain of its own, all nodes in one graph, drivers that keep their contract."""

from __future__ import annotations

import time

from tethernet_bringup.mission.domain_claim import DomainClaim, DomainTakenError
from tethernet_bringup.mission.drivers import DriverDesk, DriverFaultError, hint, mu_list
from tethernet_bringup.mission.flight_plan import FlightPlan
from tethernet_bringup.mission.graph import exclusive_topics, expected, looked_at
from tethernet_bringup.mission.live_display import Display
from tethernet_bringup.mission.mission_watch import BRISK_S, MissionFaultError, MissionWatch, name_of
from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_bringup.mission.supervisor import Supervisor
from tethernet_bringup.nodes import RECORDER, SIM
from tethernet_ros import topics
from tethernet_sim.compiling import COMPILED, COMPILING


class Assembly:
    """Brings the nodes of one mission together. Every step raises what :meth:`MissionWatch.step` raises."""

    def __init__(
        self, plan: FlightPlan, supervisor: Supervisor, watch: MissionWatch, record: FlightRecord, display: Display
    ):
        """Args:
        plan: what is flown.
        supervisor: has the mission's processes.
        watch: gets whatever is to be watched from now on.
        record: says what has been heard of MUs.
        display: shows what is waited for.
        """
        self._plan = plan
        self._supervisor = supervisor
        self._watch = watch
        self._record = record
        self._display = display
        self._claim = DomainClaim(plan.domain_id)
        self._told_compiling = False

    def release_domain(self) -> None:
        """Let other commands fly in the domain."""
        self._claim.release()

    def claim_domain(self) -> None:
        """Make sure that no other command on this machine flies in the domain."""
        try:
            self._claim.take()
        except DomainTakenError as error:
            raise MissionFaultError(self._crowded(str(error))) from None

    def look_around(self) -> None:
        """Join the graph, and make sure that no other mission is in it before any node could disturb that."""
        plan = self._plan
        watched = exclusive_topics(plan.system, plan.external, plan.simulated)
        deadline = time.monotonic() + plan.parameters.probe_s
        while time.monotonic() < deadline:
            self._watch.step()
            for topic in watched:
                for publisher in self._watch.joined.publishers(topic):
                    raise MissionFaultError(self._crowded(f"node {name_of(publisher.node)} publishes {topic}"))

    def assemble(self) -> None:
        """Wait until every node has found every other."""
        plan, monitor = self._plan, self._watch.joined
        graph = monitor.check_graph(expected(plan.system, plan.external, plan.simulated))
        looking = {node.name for node in plan.processes if node.bystander}
        connections = monitor.check_connections(
            graph.listeners(), dict.fromkeys(looked_at(plan.system), looking) if looking else {}
        )

        def complete() -> bool:
            found = graph.update() and monitor.planner_ready()
            if not found and self._compiling():
                return False
            self._display.live(f"{len(plan.processes)} nodes started; waiting for {graph.waiting_for or 'the planner'}")
            return found

        def connected() -> bool:
            found = connections.update()
            for node, pid in connections.pids.items():
                if self._supervisor.pids.get(node, pid) != pid:
                    raise MissionFaultError(self._crowded(f"another process, {pid}, is node {node}"))
            if not found and self._compiling():
                return False
            self._display.live(f"all nodes are there; waiting for {', '.join(connections.missing)} to be heard by all")
            return found

        patience, started = plan.parameters.graph_timeout_s, time.monotonic()

        def excused() -> bool:
            return self._compiling() and time.monotonic() < started + plan.parameters.compile_timeout_s

        self._watch.wait(
            complete,
            patience,
            lambda: f"nodes are missing: {graph.describe() or 'no planner service'}",
            excused,
        )
        self._watch.wait(
            connected,
            patience,
            lambda: f"nodes do not find each other: {connections.describe()}",
            excused,
            every_s=BRISK_S,
        )
        answering = [node.name for node in plan.processes if node.name != RECORDER and not node.bystander]
        self._watch.pulse = monitor.watch_pulse(answering, plan.parameters.hang_timeout_s)
        if plan.ask_recorder is not None:
            self._watch.pulse.watch(RECORDER, plan.ask_recorder)
        self._supervisor.note_shared_memory()

    def _compiling(self) -> bool:
        """Whether the simulator says that it is busy with that; the user is told once."""
        # Its node is made at the same time, and may have something to say too.
        told = [line for line in self._supervisor.tail(SIM) if line.startswith((COMPILING, COMPILED))]
        compiling = bool(told) and told[-1].startswith(COMPILING)
        if compiling and not self._told_compiling:
            self._told_compiling = True
            self._display.note(f"{SIM}: {told[-1]}")
        return compiling

    def _crowded(self, sign: str) -> str:
        domain = self._plan.domain_id
        return f"somebody else is in DDS domain {domain}: {sign}; end the other mission, or take another --domain-id"

    def await_drivers(self) -> None:
        """Wait until every external MU's odometry is in order and its controller hears it."""
        plan, monitor = self._plan, self._watch.joined
        if not plan.external:
            return

        def published(mu: int) -> bool:
            return monitor.publisher_count(topics.mu_odometry(mu)) > 0

        self._watch.drivers = monitor.watch_drivers(plan.external, plan.control, plan.simulated)
        patience_s, hears = plan.parameters.driver_patience_s, self._record.hears_odometry
        desk = DriverDesk(self._watch.drivers, hears, published, patience_s)
        if not all(map(published, plan.external)):
            self._display.note(hint(plan.external, plan.external_timeout_s, plan.domain_id, plan.simulated))

        def complete() -> bool:
            try:
                for news in desk.update():
                    self._display.note(news)
            except DriverFaultError as error:
                raise MissionFaultError(str(error)) from None
            self._display.live(f"waiting for the drivers of {mu_list(desk.waiting)}")
            return not desk.waiting

        self._watch.wait(
            complete,
            plan.external_timeout_s,
            lambda: desk.problem(plan.external_timeout_s, plan.domain_id, plan.simulated),
        )

    def know_publishers(self) -> None:
        """From here on whoever else publishes what only one node should is a stranger."""
        plan = self._plan
        odometry = [topics.mu_odometry(mu) for mu in plan.external]
        watched = exclusive_topics(plan.system, plan.external, plan.simulated) + odometry
        self._watch.unexpected = self._watch.joined.watch_unexpected_publishers(watched)
        for topic, names in self._watch.unexpected.crowded.items():
            who = ", ".join(map(name_of, names))
            raise MissionFaultError(self._crowded(f"{topic} has {len(names)} publishers ({who})"))
