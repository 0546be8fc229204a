"""One mission from the first process to the verdict."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from tethernet_bringup.mission import shared_memory
from tethernet_bringup.mission.domain_claim import DomainClaim, DomainTakenError
from tethernet_bringup.mission.drivers import DriverDesk, DriverFaultError, DriverWatch, hint, mu_list
from tethernet_bringup.mission.flight_plan import FlightPlan
from tethernet_bringup.mission.graph import UnexpectedPublisherWatch, exclusive_topics, expected
from tethernet_bringup.mission.interrupts import Interrupts, MissionInterrupt
from tethernet_bringup.mission.live_display import Display
from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_bringup.mission.run_folder import keep_traceback
from tethernet_bringup.mission.supervisor import Exit, Supervisor
from tethernet_bringup.nodes import RECORDER, SIM, mu_of
from tethernet_core.mission import Phase
from tethernet_core.settings import NANOSECOND_S
from tethernet_core.shown import SHORT, shown
from tethernet_ros import topics
from tethernet_sim.compiling import COMPILING

if TYPE_CHECKING:
    from tethernet_bringup.mission.monitor_node import Monitor
    from tethernet_bringup.pulse import Pulse

_SPIN_S = 0.05
"""[s] wall time between two looks at everything."""
_BRISK_S = 0.01
"""[s] The same where all that is left before launch is to look: whatever has come meanwhile is seen that much later."""
_SETTLE_S = 1.0
"""[s] Grace for the last accounts of controllers once the verdict is there."""
_LOOK_PERIOD_S = 1.0
"""[s] wall time between two looks at who publishes what."""
_OVERTIME_S = 5.0
"""[s] mission time that the planner may take to put the end of the longest mission on record."""
_MEMORY_AFTER_S = 2.0
"""[s] wall time after launch at which memory is measured; again at the end."""


class MissionFaultError(Exception):
    """The mission cannot go on; the message says why."""


def _join_graph(record: FlightRecord) -> Monitor:
    from tethernet_bringup.mission.monitor_node import Monitor  # rclpy takes its time: bad usage and help do without

    return Monitor(record)


class Flight:
    """Runs the processes of a mission and follows it to its end."""

    def __init__(
        self,
        plan: FlightPlan,
        supervisor: Supervisor,
        interrupts: Interrupts,
        record: FlightRecord,
        display: Display,
        began: float,
        join: Callable[[FlightRecord], Monitor] = _join_graph,
    ):
        """Args:
        plan: what is flown.
        supervisor: has no process yet.
        interrupts: end the mission early.
        record: gets what is found out.
        display: shows it.
        began: when the command started [s], time.monotonic.
        join: makes the command's own node.
        """
        self._plan = plan
        self._supervisor = supervisor
        self._interrupts = interrupts
        self._record = record
        self._display = display
        self._began = began
        self._join = join
        self._monitor: Monitor | None = None
        self._claim = DomainClaim(plan.domain_id)
        self._unexpected: UnexpectedPublisherWatch | None = None
        self._pulse: Pulse | None = None
        self._drivers: DriverWatch | None = None
        self._look_due = 0.0
        self._joining = self._started = self._told_compiling = False
        self._launched_at: float | None = None
        self._memory_due: float | None = None

    def fly(self) -> None:
        """Fly the mission; faults and interrupts end up in the record, and no process stays behind.

        The graph is left by :meth:`leave`.
        """
        try:
            self._interrupts.check()
            self._claim_domain()
            self._supervisor.start_all(self._plan.processes)  # they import what they need while this process looks
            self._look_around()
            self._supervisor.let_in()
            self._assemble()
            self._await_drivers()
            self._know_publishers()
            self._launch()
            self._follow()
            self._await_verdict()
        except MissionInterrupt as interrupt:
            self._record.interrupted_by = str(interrupt)
        except MissionFaultError as fault:
            self._fault(str(fault))
        except OSError as error:
            self._fault(f"cannot start the nodes: {error}")
        except Exception as error:  # not foreseen: end in order all the same, and keep what a developer needs
            self._fault(keep_traceback(error, self._supervisor.log_folder))
        finally:
            self._end()

    def leave(self, status: int) -> None:
        """Leave the graph, once: after all is written and told, because the middleware may hang in it.

        Args:
            status: the process' exit status, which it then keeps all the same.
        """
        if self._monitor is not None:
            self._monitor.close(status)
            self._monitor = None
            self._supervisor.clean()  # saying goodbye to a node that was killed makes its segments anew
        elif self._joining:
            time.sleep(shared_memory.YOUNG_S)  # the middleware came no further than half a port
            self._supervisor.clean()
        self._supervisor.call_off()

    @property
    def _joined(self) -> Monitor:
        """The command's own node in the graph."""
        if self._monitor is None:
            raise MissionFaultError("the command is not in the graph")
        return self._monitor

    def _claim_domain(self) -> None:
        """Make sure that no other command on this machine flies in the domain."""
        try:
            self._claim.take()
        except DomainTakenError as error:
            raise MissionFaultError(self._crowded(str(error))) from None

    def _look_around(self) -> None:
        """Join the graph, and make sure that no other mission is in it before any node could disturb that."""
        self._joining = True
        self._monitor = self._join(self._record)
        plan = self._plan
        watched = exclusive_topics(plan.system, plan.external, plan.simulated)
        deadline = time.monotonic() + plan.parameters.probe_s
        while time.monotonic() < deadline:
            self._step()
            for topic in watched:
                for publisher in self._monitor.publishers(topic):
                    raise MissionFaultError(self._crowded(f"node {_name(publisher.node)} publishes {topic}"))

    def _assemble(self) -> None:
        """Wait until every node has found every other."""
        plan, monitor = self._plan, self._joined
        graph = monitor.check_graph(expected(plan.system, plan.external, plan.simulated))
        connections = monitor.check_connections(graph.subscriber_counts())

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
            self._display.live(f"all nodes are there; waiting for {', '.join(connections.missing)} to be heard by all")
            return found

        patience, started = plan.parameters.graph_timeout_s, time.monotonic()
        self._wait(
            complete,
            patience,
            lambda: f"nodes are missing: {graph.describe() or 'no planner service'}",
            lambda: self._compiling() and time.monotonic() < started + plan.parameters.compile_timeout_s,
        )
        self._wait(
            connected, patience, lambda: f"nodes do not find each other: {connections.describe()}", every_s=_BRISK_S
        )
        answering = [node.name for node in plan.processes if node.name != RECORDER and not node.bystander]
        self._pulse = monitor.watch_pulse(answering, plan.parameters.hang_timeout_s)
        if plan.ask_recorder is not None:
            self._pulse.watch(RECORDER, plan.ask_recorder)
        self._supervisor.note_shared_memory()

    def _compiling(self) -> bool:
        """Whether the simulator says that it is busy with that; the user is told once."""
        last = self._supervisor.tail(SIM)[-1:]
        compiling = bool(last) and last[0].startswith(COMPILING)
        if compiling and not self._told_compiling:
            self._told_compiling = True
            self._display.note(f"{SIM}: {last[0]}")
        return compiling

    def _crowded(self, sign: str) -> str:
        domain = self._plan.domain_id
        return f"somebody else is in DDS domain {domain}: {sign}; end the other mission, or take another --domain-id"

    def _await_drivers(self) -> None:
        """Wait until every external MU's odometry is in order and its controller hears it."""
        plan, monitor = self._plan, self._joined
        if not plan.external:
            return

        def published(mu: int) -> bool:
            return monitor.publisher_count(topics.mu_odometry(mu)) > 0

        self._drivers = monitor.watch_drivers(plan.external, plan.control, plan.simulated)
        desk = DriverDesk(self._drivers, self._record.hears_odometry, published, plan.parameters.driver_patience_s)
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

        self._wait(
            complete,
            plan.external_timeout_s,
            lambda: desk.problem(plan.external_timeout_s, plan.domain_id, plan.simulated),
        )

    def _know_publishers(self) -> None:
        """From here on whoever else publishes what only one node should is a stranger."""
        plan = self._plan
        odometry = [topics.mu_odometry(mu) for mu in plan.external]
        watched = exclusive_topics(plan.system, plan.external, plan.simulated) + odometry
        self._unexpected = self._joined.watch_unexpected_publishers(watched)
        for topic, names in self._unexpected.crowded.items():
            who = ", ".join(map(_name, names))
            raise MissionFaultError(self._crowded(f"{topic} has {len(names)} publishers ({who})"))

    def _launch(self) -> None:
        """Tell the planner to start and wait until the MUs fly."""
        self._started = True
        answer, refusal, asked = self._joined.start(), "", time.monotonic()

        def launched() -> bool:
            nonlocal answer, refusal, asked
            given = answer()
            refused = given is not None and not given[0] and self._record.phase == Phase.WAITING
            if given is not None and refused and time.monotonic() - asked >= _SPIN_S:
                # It may only lack a first message, such as the debris' place: ask again until it has got it.
                answer, refusal, asked = self._joined.start(), f": {given[1]}", time.monotonic()
            return self._record.launched or self._record.phase.over

        timeout = self._plan.parameters.launch_timeout_s
        self._wait(
            launched,
            timeout,
            lambda: f"no launch {timeout:g} s after the planner was told to start{refusal}",
            every_s=_BRISK_S,
        )
        if self._record.launched:
            self._launched_at = time.monotonic()
            self._record.start_s = self._launched_at - self._began
            self._memory_due = self._launched_at + _MEMORY_AFTER_S

    def _follow(self) -> None:
        """Follow the flight until the mission is over."""
        news, heard = None, time.monotonic()
        silence = self._plan.parameters.silence_timeout_s
        while not self._record.phase.over:
            self._step()
            state = self._record.state
            latest = (self._record.newest_ns, state and (state.sequence, state.confirmed))
            if latest != news:
                news, heard = latest, time.monotonic()
            elif time.monotonic() - heard > silence:
                at = f"{self._record.time_s or 0.0:.2f} s after launch"
                raise MissionFaultError(f"nothing new has been heard of the mission for {silence:g} s, at {at}")
            flown = self._record.most_flown_s
            if flown is not None and flown > self._plan.longest_s + _OVERTIME_S:
                longest = f"the longest mission takes {self._plan.longest_s:g} s"
                raise MissionFaultError(f"the planner has not ended the mission {flown:.1f} s after launch; {longest}")
            if self._memory_due is not None and time.monotonic() >= self._memory_due:
                self._memory_due = None
                self._measure_memory()
        if self._record.phase == Phase.ABORTED:
            raise MissionFaultError(f"the mission was aborted: {self._record.why_aborted}")

    def _await_verdict(self) -> None:
        """Wait for the assessor's verdict and for the last accounts."""
        from tethernet_bringup.mission.monitor_node import settled

        def told() -> bool:
            return self._record.all_judged

        def problem() -> str:
            what = "no verdict" if self._record.final is None else "no verdict on the hold"
            return f"{what} {timeout:g} s after the end of the mission"

        timeout = self._plan.parameters.verdict_timeout_s
        self._wait(told, timeout, problem)
        if self._launched_at is not None:
            self._record.wall_time_s = time.monotonic() - self._launched_at
        self._measure_memory()
        deadline = time.monotonic() + _SETTLE_S
        while not settled(self._record, self._plan.simulated) and time.monotonic() < deadline:
            self._step()

    def _end(self) -> None:
        """Put an early end on record, then stop everything."""
        record = self._record
        if self._launched_at is not None and record.wall_time_s is None:
            record.wall_time_s = time.monotonic() - self._launched_at
        early = record.interrupted_by or record.faults
        if early and self._started and not record.phase.over:
            self._abort()
        if self._monitor is not None:
            record.warnings += [f"{shown(name, SHORT)}: {text}" for name, text in self._monitor.dropped.items()]
        self._display.live("stopping")
        self._supervisor.stand_by()
        self._stop_processes(bool(early))
        self._claim.release()

    def _stop_processes(self, early: bool) -> None:
        record = self._record
        for ended in self._supervisor.stop(hurry=early):
            if ended.forced:
                record.warnings.append(f"{ended.node.name} did not end when asked and was killed")
            elif ended.code != 0 and not early:
                record.warnings.append(f"{ended.node.name} ended with {ended.how}, see its log")

    def _abort(self) -> None:
        try:
            self._joined.abort()
            deadline = time.monotonic() + self._plan.parameters.abort_timeout_s
            while not self._record.phase.over and time.monotonic() < deadline:
                self._joined.spin(_SPIN_S)
        except Exception as error:
            self._record.warnings.append(f"the planner could not be told to abort: {error}")

    def _wait(
        self,
        done: Callable[[], bool],
        timeout_s: float,
        problem: Callable[[], str],
        excused: Callable[[], bool] = lambda: False,
        every_s: float = _SPIN_S,
    ) -> None:
        """Step on until it is done; the time in which it is excused does not count."""
        deadline = time.monotonic() + timeout_s
        while not done():
            if excused():
                deadline = time.monotonic() + timeout_s
            if time.monotonic() > deadline:
                raise MissionFaultError(problem())
            self._step(every_s)

    def _step(self, spin_s: float = _SPIN_S) -> None:
        self._joined.spin(spin_s)
        self._interrupts.check()
        for death in self._supervisor.deaths():
            self._on_death(death)
        if self._pulse is not None:
            for name in self._pulse.update():
                self._on_hang(name)
        if self._drivers is not None and self._launched_at is not None and not self._record.phase.over:
            self._look_after_drivers(self._drivers)
        if self._unexpected is not None and time.monotonic() >= self._look_due:
            self._look_due = time.monotonic() + _LOOK_PERIOD_S
            for node, topic in self._unexpected.update():
                self._on_stranger(node, topic)
        self._display.flight(self._record)
        if self._record.sim is not None and self._record.sim.fault:
            raise MissionFaultError(self._record.sim.fault)

    def _look_after_drivers(self, drivers: DriverWatch) -> None:
        held_s = self._plan.control.held_ns * NANOSECOND_S
        for mu, silent in drivers.changes(self._record.common_ns or 0):
            if silent:
                goes_on = "the others fly on and close the net without it"
                if self._record.phase == Phase.HOLDING:
                    goes_on = "the hold test goes on, in which all units are off"
                self._warn(
                    f"the driver of MU {mu} has fallen silent: no odometry for more than {held_s:g} s, zero thrust; "
                    f"{goes_on}"
                )
            else:
                self._display.note(f"the driver of MU {mu} is heard again")

    def _on_hang(self, name: str) -> None:
        text = f"{name} hangs: it has answered nothing for {self._plan.parameters.hang_timeout_s:g} s"
        mu = mu_of(name)
        if mu is None or not self._started:
            raise MissionFaultError(text)
        self._record.lost_controllers.add(mu)
        self._warn(f"{text}; {self._without_controller}")

    @property
    def _without_controller(self) -> str:
        """What becomes of the mission whose controller is lost now."""
        if self._record.phase == Phase.HOLDING:
            return "the hold test goes on, in which all units are off"
        return "the mission goes on, its thrust held for a moment and then zero"

    def _on_stranger(self, node: str, topic: str) -> None:
        if topic in map(topics.mu_odometry, self._plan.external):
            heard = "it cannot be told from the driver and is heard like it"
        else:
            # Whoever flies with the mission's own profile is in its partition; the graph does not tell partitions.
            heard = "not heard, unless with this mission's own DDS profile"
            if not self._plan.protected:
                heard = "the mission's nodes may obey it"
        self._warn(f"{_name(node)}, which is no node of this mission, publishes {topic}: {heard}")

    def _warn(self, text: str) -> None:
        """Say it at once, and again at the end."""
        when = f"at {self._record.time_s:.1f} s" if self._record.time_s is not None else "before launch"
        text = f"{when}: {text}"
        self._display.note(text)
        self._record.warnings.append(text)

    def _on_death(self, death: Exit) -> None:
        if self._record.phase.over and death.code == 0:
            return  # it has done its part
        self._display.note(death.report())
        if death.node.bystander:
            self._record.warnings.append(f"{death.node.name} died ({death.how}); the mission went on without it")
            return
        if self._pulse is not None:
            self._pulse.forget(death.node.name)
        mu = mu_of(death.node.name)
        if death.node.essential or mu is None or not self._started:
            raise MissionFaultError(_why(death))
        self._record.lost_controllers.add(mu)
        self._record.warnings.append(f"{death.node.name} died ({death.how}); {self._without_controller}")

    def _measure_memory(self) -> None:
        self._record.memory_mb = max(self._record.memory_mb or 0.0, self._supervisor.memory_mb())

    def _fault(self, reason: str) -> None:
        self._record.faults.append(reason)


def _why(death: Exit) -> str:
    last = f": {death.tail[-1].strip()}" if death.tail else ""
    return f"{death.node.name} died ({death.how}){last}"


def _name(node: str) -> str:
    """A node's name as it can be shown: it is somebody else's, and need not be what ROS allows."""
    return shown(node, SHORT) or "a nameless node"
