"""The simulator's node: stands in for the real world."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import quiet_start

    quiet_start()

import functools
import sys
import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from tethernet_control import law
from tethernet_core.mission import Mission, Phase, seconds_between
from tethernet_core.mission_gate import MissionGate
from tethernet_core.settings import NANOSECOND_S, ControlParameters
from tethernet_core.system import load_system
from tethernet_msgs.msg import NetState, SimStatus
from tethernet_ros import checks, diagnostics, qos, topics
from tethernet_ros.checks import MissionNews
from tethernet_ros.conversions import set_stamp
from tethernet_ros.door import Door
from tethernet_ros.executor import run
from tethernet_ros.parameters import NODE_OPTIONS, declare
from tethernet_ros.serialized import OdometrySample, ThrustCommand
from tethernet_ros.well_formed import MessageError
from tethernet_sim.latency import LatencyCount
from tethernet_sim.loads import Loads
from tethernet_sim.lockstep import LOOKS, Barrier, CommandBuffer
from tethernet_sim.ros.kernel_loading import KernelLoading
from tethernet_sim.ros.markers import Pictures
from tethernet_sim.ros.messages import BodyOdometry, ClockMessage, NetStateMessage, Transforms, UnitOdometry
from tethernet_sim.sensors import OdometryNoise
from tethernet_sim.settings import PhysicsParameters, ScenarioParameters, SimNodeParameters
from tethernet_sim.state import CHASER, DEBRIS
from tethernet_sim.world import World, divergence

PLANNER = "planner"
_EXTERNAL = "odometry of mu"
_FIRST = np.zeros(1, int)
"""Index of the only scenario."""
_FIRST_TICK = 20
"""The first control tick: a stamp of zero means to many readers that none was set, and nothing could be before it."""
_WAITING_CLOCK_S = 0.2
"""[s] wall time between two ticks of the clock while drivers of external MUs are waited for."""


class SimNode(Node):
    """Flies one scenario; starts when the planner's launch is confirmed, stops when the mission is over.

    Made, it is in the graph with all its endpoints; before it may spin it needs :meth:`make_world`.
    """

    PARAMETERS = (SimNodeParameters, ScenarioParameters, ControlParameters, PhysicsParameters)

    def __init__(self) -> None:
        super().__init__("sim", **NODE_OPTIONS)
        self.p, self.scenario, self.control, self._physics = declare(self, *self.PARAMETERS)
        self.system = system = load_system(self.scenario.system)
        mus = system.unit_count
        self.mus = range(1, mus + 1)
        self.external = set(self.scenario.external_units(system))
        self._heard_ns = dict.fromkeys(self.external, 0)
        """Stamp of the newest odometry of external MUs [ns]."""
        self.noise = OdometryNoise(self.scenario.seed, mus, self.control)
        self.lockstep = self.scenario.pace == "lockstep"
        self.gate = MissionGate(Mission(mus))
        self.stamp_ns = self._first_ns = _FIRST_TICK * self.control.period_ns
        self.flying = self.finished = self._pending = False
        self.books = {mu: CommandBuffer(self.control, system.units[mu - 1]) for mu in self.mus}
        self.barrier = Barrier(
            frozenset([PLANNER, *map(topics.mu_frame, self.mus), *(f"{_EXTERNAL}{mu}" for mu in self.external)])
        )
        self.fault = ""
        self.fuel = np.zeros(mus)
        self.latencies = LatencyCount()
        self._sent_at = [0.0] * mus
        self._launched_at = 0.0
        self._door = Door(self)
        self._make_publishers()
        self._make_subscriptions()

    def make_world(self) -> None:
        """Make what is flown, with the kernels, and tell where the bodies are."""
        s = self.scenario
        position, attitude, rate = (np.array([it]) for it in (s.debris_position, s.debris_attitude, s.debris_rate))
        self.world = World(self.system, position, attitude, rate, self._physics, self.control)
        self.loads = Loads(self.world)
        for mu in self.external:
            self.world.external[0, mu - 1] = True
            self.world.target_pos[0, mu - 1] = self.world.state.mu_pos[0, mu - 1]
        # Lock-step: looks whether a wait has run out. Real time: the pace itself.
        self._wake_s = self.p.answer_timeout_s / LOOKS if self.lockstep else self.control.control_period_s
        self._timer = self.create_timer(self._wake_s, self._on_timer, clock=RosClock(clock_type=ClockType.STEADY_TIME))
        if not self.lockstep:
            self._timer.cancel()
        self._publish_body(DEBRIS)
        self._publish_body(CHASER)
        if self.external:
            self._waiting_timer = self.create_timer(
                _WAITING_CLOCK_S, self._on_waiting, clock=RosClock(clock_type=ClockType.STEADY_TIME)
            )

    def _on_waiting(self) -> None:
        """Before the mission is armed the clock goes on slowly: a driver answers it with where its MU is."""
        if self.mission.phase != Phase.WAITING:
            self._waiting_timer.cancel()
            return
        self.stamp_ns += self.control.period_ns
        self._first_ns = self.stamp_ns
        self._publish_body(DEBRIS)
        self._publish_body(CHASER)
        self._publish_clock(self.stamp_ns - self.control.period_ns)

    @property
    def mission(self) -> Mission:
        """The newest state of the mission that counts."""
        return self.gate.mission

    @property
    def _flown_ns(self) -> int:
        """Since the first tick [ns]."""
        return self.stamp_ns - self._first_ns

    def _make_publishers(self) -> None:
        make = self._door.publish
        self._time, self._clock_out = ClockMessage(), make(Clock, topics.CLOCK, qos.CONTROL)
        self._odometry = {mu: UnitOdometry(mu, self.control) for mu in self.mus if mu not in self.external}
        self._odometry_out = {mu: make(Odometry, topics.mu_odometry(mu), qos.CONTROL) for mu in self._odometry}
        self._bodies = {
            DEBRIS: (BodyOdometry(DEBRIS, "debris"), make(Odometry, topics.DEBRIS_ODOMETRY, qos.STATE_BACKLOG)),
            CHASER: (BodyOdometry(CHASER, "chaser"), make(Odometry, topics.CHASER_ODOMETRY, qos.STATE_BACKLOG)),
        }
        self._net, self._net_out = NetStateMessage(self.system), make(NetState, topics.NET_STATE, qos.BULK)
        self._tf, self._tf_out = Transforms(len(self.mus)), make(TFMessage, topics.TF, qos.BULK)
        self._pictures = Pictures(self.system, self.p.markers_every * self.control.control_period_s, self._door)
        self._status_out = make(SimStatus, topics.SIM_STATUS, qos.STATE)
        self._diagnostics_out = make(DiagnosticArray, topics.DIAGNOSTICS, qos.BULK)

    def _make_subscriptions(self) -> None:
        subscribe = self._door.subscribe
        subscribe(checks.mission_state(self.system), topics.MISSION_STATE, self._on_mission, qos.STATE)
        subscribe(checks.HEARTBEAT, topics.PLANNER_HEARTBEAT, self._on_heartbeat, qos.CONTROL)
        for mu in self.mus:
            take = functools.partial(self._on_thrust, mu, topics.mu_frame(mu))
            subscribe(checks.THRUST, topics.mu_thrust(mu), take, qos.CONTROL)
        for mu in self.external:
            follow = functools.partial(self._on_external, mu)
            subscribe(checks.odometry(mu), topics.mu_odometry(mu), follow, qos.CONTROL)

    def _on_mission(self, news: MissionNews) -> None:
        mission = news.mission
        if not self.gate.take(mission) and not self.gate.is_present(mission):
            self.get_logger().warning(
                f"state {mission.sequence} ({mission.phase.name}) of planner {mission.mission_id}'s mission ignored: "
                f"that of {self.mission.mission_id} is flown, in state {self.mission.sequence}",
                throttle_duration_sec=1.0,
            )
            return
        if mission.phase.over:
            self._finish()
        elif mission.phase == Phase.DEPLOYING and news.confirmed and not self.flying and not self.finished:
            self.flying = True
            self.world.launch(0)
            self._launched_at = time.perf_counter()
            if not self.lockstep:
                self._timer.reset()
            self._publish_tick()

    def _on_heartbeat(self, stamp_ns: int) -> None:
        if stamp_ns > self.stamp_ns:
            raise MessageError(f"a heartbeat for {stamp_ns} ns, and the simulation is at {self.stamp_ns} ns")
        self._answered(PLANNER, stamp_ns)

    def _on_thrust(self, mu: int, name: str, command: ThrustCommand) -> None:
        stamp_ns = command.stamp_ns
        answered = name not in self.barrier.pending
        if self.lockstep and stamp_ns == self.stamp_ns and answered and name not in self.barrier.lost:
            return  # a watchdog's afterthought on a slow machine must not change what was already answered
        if not self.books[mu].take(stamp_ns, command.force, self.stamp_ns):
            raise MessageError(f"it answers {stamp_ns} ns: of the future, or older than the command that is held")
        if stamp_ns == self.stamp_ns:
            self.latencies.add(time.perf_counter() - self._sent_at[mu - 1])
        self._answered(name, stamp_ns)

    def _on_external(self, mu: int, sample: OdometrySample) -> None:
        # The sample may be older than the tick: the stand-in follows where the MU is now.
        age, most = seconds_between(sample.stamp_ns, self.stamp_ns), seconds_between(0, self.control.held_ns)
        if not 0.0 <= age <= most:
            raise MessageError(
                f"its stamp is {age:.3g} s older than the tick; allowed: 0 to {most:g} s, by {topics.CLOCK}"
            )
        self.world.target_vel[0, mu - 1] = sample.velocity
        self.world.target_pos[0, mu - 1] = np.add(sample.position, np.multiply(sample.velocity, age))
        self._heard_ns[mu] = sample.stamp_ns
        self._answered(f"{_EXTERNAL}{mu}", sample.stamp_ns)

    def _answered(self, who: str, stamp_ns: int) -> None:
        if self.flying and self.barrier.answer(who, stamp_ns):
            if self.lockstep:
                self._advance()
            else:
                self._publish_deferred()

    def _on_timer(self) -> None:
        if not self.flying:
            return
        if not self.lockstep:
            self._advance()
            return
        waited_s = self.barrier.look(time.monotonic(), self._wake_s)
        if waited_s > self.p.answer_timeout_s and self.barrier.pending:
            missing = self.barrier.give_up()
            self.get_logger().error(
                f"no answer to t = {self._flown_ns * NANOSECOND_S:.2f} s within {self.p.answer_timeout_s:g} s from "
                f"{', '.join(missing)}: going on without, held commands are zeroed after "
                f"{self.control.watchdog_periods} periods"
            )
            self._advance()

    def _advance(self) -> None:
        """One control period with the commands at hand, then tell what is measured."""
        self._publish_deferred()  # in real time, when not everybody has answered
        period = self.control.period_ns * NANOSECOND_S
        thrust = np.array([self.books[mu].thrust(self.stamp_ns) for mu in self.mus]).reshape(1, -1, 3)
        for mu in self.external:
            thrust[0, mu - 1] = 0.0  # its real thrusters act on it, not on its stand-in
            # A stand-in of which nothing is heard any more drifts, and the net draws it along: drawn on after its last
            # target it would tear at the net with whatever force that takes.
            self.world.external[0, mu - 1] = self.stamp_ns - self._heard_ns[mu] <= self.control.held_ns
        if self.mission.phase == Phase.HOLDING and self.stamp_ns >= self.mission.hold_ns:
            self.world.tow(0, self.mission.tow_n)
        self.world.advance(thrust)
        for m, force in enumerate(thrust[0]):
            impulse_s = self.system.units[m].specific_impulse_s
            self.fuel[m] += law.fuel_used(force, period, impulse_s, self.control.standard_gravity_m_s2)
        self.stamp_ns += self.control.period_ns
        for mu in self.external:
            self.world.target_pos[0, mu - 1] += self.world.target_vel[0, mu - 1] * period
        self._publish_tick()

    def _publish_tick(self) -> None:
        stamp_ns = self.stamp_ns
        if self.world.diverged(_FIRST)[0]:
            self._break_down()
            return
        self.barrier.open(stamp_ns, time.monotonic())
        # What somebody must answer goes first; whatever else there is to tell is told while they work.
        if self.external:
            self._publish_clock(stamp_ns)
        if self.lockstep:  # most of what is to be done is the controllers'
            self._publish_units(stamp_ns)
        if stamp_ns > self._first_ns:
            self.loads.look(_FIRST)
        if self.mission.closing and stamp_ns >= self.mission.closing_ns and not self.world.state.closing[0]:
            self.world.begin_closing(0)
        self._publish_body(DEBRIS)
        self._net_out.publish_template(self._net.fill(stamp_ns, self.world, self.loads))
        if not self.lockstep:  # where a driver is late, the planner decides on the last tick before it hears of this
            self._publish_units(stamp_ns)
        if not self.external:
            self._publish_clock(stamp_ns)
        self._pending = True
        if self.lockstep:
            self._publish_deferred()  # the processors are busy all the time anyway: tell while the others work

    def _publish_units(self, stamp_ns: int) -> None:
        true = np.stack([self.world.state.mu_pos[0], self.world.state.mu_vel[0]], axis=1)
        measured = true + self.noise.draw(1)[0]
        for mu, (position, velocity) in zip(self.mus, measured, strict=True):
            self._sent_at[mu - 1] = time.perf_counter()
            if mu not in self.external:
                self._odometry_out[mu].publish_template(self._odometry[mu].fill(stamp_ns, position, velocity))

    def _publish_deferred(self) -> None:
        """What nobody answers: in real time it waits until the thrust is in, so as not to hold up those who command."""
        if not self._pending:
            return
        self._pending = False
        stamp_ns = self.stamp_ns
        self._publish_body(CHASER)
        self._tf_out.publish_template(self._tf.fill(stamp_ns, self.world))
        tick = self._flown_ns // self.control.period_ns
        if tick % self.p.markers_every == 0:
            self._pictures.publish(stamp_ns, self.world)
        if tick % self.p.sim_status_every == 0:
            self._publish_status()

    def _publish_clock(self, stamp_ns: int) -> None:
        self._clock_out.publish_template(self._time.fill(stamp_ns))

    def _publish_body(self, body: int) -> None:
        message, publisher = self._bodies[body]
        publisher.publish_template(message.fill(self.stamp_ns, self.world))

    def _publish_status(self) -> None:
        books = [self.books[mu] for mu in self.mus]
        wall = time.perf_counter() - self._launched_at
        message = SimStatus(
            tick=self._flown_ns // self.control.period_ns,
            finished=self.finished,
            fault=self.fault,
            real_time_factor=self._flown_ns * NANOSECOND_S / wall if self.flying or self.finished else 0.0,
            late_commands=[book.late for book in books],
            rejected_commands=[self._door.counts[topics.mu_thrust(mu)] for mu in self.mus],
            clipped_commands=[book.clipped for book in books],
            zeroed_commands=[book.zeroed for book in books],
            lost_controllers=[mu for mu in self.mus if topics.mu_frame(mu) in self.barrier.lost],
            applied_fuel=self.fuel.tolist(),
        )
        message.latency_p50, message.latency_p99 = map(self.latencies.quantile, (0.5, 0.99))
        message.latency_max = self.latencies.longest_s
        set_stamp(message.header.stamp, self.stamp_ns)
        message.header.frame_id = topics.FRAME
        self._status_out.publish(message)
        self._publish_diagnostics(message)

    def _publish_diagnostics(self, status: SimStatus) -> None:
        troubled = [
            f"mu{mu}"
            for mu in self.mus
            if self.books[mu].zeroed or status.rejected_commands[mu - 1] or mu in status.lost_controllers
        ]
        if self._door.dropped:
            troubled.append("messages")
        text = "trouble with " + ", ".join(troubled) if troubled else "flying"
        level = diagnostics.WARN if troubled else diagnostics.OK
        values = {
            "pace": self.scenario.pace,
            "real-time factor": status.real_time_factor,
            "late commands": sum(status.late_commands),
            "rejected commands": sum(status.rejected_commands),
            "clipped commands": sum(status.clipped_commands),
            "dropped messages": self._door.summary() or "none",
            "latency p99 [s]": status.latency_p99,
            "points in contact": int(self.world.state.contacts[0]),
        }
        entry = diagnostics.entry("sim: flight", level, text, **values)
        self._diagnostics_out.publish(diagnostics.array(self.stamp_ns, [entry]))

    def _break_down(self) -> None:
        """Stop: nothing of what the world is now must leave this node but that it is no world any more."""
        self.fault = divergence(seconds_between(self.mission.launch_ns, self.stamp_ns))
        self.get_logger().fatal(self.fault)
        self.finished, self.flying = True, False
        self._timer.cancel()
        self._publish_status()

    def _finish(self) -> None:
        if self.finished:
            return
        self._publish_deferred()
        self.finished, self.flying = True, False
        self._timer.cancel()
        self._publish_status()
        self.get_logger().info(
            f"mission over ({self.mission.phase.name.lower()}) at t = {self._flown_ns * NANOSECOND_S:.2f} s"
        )


def main(args: list[str] | None = None) -> int:
    """Run the node; see tethernet_ros.executor for the exit status.

    The others find its endpoints while its kernels load, half of the way to launch; it answers them after that.
    """
    args = sys.argv if args is None else args
    loading = KernelLoading(args)

    def complete(node: SimNode) -> None:
        loading.wait()
        node.make_world()

    status = run(SimNode, args, complete)
    loading.leave(status)
    return status


if __name__ == "__main__":
    sys.exit(main())
