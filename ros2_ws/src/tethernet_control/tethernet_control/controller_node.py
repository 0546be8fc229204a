"""The controller of one unit as a process: odometry in, thrust out; see the package README for the contract it keeps.

Started as ``python -m tethernet_control.controller_node --ros-args -p mu:=3``, it becomes node ``mu3_controller``.
"""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import quiet_start

    quiet_start()

import functools
import math
import re
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from geometry_msgs.msg import WrenchStamped
from rclpy.clock import Clock, ClockType

from tethernet_control.controller import ZERO, MuController
from tethernet_core.aiming import FALLBACK, nominal_aiming_points
from tethernet_core.mission import Mode, Phase
from tethernet_core.parameters import ParameterError, parameter
from tethernet_core.settings import NANOSECOND_S, ControlParameters
from tethernet_core.system import MOST_UNITS, load_system
from tethernet_msgs.msg import MuStatus
from tethernet_msgs.srv import PlanAimingPoints
from tethernet_ros import checks, executor, topics
from tethernet_ros.checks import MissionNews, PlanAnswer
from tethernet_ros.conversions import Vector, point_message, set_stamp
from tethernet_ros.door import Door
from tethernet_ros.parameters import NODE_OPTIONS, declare
from tethernet_ros.polled_group import PollingNode
from tethernet_ros.qos import CONTROL, STATE
from tethernet_ros.serialized import OdometrySample
from tethernet_ros.template import Template
from tethernet_ros.well_formed import MessageError


@dataclass(frozen=True)
class ControllerIdentity:
    """What only this process knows: which unit of which system it controls, and how wall time goes here."""

    FILE: ClassVar[Path] = Path(__file__).parent / "config" / "controller_node.yaml"

    mu: int = parameter("Number of the unit in its system; has no default", low=1, high=MOST_UNITS)
    system: str = parameter("Of which it is a unit: name of a shipped system, or path of a description")
    watchdog_wall_factor: float = parameter(
        "Wall time that the watchdog allows for one period of mission time: 1 where they are the same; "
        "more in lock-step, where a halt of the machine is no loss of odometry",
        low=1.0,
        high=1000.0,
    )


