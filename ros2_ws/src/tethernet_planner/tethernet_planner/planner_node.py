"""The planner as a process, the chaser's computer: aiming points as a service, the mission's phases, start, abort."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_control.quiet_start import quiet_start

    quiet_start()

import math
import secrets
import time

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from tethernet_control.controller import Mode
from tethernet_control.layout import FALLBACK, design
from tethernet_control.mission import Mission, Phase, check_debris_position
from tethernet_control.parameters import ParameterError
from tethernet_control.ros import diagnostics, executor, topics
from tethernet_control.ros.conversions import (
    MessageError,
    coordinates,
    finite,
    mission_message,
    nanoseconds,
    point_message,
    set_stamp,
)
from tethernet_control.ros.newest_odometry import NewestOdometry
from tethernet_control.ros.parameters import NODE_OPTIONS, declare
from tethernet_control.ros.qos import BULK, CONTROL, STATE, STATE_BACKLOG
from tethernet_control.ros.serialized_odometry import serialized_odometry_values
from tethernet_control.settings import NANOSECOND_S, ControlParameters, MissionParameters
from tethernet_control.step_guard import StampGuard, Step
from tethernet_msgs.msg import MissionState, MuStatus, NetState
from tethernet_msgs.srv import PlanAimingPoints

from . import policies
from .lookout import DebrisMotion, Lookout
from .sequencer import MissionSequencer, mu_names
from .settings import PlannerParameters
from .swarm import DockedPairs, SwarmCentroid

_POLL_S = 0.05  # [s] wall time between two looks at the deadlines
_UNKNOWN = (math.nan,) * 3
_STOPPED = {
    Mode.NO_ODOMETRY: "no odometry: zero thrust",
    Mode.NO_PLANNER: "does not hear the planner: zero thrust",
    Mode.EMPTY: "propellant used up: zero thrust",
}


class PlannerNode(Node):
    """Carries messages to and from one :class:`MissionSequencer` and answers for the policies."""

    PARAMETERS = (PlannerParameters, ControlParameters, MissionParameters)

    def __init__(self):
        super().__init__("planner", **NODE_OPTIONS)
        self._settings, control, self._rules = declare(self, *self.PARAMETERS)
        self._period_ns = control.period_ns
        try:
            policies.check(self._settings.policy, self._settings.mu_count)
        except policies.PolicyError as error:
            raise ParameterError(f"PlannerParameters.policy: {error}") from error
        mu_count = self._settings.mu_count
        self._state_publisher = self.create_publisher(MissionState, topics.MISSION_STATE, STATE)
        self._beat_publisher = self.create_publisher(Header, topics.PLANNER_HEARTBEAT, CONTROL)
        self._diagnostics_publisher = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, BULK)
        self._sequencer = MissionSequencer(
            mu_count,
            self._rules,
            control,
            self._publish_state,
            self._publish_beat,
            mission_id=secrets.randbits(64) | 1,  # 0 is a message nobody has filled
        )
        self._beat = Header(frame_id=topics.FRAME)
        place = tuple(self._settings.debris_position) or None
        self._debris = NewestOdometry("debris odometry", control, self._drop, place)
        self._net = _UNKNOWN
        self._net_ns = -1
        self._net_clock = StampGuard(control)
        self._locked: list[bool] = []
        self._decided_ns = -1
        self._dropped = 0
        self._newest_measurement_s = time.monotonic()
        self._statuses: dict[int, MuStatus] = {}
        self._lookout = Lookout(mu_count, self._rules, control)
        self._lookout.debris = self._debris_motion

        self.create_service(PlanAimingPoints, topics.PLAN_AIMING_POINTS, self._on_plan)
        self.create_service(Trigger, topics.START, self._on_start)
        self.create_service(Trigger, topics.ABORT, self._on_abort)
        self.create_subscription(Odometry, topics.DEBRIS_ODOMETRY, self._on_debris, STATE_BACKLOG, raw=True)
        for mu in range(1, mu_count + 1):
            self.create_subscription(MuStatus, topics.mu_status(mu), self._on_status, STATE)
        self._pairs = DockedPairs(mu_count, self._rules.docking_distance_m)
        self._swarm = SwarmCentroid(mu_count, control, self._drop)
        if self._settings.simulated:
            self.create_subscription(NetState, topics.NET_STATE, self._on_net, BULK)
        if not self._settings.simulated or design(mu_count).closes_by_docking:
            for mu in range(1, mu_count + 1):
                self.create_subscription(
                    Odometry, topics.mu_odometry(mu), lambda data, mu=mu: self._on_mu(mu, data), CONTROL, raw=True
                )
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_POLL_S, self._on_poll, clock=wall)
        self.create_timer(self._settings.diagnostics_period_s, self._on_diagnostics, clock=wall)
        self._sequencer.announce()

    # What is measured

    def _on_net(self, message: NetState) -> None:
        stamp_ns = nanoseconds(message.header.stamp)
        step = self._net_clock.take(stamp_ns)
        if not step.good:
            self._drop("net state", self._net_clock.why(stamp_ns))
            return
        if step is Step.ANEW:
            self._decided_ns = -1
        self._decide(complete=False)  # a tick that still lacks an MU's odometry does without now that time has gone on
        center = coordinates(message.center_of_mass)
        if not finite(*center):
            # The tick is still decided on, with nothing known of the net: a lock-step simulator waits for the
            # heartbeat.
            self._drop("net state", "its centre of mass is not finite")
            center = _UNKNOWN
        self._net, self._net_ns, self._locked = center, stamp_ns, message.locked
        self._decide()

    def _on_debris(self, data: bytes) -> None:
        if self._debris.take(data):
            if self._settings.simulated:  # else the swarm's time counts: the debris' tracker may have another clock
                self._sequencer.saw_time(self._debris.stamp_ns)
            self._decide()

    def _on_mu(self, mu: int, data: bytes) -> None:
        try:
            stamp_ns, position, velocity = serialized_odometry_values(data)
        except MessageError as error:
            self._drop(f"odometry of MU {mu}", str(error))
            return
        if not finite(*position, *velocity):
            self._drop(f"odometry of MU {mu}", "not finite")
            return
        swarm = self._swarm
        tick = swarm.update(mu, stamp_ns, position, velocity)
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

    def _measured(self, stamp_ns: int, net_position, locked) -> None:
        self._newest_measurement_s = time.monotonic()
        positions, velocities = self._swarm.positions, self._swarm.velocities
        mus = sorted(positions)
        self._lookout.saw_mus(
            stamp_ns, [positions[mu] for mu in mus], [velocities[mu] for mu in mus], self._swarm.behind
        )
        self._sequencer.measured(stamp_ns, net_position, self._debris.position or _UNKNOWN, locked, self._lookout.look)

    def _debris_motion(self) -> DebrisMotion | None:
        """From its newest odometry; None where there is none."""
        if self._debris.data is None:
            return None
        message = deserialize_message(self._debris.data, Odometry)
        pose, twist = message.pose.pose, message.twist.twist
        q = pose.orientation
        return (
            coordinates(pose.position),
            (q.x, q.y, q.z, q.w),
            coordinates(twist.linear),
            coordinates(twist.angular),
        )

    def _drop(self, what: str, why: str) -> None:
        self._dropped += 1
        self.get_logger().warning(f"{what} dropped: {why} ({self._dropped} dropped so far)", throttle_duration_sec=1.0)

    # What is asked for

    def _on_plan(
        self, request: PlanAimingPoints.Request, response: PlanAimingPoints.Response
    ) -> PlanAimingPoints.Response:
        name = request.policy or self._settings.policy
        try:
            plan = self._plan(name, request.mu_count or self._settings.mu_count, coordinates(request.debris_position))
        except ValueError as error:
            response.success, response.message = False, str(error)
            return response
        response.success, response.policy = True, plan.policy
        response.message = plan.message or f"{len(plan.points)} aiming points"
        response.aiming_points = [point_message(point) for point in plan.points]
        return response

    def _plan(self, name: str, mu_count: int, debris_position) -> policies.Plan:
        design(mu_count)
        position = check_debris_position(debris_position, self._rules)
        return policies.plan(name, mu_count, position)

    def _on_start(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._start()
        except ValueError as error:
            response.success, response.message = False, str(error)
            self.get_logger().error(f"not started: {error}")
        else:
            place = ", ".join(f"{value:g}" for value in self._debris.position)
            response.success, response.message = True, f"armed: policy {self._settings.policy}, debris at ({place}) m"
            self.get_logger().info(response.message)
        return response

    def _start(self) -> None:
        if self._debris.position is None:
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
            plan = self._plan(self._settings.policy, self._settings.mu_count, self._debris.position)
            self._lookout.aiming_points = plan.points
            if plan.message:
                self.get_logger().warning(plan.message)
        self._newest_measurement_s = time.monotonic()
        self._sequencer.start(self._debris.position, self._settings.policy)

    def _on_abort(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._sequencer.abort(f"asked for on {topics.ABORT}")
        response.message = "aborted" if response.success else f"over already: {self._sequencer.mission.phase.name}"
        self.get_logger().info(f"abort asked for: {response.message}")
        return response

    # What happens by itself

    def _on_status(self, message: MuStatus) -> None:
        self._statuses[message.mu] = message
        self._lookout.saw_status(message.mu, nanoseconds(message.header.stamp))
        self._sequencer.echoed(message.mu, message.mission_sequence)

    def _on_poll(self) -> None:
        self._sequencer.poll()
        flying = self._sequencer.mission.phase in (Phase.DEPLOYING, Phase.CLOSING)
        patience_s = self._settings.silence_timeout_s
        if flying and time.monotonic() - self._newest_measurement_s > patience_s:
            self._sequencer.abort(f"nothing was measured for {patience_s:g} s")

    def _publish_state(self, mission: Mission, stamp_ns: int, confirmed: bool, reason: str) -> None:
        self._state_publisher.publish(mission_message(mission, stamp_ns, confirmed, reason))
        if confirmed and mission.sequence:
            self.get_logger().info(
                f"{mission.phase.name} at {stamp_ns * 1e-9:.2f} s" + (f": {reason}" if reason else "")
            )

    def _publish_beat(self, stamp_ns: int) -> None:
        set_stamp(self._beat.stamp, stamp_ns)
        self._beat_publisher.publish(self._beat)

    # How it goes

    def _on_diagnostics(self) -> None:
        sequencer = self._sequencer
        mission = sequencer.mission
        bad = mission.phase in (Phase.MISSED, Phase.ABORTED)
        level = diagnostics.ERROR if bad else diagnostics.WARN if sequencer.lost or self._dropped else diagnostics.OK
        entries = [
            diagnostics.entry(
                "planner", level, mission.reason or mission.phase.name,
                phase=mission.phase.name, sequence=mission.sequence, confirmed=sequencer.confirmed,
                policy=self._settings.policy, dropped_measurements=self._dropped,
                lost_controllers=mu_names(sequencer.lost) or "none",
            )
        ]  # fmt: skip
        entries += [self._controller_entry(mu) for mu in range(1, mission.mu_count + 1)]
        self._diagnostics_publisher.publish(diagnostics.array(sequencer.stamp_ns, entries))

    def _controller_entry(self, mu: int):
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
        elif status.rejected_odometry or status.aiming_source == FALLBACK:
            level = diagnostics.WARN
        return diagnostics.entry(
            name, level, text,
            aiming_source=status.aiming_source, tracking_error_m=status.tracking_error, fuel_kg=status.fuel,
            commands=status.commands, saturated=status.saturated, rejected_odometry=status.rejected_odometry,
            deadline_misses=status.deadline_misses,
        )  # fmt: skip


def main(args: list[str] | None = None) -> int:
    """Run the node; see :func:`tethernet_control.ros.executor.run` for the exit status."""
    return executor.run(PlannerNode, args)


if __name__ == "__main__":
    raise SystemExit(main())
