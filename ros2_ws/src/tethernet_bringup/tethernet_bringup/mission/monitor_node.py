"""The command's own node: sees the graph, tells the planner to start or to abort, listens to the mission."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Collection, Iterable, Mapping

import rclpy
from nav_msgs.msg import Odometry
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_srvs.srv import Trigger

from tethernet_bringup.mission.connection_check import ConnectionCheck
from tethernet_bringup.mission.drivers import DriverWatch
from tethernet_bringup.mission.graph import Endpoint, GraphCheck, Publisher, UnexpectedPublisherWatch
from tethernet_bringup.mission.outcome import FlightRecord, nanoseconds
from tethernet_bringup.nodes import MONITOR
from tethernet_bringup.pulse import Answer, Pulse
from tethernet_control.driver_sample import CLOCK, DRIVER_ODOMETRY, driver_sample
from tethernet_core.deadline import Deadline
from tethernet_core.mission import Phase
from tethernet_core.settings import ControlParameters
from tethernet_msgs.msg import CaptureAssessment, MuStatus, SimStatus
from tethernet_ros import checks, qos, topics
from tethernet_ros.checks import MissionNews
from tethernet_ros.connections import service_name
from tethernet_ros.door import Asker, Door
from tethernet_ros.executor import LEAVE_S, make_executor
from tethernet_ros.polled_group import PollingNode
from tethernet_ros.well_formed import MessageError


class Monitor:
    """The command's view of the mission. Nothing happens in the background: callbacks run inside :meth:`spin`."""

    def __init__(self, record: FlightRecord):
        """Join the graph.

        Args:
            record: gets what is heard.
        """
        # Signals stay with the command: they end the mission in order, not this node.
        rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], signal_handler_options=SignalHandlerOptions.NO)
        self._record = record
        self._node = PollingNode(MONITOR, start_parameter_services=False)
        self._executor = make_executor()
        self._executor.add_node(self._node)
        self._door = Door(self._node)
        self._start = self._door.ask(Trigger, topics.START)
        self._abort = self._door.ask(Trigger, topics.ABORT)
        subscribe, system = self._door.subscribe, record.system
        subscribe(checks.mission_state(system), topics.MISSION_STATE, self._on_state, qos.STATE_BACKLOG)
        subscribe(checks.assessment(system), topics.CAPTURE_ASSESSMENT, self._on_assessment, qos.STATE_BACKLOG)
        subscribe(checks.sim_status(system), topics.SIM_STATUS, self._on_sim, qos.STATE)
        # The newest accounts are looked at after each spin: to be woken by every one takes longer than to read it.
        self._accounts = [
            self._door.poll(checks.mu_status(mu), topics.mu_status(mu), self._on_status, qos.STATE)
            for mu in range(1, system.unit_count + 1)
        ]

    def close(self, status: int) -> None:
        """Leave the graph. Should the middleware hang in it for good, this process ends all the same.

        Args:
            status: its exit status then.
        """
        with Deadline(LEAVE_S, status):
            self._executor.remove_node(self._node)
            self._executor.shutdown()
            self._node.destroy_node()
            rclpy.try_shutdown()

    @property
    def dropped(self) -> dict[str, str]:
        """What this node could not use: how many messages and why the newest, by topic or service."""
        return {
            name: f"{drops.count} malformed messages, the newest: {drops.newest}"
            for name, drops in sorted(self._door.incoming.items())
        }

    def spin(self, timeout_s: float) -> None:
        """Handle what comes in for so long."""
        self._executor.spin_until_future_complete(Future(), timeout_sec=timeout_s)
        for look in self._accounts:
            look()

    def check_graph(self, endpoints: Iterable[Endpoint]) -> GraphCheck:
        """A comparison of the graph with what it should be."""
        return GraphCheck(
            endpoints,
            lambda topic: [info.node_name for info in self._node.get_publishers_info_by_topic(topic)],
            lambda topic: [info.node_name for info in self._node.get_subscriptions_info_by_topic(topic)],
        )

    def watch_unexpected_publishers(self, watched: Iterable[str]) -> UnexpectedPublisherWatch:
        """A watch on topics that should have one publisher each, and have it now."""
        return UnexpectedPublisherWatch(watched, self._node.count_publishers, self.publishers)

    def publishers(self, topic: str) -> list[Publisher]:
        """Everybody who publishes a topic, whether this node hears it or not."""
        return [
            Publisher(info.node_name, bytes(info.endpoint_gid))
            for info in self._node.get_publishers_info_by_topic(topic)
        ]

    def publisher_count(self, topic: str) -> int:
        """How many publish a topic."""
        return self._node.count_publishers(topic)

    def watch_drivers(self, mus: Iterable[int], control: ControlParameters, simulated: bool) -> DriverWatch:
        """A watch on the odometry of external MUs, from whatever they publish.

        Args:
            mus: their numbers.
            control: gives period and watchdog.
            simulated: whether the mission's clock is the simulator's, not this machine's.
        """
        watch = DriverWatch(mus, control, waiting=simulated)
        clock_ns: int | None = None

        def tick(time_ns: int) -> None:
            nonlocal clock_ns
            clock_ns = time_ns

        def hear(mu: int, message: Odometry) -> None:
            now_ns = clock_ns if simulated else time.time_ns()
            if now_ns is not None:  # else nothing can be said of its stamp yet, and more will come
                watch.saw(mu, driver_sample(message, time.monotonic(), now_ns))

        if simulated:
            self._door.subscribe(CLOCK, topics.CLOCK, tick, qos.CONTROL)
        for mu in mus:
            take = functools.partial(hear, mu)
            self._door.subscribe(DRIVER_ODOMETRY, topics.mu_odometry(mu), take, qos.CONTROL)
        return watch

    def planner_ready(self) -> bool:
        """Whether the planner's services can be called."""
        return self._start.ready()

    def start(self) -> Callable[[], tuple[bool, str] | None]:
        """Tell the planner to start the mission.

        Returns:
            Asks for its answer: None until it has come, then whether it agreed, and its message.
        """
        return self._call(self._start)

    def abort(self) -> Callable[[], tuple[bool, str] | None]:
        """Tell the planner to abort; as :meth:`start`."""
        if not self._abort.ready():
            return lambda: (False, "the planner's abort service is gone")
        return self._call(self._abort)

    def check_connections(
        self, listeners: Mapping[str, Mapping[str, Collection[str]]], onlookers: Mapping[str, Collection[str]]
    ) -> ConnectionCheck:
        """A comparison of whom the nodes have found with whom they should have found, see there."""
        services = {node: self._door.ask(Trigger, service_name(node)) for node in listeners}
        return ConnectionCheck(listeners, services, self._node.count_subscribers, onlookers)

    def watch_pulse(self, nodes: Iterable[str], patience_s: float) -> Pulse:
        """A watch on nodes of this project: each answers on its connections service as long as it runs.

        Args:
            nodes: their names.
            patience_s: a node that answers nothing for so long hangs [s].
        """

        def questions(node: str) -> Callable[[], Answer | None]:
            asker = self._door.ask(Trigger, service_name(node))
            return lambda: self._call(asker) if asker.ready() else None

        return Pulse({node: questions(node) for node in nodes}, patience_s)

    @staticmethod
    def _call(asker: Asker) -> Callable[[], tuple[bool, str] | None]:
        answers: list[tuple[bool, str]] = []

        def take(answer: tuple[bool, str] | MessageError) -> None:
            answers.append((False, str(answer)) if isinstance(answer, MessageError) else answer)

        asker.ask(Trigger.Request(), checks.trigger_answer, take)
        return lambda: answers[0] if answers else None

    def _on_state(self, news: MissionNews) -> None:
        self._record.take_state(news.message)

    def _on_assessment(self, message: CaptureAssessment) -> None:
        self._record.progress = message
        if message.stage == CaptureAssessment.TRIGGER:
            self._record.trigger = message
        elif message.stage == CaptureAssessment.FINAL:
            self._record.final = message
        elif message.stage == CaptureAssessment.HELD:
            self._record.hold = message

    def _on_status(self, message: MuStatus) -> None:
        self._record.statuses[message.mu] = message

    def _on_sim(self, message: SimStatus) -> None:
        self._record.sim = message


def settled(record: FlightRecord, simulated: bool) -> bool:
    """Whether all is told: the verdict, the simulator's account, every living controller's account up to the end."""
    if record.state is None or record.phase not in (Phase.COMPLETE, Phase.MISSED) or not record.all_judged:
        return record.phase == Phase.ABORTED
    if simulated and not (record.sim is not None and record.sim.finished):
        return False
    end_ns = nanoseconds(record.state.end_time)
    living = [mu for mu in range(1, record.system.unit_count + 1) if mu not in record.lost_controllers]
    return all(mu in record.statuses and nanoseconds(record.statuses[mu].header.stamp) >= end_ns for mu in living)