class ControllerNode(PollingNode):
    """Carries messages to and from one :class:`MuController`; decides nothing but what is about wall time.

    Wall time matters twice: the watchdog on odometry, and the bounded wait for the planner's service. The watchdog on
    the planner goes by odometry's stamps.
    """

    PARAMETERS = (ControllerIdentity, ControlParameters)

    def __init__(self, name: str = "mu_controller"):
        super().__init__(name, **NODE_OPTIONS)
        identity, self._settings = declare(self, *self.PARAMETERS)
        self._mu = identity.mu
        self._system = system = load_system(identity.system)
        if identity.mu > system.unit_count:
            raise ParameterError(
                f"ControllerIdentity.mu = {identity.mu}: system {system.name} has no such unit; allowed: "
                + (f"1 to {system.unit_count}" if system.units else "none, it has no units")
            )
        self._controller = MuController(identity.mu, self._settings, system.units[identity.mu - 1])
        self._period_s = self._settings.control_period_s
        self._patience_s = self._settings.watchdog_periods * self._period_s * identity.watchdog_wall_factor
        self._echo = 0
        self._published: tuple[object, ...] = ()
        self._answered = 0
        self._newest_odometry_s = math.inf
        self._plan_deadline_s = math.inf
        self._plan_asked = False
        thrust = WrenchStamped()
        thrust.header.frame_id = topics.FRAME
        self._thrust = Template(thrust)
        self._force = self._thrust.doubles("wrench.force.x", 3)
        self._status = MuStatus(mu=identity.mu)
        self._status.header.frame_id = topics.FRAME

        self._door = door = Door(self)
        self._thrust_publisher = door.publish(WrenchStamped, topics.mu_thrust(self._mu), CONTROL)
        self._status_publisher = door.publish(MuStatus, topics.mu_status(self._mu), STATE)
        self._planner = door.ask(PlanAimingPoints, topics.PLAN_AIMING_POINTS)
        door.subscribe(checks.mission_state(system), topics.MISSION_STATE, self._on_mission, STATE, self._on_drop)
        # It counts by odometry's stamps, so it is early enough with the next sample: to be woken by each would take as
        # long as to answer one.
        self._hear_heartbeats = door.poll(
            checks.HEARTBEAT, topics.PLANNER_HEARTBEAT, self._on_heartbeat, CONTROL, self._on_drop
        )
        odometry = checks.odometry(self._mu)
        door.subscribe(odometry, topics.mu_odometry(self._mu), self._on_odometry, CONTROL, self._on_drop)
        self.create_timer(self._period_s, self._on_wall_period, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._publish_status()

    def _on_odometry(self, sample: OdometrySample) -> None:
        self._hear_heartbeats()
        controller, stamp_ns = self._controller, sample.stamp_ns
        mode, resets = controller.mode, controller.statistics.clock_resets
        thrust = controller.on_odometry(stamp_ns, sample.position, sample.velocity)
        if thrust is None:
            raise MessageError(controller.dropped_because)
        if controller.statistics.clock_resets != resets:
            self.get_logger().warning(f"odometry's clock was set anew, to {stamp_ns * NANOSECOND_S:.2f} s; followed")
        self._newest_odometry_s = time.monotonic()
        self._publish_thrust(stamp_ns, thrust)
        self._answered += 1
        if self._answered % self._settings.status_every == 0 or self._news() != self._published:
            self._publish_status()
        if controller.mode != mode:
            self._tell_mode()

    def _tell_mode(self) -> None:
        """Log why thrust is off although the mission flies."""
        p = self._settings
        why = {
            Mode.NO_PLANNER: f"no news of the planner for {p.planner_timeout_s:g} s: zero thrust until it is back",
            Mode.EMPTY: f"the propellant of {self._controller.unit.propellant_kg:g} kg is used up: thrust off",
        }.get(self._controller.mode)
        if why:
            self.get_logger().error(why)

    def _on_heartbeat(self, stamp_ns: int) -> None:
        self._controller.on_heartbeat(stamp_ns)

    def _on_drop(self) -> None:
        if self._news() != self._published:
            self._publish_status()

    def _publish_thrust(self, stamp_ns: int, thrust: Vector) -> None:
        self._thrust.stamp(stamp_ns)
        self._force[:] = thrust
        self._thrust_publisher.publish_template(self._thrust)

    def _on_mission(self, news: MissionNews) -> None:
        self._hear_heartbeats()
        controller, mission = self._controller, news.mission
        led_by, refused = controller.mission.mission_id, controller.refused_states
        if not controller.take_mission(mission):
            if controller.refused_states != refused:
                self.get_logger().warning(
                    f"state {mission.sequence} ({mission.phase.name}) of the mission of planner {mission.mission_id} "
                    f"refused: flying that of {led_by}, or too far off its count",
                    throttle_duration_sec=1.0,
                )
                self._publish_status()
            return
        if mission.mission_id != led_by:
            self._plan_deadline_s, self._plan_asked = math.inf, False
        if mission.phase == Phase.ABORTED:
            # Do not wait for the next odometry: it may never come.
            self._zero_now()
        needs_plan = mission.phase in (Phase.ARMED, Phase.DEPLOYING, Phase.CLOSING) and controller.aiming_point is None
        if not needs_plan:
            self._confirm()
        elif self._plan_deadline_s == math.inf:
            self._plan_deadline_s = time.monotonic() + self._settings.plan_timeout_s
            self._ask_planner()

    def _ask_planner(self) -> None:
        """Send the request as soon as the service is there; give up at the deadline."""
        if time.monotonic() >= self._plan_deadline_s:
            self._fall_back(f"no answer from {topics.PLAN_AIMING_POINTS} within {self._settings.plan_timeout_s:g} s")
        elif not self._plan_asked and self._planner.ready():
            mission = self._controller.mission
            self._plan_asked = True
            request = PlanAimingPoints.Request(
                debris_position=point_message(mission.debris_position), mu_count=mission.mu_count, policy=mission.policy
            )
            check, asked_by = checks.plan_answer(mission.mu_count), mission.mission_id
            self._planner.ask(request, check, functools.partial(self._on_plan, asked_by))

    def _on_plan(self, asked_by: int, answer: PlanAnswer | MessageError) -> None:
        if self._controller.aiming_point is not None or self._controller.mission.mission_id != asked_by:
            return  # too late: the nominal points were taken and said so, or another planner leads
        if isinstance(answer, MessageError):
            self._fall_back(f"the answer of {topics.PLAN_AIMING_POINTS} is of no use: {answer}")
        elif not answer.success:
            self._fall_back(f"the planner has no aiming points: {answer.message}")
        else:
            self._aim(answer.points[self._mu - 1], answer.policy)

    def _fall_back(self, why: str) -> None:
        self.get_logger().warning(f"{why}; flying to the nominal aiming point")
        mission = self._controller.mission
        self._aim(nominal_aiming_points(self._system, mission.debris_position)[self._mu - 1], FALLBACK)

    def _aim(self, point: Vector, source: str) -> None:
        self._plan_deadline_s = math.inf
        self._controller.aim(point, source)
        self._confirm()

    def _confirm(self) -> None:
        """Echo the newest state of the mission: this controller is ready to act on it."""
        self._echo = self._controller.mission.sequence
        self._publish_status()

    def _on_wall_period(self) -> None:
        self._hear_heartbeats()
        now = time.monotonic()
        if self._plan_deadline_s < math.inf:
            self._ask_planner()
        if now - self._newest_odometry_s > self._patience_s and self._controller.odometry_lost():
            self.get_logger().warning(f"no odometry for {self._patience_s:g} s: zero thrust until it comes back")
            self._zero_now()
            self._publish_status()

    def _zero_now(self) -> None:
        """Zero thrust outside the rhythm, stamped as the newest odometry.

        That was answered already: in a lock-step that merely halts, the simulator keeps the first answer.
        """
        if self._controller.stamp_ns is not None:
            self._publish_thrust(self._controller.stamp_ns, ZERO)

    def _news(self) -> tuple[object, ...]:
        """What is reported at once when it changes."""
        controller = self._controller
        return (controller.mode, self._echo, controller.aiming_source, self._door.dropped)

    def _publish_status(self) -> None:
        controller, status = self._controller, self._status
        statistics = controller.statistics
        self._published = self._news()
        set_stamp(status.header.stamp, controller.stamp_ns or 0)
        status.mode = int(controller.mode)
        status.mission_sequence = self._echo
        if controller.aiming_point is not None:
            aim = status.aiming_point
            aim.x, aim.y, aim.z = controller.aiming_point
            status.aiming_source = controller.aiming_source
        if math.isfinite(controller.desired[0]):  # there is none before launch
            desired = status.desired_position
            desired.x, desired.y, desired.z = controller.desired
        status.tracking_error = statistics.tracking_error_m
        status.max_tracking_error = statistics.max_tracking_error_m
        status.fuel = statistics.fuel_kg
        status.fuel_at_trigger = statistics.fuel_at_trigger_kg
        status.commands = statistics.commands
        status.saturated = statistics.saturated
        status.propellant = controller.propellant_kg
        # What the controller refuses is dropped at the door too.
        status.rejected_odometry = self._door.counts[topics.mu_odometry(self._mu)]
        status.rejected_messages = self._door.dropped
        status.clock_jumps = statistics.clock_jumps
        status.refused_states = controller.refused_states
        status.deadline_misses = statistics.deadline_misses
        status.outliers = statistics.outliers
        status.position_sigma = statistics.position_sigma_m
        status.velocity_sigma = statistics.velocity_sigma_m_s
        self._status_publisher.publish(status)


def node_name(args: list[str]) -> str:
    """``mu3_controller`` when ``args`` hold ``-p mu:=3``; a node's name must be known before its parameters are."""
    numbers = [match.group(1) for argument in args if (match := re.fullmatch(r"mu:=(\d+)", argument))]
    return f"mu{numbers[-1]}_controller" if numbers else "mu_controller"


def main(args: list[str] | None = None) -> int:
    """Run the node; see :func:`tethernet_ros.executor.run` for the exit status."""
    args = sys.argv if args is None else args
    return executor.run(lambda: ControllerNode(node_name(args)), args)


if __name__ == "__main__":
    raise SystemExit(main())
