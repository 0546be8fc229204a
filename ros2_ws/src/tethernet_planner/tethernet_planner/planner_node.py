"""The planner as a process, the chaser's computer: aiming points as a service, the mission's phases, start, abort."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import quiet_start

    quiet_start()

import functools
import math
import secrets
import time
from collections.abc import Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from tethernet_core.aiming import FALLBACK
from tethernet_core.mission import Mission, Mode, Phase, seconds_between
from tethernet_core.parameters import ParameterError
from tethernet_core.settings import NANOSECOND_S, ControlParameters, MissionParameters
from tethernet_core.shown import SHORT, shown
from tethernet_core.step_guard import StampGuard, Step
from tethernet_core.system import load_system
from tethernet_msgs.msg import MissionState, MuStatus
from tethernet_msgs.srv import PlanAimingPoints
from tethernet_planner import policies
from tethernet_planner.closing_watch import ClosingWatch, DebrisMotion
from tethernet_planner.mission_rules import check_debris_position
from tethernet_planner.sequencer import MissionSequencer, mu_names
from tethernet_planner.settings import PlannerParameters, given_debris
from tethernet_planner.swarm import DockedPairs, SwarmCentroid
from tethernet_ros import checks, diagnostics, executor, topics
from tethernet_ros.checks import NetMeasurement, PlanRequest
from tethernet_ros.conversions import Vector, mission_message, nanoseconds, point_message
from tethernet_ros.door import Door
from tethernet_ros.newest_odometry import NewestOdometry
from tethernet_ros.parameters import NODE_OPTIONS, declare
from tethernet_ros.qos import BULK, CONTROL, STATE, STATE_BACKLOG
from tethernet_ros.serialized import OdometrySample
from tethernet_ros.template import Template
from tethernet_ros.well_formed import MessageError

_POLL_S = 0.05  # [s] wall time between two looks at the deadlines
_UNKNOWN: Vector = (math.nan, math.nan, math.nan)
_STOPPED = {
    Mode.NO_ODOMETRY: "no odometry: zero thrust",
    Mode.NO_PLANNER: "does not hear the planner: zero thrust",
    Mode.EMPTY: "propellant used up: zero thrust",
}


class PlannerNode(Node):
    """Carries messages to and from one :class:`MissionSequencer` and answers for the policies."""

    PARAMETERS = (PlannerParameters, ControlParameters, MissionParameters)

    def __init__(self) -> None:
        super().__init__("planner", **NODE_OPTIONS)
        self._settings, control, self._rules = declare(self, *self.PARAMETERS)
        self._period_ns = control.period_ns
        self._system = system = load_system(self._settings.system)
        try:
            policies.check(self._settings.policy, system)
        except policies.PolicyError as error:
            raise ParameterError(f"PlannerParameters.policy: {error}") from error
        mu_count = system.unit_count
        self._door = door = Door(self)
        self._state_publisher = door.publish(MissionState, topics.MISSION_STATE, STATE_BACKLOG)
        self._beat_publisher = door.publish(Header, topics.PLANNER_HEARTBEAT, CONTROL)
        self._diagnostics_publisher = door.publish(DiagnosticArray, topics.DIAGNOSTICS, BULK)
        self._sequencer = MissionSequencer(
            system,
            self._rules,
            control,
            self._publish_state,
            self._publish_beat,
            mission_id=secrets.randbits(64) | 1,  # 0 is a message nobody has filled
        )
        self._beat = Template(Header(frame_id=topics.FRAME))
        self._debris = NewestOdometry(control, given_debris(self._settings.debris_position))
        self._net = _UNKNOWN
        self._net_ns = -1
        self._net_clock = StampGuard(control)
        self._locked: list[bool] = []
        self._decided_ns = -1
        self._newest_measurement_s = time.monotonic()
        self._statuses: dict[int, MuStatus] = {}
        self._plans: dict[tuple[str, Vector], policies.Plan] = {}
        self._closing_watch = ClosingWatch(system, self._rules, control)
        self._closing_watch.debris = self._debris_motion

        door.serve(PlanAimingPoints, topics.PLAN_AIMING_POINTS, checks.plan_request, self._on_plan)
        door.serve(Trigger, topics.START, checks.trigger_request, self._on_start)
        door.serve(Trigger, topics.ABORT, checks.trigger_request, self._on_abort)
        door.subscribe(checks.odometry(), topics.DEBRIS_ODOMETRY, self._on_debris, STATE_BACKLOG)
        for mu in range(1, mu_count + 1):
            door.subscribe(checks.mu_status(mu), topics.mu_status(mu), self._on_status, STATE)
        self._pairs = DockedPairs(system)
        self._swarm = SwarmCentroid(mu_count, control, door.drop)
        if self._settings.simulated:
            door.subscribe(checks.net_state(system), topics.NET_STATE, self._on_net, BULK)
        if not self._settings.simulated or system.closing.kind == "docking":
            for mu in range(1, mu_count + 1):
                door.subscribe(checks.odometry(mu), topics.mu_odometry(mu), functools.partial(self._on_mu, mu), CONTROL)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_POLL_S, self._on_poll, clock=wall)
        self.create_timer(self._settings.diagnostics_period_s, self._on_diagnostics, clock=wall)
        self._sequencer.announce()

    # What is measured

    def _on_net(self, net: NetMeasurement) -> None:
        step = self._net_clock.take(net.stamp_ns)
        if not step.good:
            raise MessageError(self._net_clock.why(net.stamp_ns))
        if step is Step.ANEW:
            self._decided_ns = -1
        self._decide(complete=False)  # a tick that still lacks an MU's odometry does without now that time has gone on
        self._net, self._net_ns, self._locked = net.center, net.stamp_ns, net.locked
        self._decide()

    def _on_debris(self, sample: OdometrySample) -> None:
        if self._debris.take(sample):
            if self._settings.simulated:  # else the swarm's time counts: the debris' tracker may have another clock
                self._sequencer.saw_time(sample.stamp_ns)
            self._decide()

    def _on_mu(self, mu: int, sample: OdometrySample) -> None:
        swarm = self._swarm
        tick = swarm.update(mu, sample.stamp_ns, sample.position, sample.velocity)
        if self._settings.simulated:
            self._decide()
            return
        self._sequencer.saw_time(swarm.newest_ns)
        if tick is not None:
            if self._sequencer.mission.closing:
                self._pairs.update(swarm.positions)
            self._measured(tick.stamp_ns, tick.position, self._pairs.locked)

    def _decide(self, complete: bool = True) -> None:
        """Decide on the newest tick that net, debris and, when it shall be ``complete``, the MUs are known of."""
        stamp_ns = self._net_ns
        if stamp_ns <= self._decided_ns or self._debris.stamp_ns < stamp_ns:
            return
        if complete and self._swarm.awaited(stamp_ns, self._period_ns):
            return
        self._decided_ns = stamp_ns
        self._measured(stamp_ns, self._net, self._locked)

    def _measured(self, stamp_ns: int, net_position: Vector, locked: Sequence[bool]) -> None:
        self._newest_measurement_s = time.monotonic()
        positions, velocities = self._swarm.positions, self._swarm.velocities
        mus = sorted(positions)
        self._closing_watch.saw_mus(
            stamp_ns, [positions[mu] for mu in mus], [velocities[mu] for mu in mus], self._swarm.behind
        )
        self._sequencer.measured(
            stamp_ns, net_position, self._debris.position or _UNKNOWN, locked, self._closing_watch.look
        )

    def _debris_motion(self) -> DebrisMotion | None:
        """From its newest odometry; None where there is none."""
        sample = self._debris.sample
        return None if sample is None else (sample.position, sample.attitude, sample.linear, sample.angular)

    # What is asked for

    def _on_plan(self, request: PlanRequest, response: PlanAimingPoints.Response) -> PlanAimingPoints.Response:
        name = request.policy or self._settings.policy
        try:
            self._check_offered(name)
            plan = self._plan(name, request.mu_count or self._system.unit_count, request.debris_position)
        except ValueError as error:
            response.success, response.message = False, shown(error)
            return response
        response.success, response.policy = True, plan.policy
        response.message = shown(plan.message or f"{len(plan.points)} aiming points")
        response.aiming_points = [point_message(point) for point in plan.points]
        return response

    def _check_offered(self, name: str) -> None:
        """Who asks over the network may name a policy; the only file is the one that this planner was started with.

        Raises:
            ValueError: naming what is allowed; it does not tell whether there is such a file.
        """
        if name != self._settings.policy and name not in policies.names():
            allowed = ", ".join(policies.names())
            raise ValueError(
                f"no policy named {shown(name, SHORT)!r}; allowed: {allowed}, or the one this planner was started with"
            )

    def _plan(self, name: str, mu_count: int, debris_position: Vector) -> policies.Plan:
        system = self._system
        if mu_count != system.unit_count:
            raise ValueError(f"points for {mu_count} units; allowed: {system.unit_count}, of system {system.name}")
        if (name, debris_position) not in self._plans:  # else as a moment before, to another controller
            plan = policies.plan(name, system, check_debris_position(debris_position, self._rules))
            self._plans = {(name, debris_position): plan}
        return self._plans[name, debris_position]

    def _on_start(self, _: None, response: Trigger.Response) -> Trigger.Response:
        try:
            position = self._start()
        except ValueError as error:
            response.success, response.message = False, shown(error)
            self.get_logger().error(f"not started: {shown(error)}")
        else:
            place = ", ".join(f"{value:g}" for value in position)
            response.success, response.message = True, f"armed: policy {self._settings.policy}, debris at ({place}) m"
            self.get_logger().info(response.message)
        return response

    def _start(self) -> Vector:
        """Start the mission at the debris; returns where that is [m]."""
        position = self._debris.position
        if position is None:
            raise ValueError(
                f"nobody has told where the debris is: publish {topics.DEBRIS_ODOMETRY}, "
                "or set the parameter debris_position"
            )
        drivers = None if self._settings.simulated else self._swarm
        if drivers is not None and drivers.missing:
            raise ValueError(f"no odometry from {mu_names(drivers.missing)}: start the drivers first")
        for mu, late_ns in (drivers.behind if drivers is not None else {}).items():
            raise ValueError(
                f"the newest odometry of MU {mu} is {abs(late_ns) * NANOSECOND_S:.2f} s "
                f"{'older than the newest of all' if late_ns > 0 else 'newer than that of the others'}: "
                "its driver has stopped or the clocks are not synchronised"
            )
        if self._sequencer.mission.phase == Phase.WAITING:
            # Controllers will ask for it; better to know now that it cannot be had.
            plan = self._plan(self._settings.policy, self._system.unit_count, position)
            self._closing_watch.aiming_points = plan.points
            if plan.message:
                self.get_logger().warning(plan.message)
        self._newest_measurement_s = time.monotonic()
        self._sequencer.start(position, self._settings.policy)
        return position

    def _on_abort(self, _: None, response: Trigger.Response) -> Trigger.Response:
        response.success = self._sequencer.abort(f"asked for on {topics.ABORT}")
        response.message = "aborted" if response.success else f"over already: {self._sequencer.mission.phase.name}"
        self.get_logger().info(f"abort asked for: {response.message}")
        return response

    # What happens by itself

    def _on_status(self, message: MuStatus) -> None:
        self._statuses[message.mu] = message
        self._closing_watch.saw_status(message.mu, nanoseconds(message.header.stamp))
        self._sequencer.echoed(message.mu, message.mission_sequence)

    def _on_poll(self) -> None:
        self._sequencer.poll()
        patience_s = self._settings.silence_timeout_s
        if self._sequencer.mission.phase.under_way and time.monotonic() - self._newest_measurement_s > patience_s:
            self._sequencer.abort(f"nothing was measured for {patience_s:g} s")

    def _publish_state(self, mission: Mission, stamp_ns: int, confirmed: bool, reason: str) -> None:
        self._state_publisher.publish(mission_message(mission, stamp_ns, confirmed, reason))
        if confirmed and mission.sequence:
            when = f" {seconds_between(mission.launch_ns, stamp_ns):.2f} s after launch" if mission.launch_ns else ""
            self.get_logger().info(f"{mission.phase.name}{when}" + (f": {shown(reason)}" if reason else ""))

    def _publish_beat(self, stamp_ns: int) -> None:
        self._beat.stamp(stamp_ns)
        self._beat_publisher.publish_template(self._beat)

    # How it goes

    def _on_diagnostics(self) -> None:
        sequencer = self._sequencer
        mission = sequencer.mission
        bad = mission.phase in (Phase.MISSED, Phase.ABORTED)
        troubled = sequencer.lost or self._door.dropped
        level = diagnostics.ERROR if bad else diagnostics.WARN if troubled else diagnostics.OK
        entries = [
            diagnostics.entry(
                "planner", level, mission.reason or mission.phase.name,
                phase=mission.phase.name, sequence=mission.sequence, confirmed=sequencer.confirmed,
                policy=self._settings.policy, dropped_messages=self._door.dropped,
                dropped_on=self._door.summary() or "none",
                lost_controllers=mu_names(sequencer.lost) or "none",
            )
        ]  # fmt: skip
        entries += [self._controller_entry(mu) for mu in range(1, mission.mu_count + 1)]
        self._diagnostics_publisher.publish(diagnostics.array(sequencer.stamp_ns, entries))

    def _controller_entry(self, mu: int) -> DiagnosticStatus:
        name, status = f"mu{mu}_controller", self._statuses.get(mu)
        lost = mu in self._sequencer.lost
        if status is None:
            return diagnostics.entry(
                name, diagnostics.ERROR if lost else diagnostics.STALE, "does not answer" if lost else "not heard of"
            )
        mode = Mode(status.mode)
        level, text = diagnostics.OK, mode.name
        if lost:
            level, text = diagnostics.ERROR, "does not answer"
        elif mode in _STOPPED:
            level, text = diagnostics.ERROR, _STOPPED[mode]
        elif status.rejected_messages or status.aiming_source == FALLBACK:
            level = diagnostics.WARN
        return diagnostics.entry(
            name, level, text,
            aiming_source=shown(status.aiming_source, SHORT), tracking_error_m=status.tracking_error,
            fuel_kg=status.fuel, commands=status.commands, saturated=status.saturated,
            rejected_odometry=status.rejected_odometry, rejected_messages=status.rejected_messages,
            deadline_misses=status.deadline_misses,
        )  # fmt: skip


def main(args: list[str] | None = None) -> int:
    """Run the node; see :func:`tethernet_ros.executor.run` for the exit status."""
    return executor.run(PlannerNode, args)


if __name__ == "__main__":
    raise SystemExit(main())
