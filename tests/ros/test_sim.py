"""The simulator's process, with the test as planner and controllers."""

from __future__ import annotations

import math
import signal

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from visualization_msgs.msg import Marker, MarkerArray

from tethernet_core.mission import Mission, arm, launch
from tethernet_msgs.msg import NetState, SimStatus
from tethernet_ros import qos, topics
from tethernet_ros.conversions import mission_message, nanoseconds, set_stamp

pytestmark = pytest.mark.ros

TICK = 50_000_000
FIRST = 20 * TICK
"""[ns] of the first tick: a stamp of zero would mean that none was set."""
MUS = (1, 2, 3, 4)


class Crew:
    """Planner and four controllers, played by the test."""

    def __init__(self, probe, silent=()):
        self.probe, self.silent = probe, set(silent)
        self.thrust = dict.fromkeys(MUS, (0.0, 0.0, -1.0))
        self.net = probe.listen(topics.NET_STATE, NetState, qos.BULK, self._heartbeat)
        self.odometry = {
            mu: probe.listen(topics.mu_odometry(mu), Odometry, qos.CONTROL, lambda m, mu=mu: self._answer(mu, m))
            for mu in MUS
        }
        self.status = probe.listen(topics.SIM_STATUS, SimStatus, qos.STATE)
        self.beating = True

    def launch(self) -> None:
        self.probe.matched(topics.NET_STATE)
        mission = launch(arm(Mission(4), (0.0, 0.0, -50.0), "nominal"), FIRST)
        self.probe.publish(topics.MISSION_STATE, mission_message(mission, FIRST, confirmed=True), qos.STATE)

    def _answer(self, mu: int, message: Odometry) -> None:
        if mu not in self.silent:
            self.send(mu, nanoseconds(message.header.stamp), self.thrust[mu])

    def send(self, mu: int, stamp_ns: int, force) -> None:
        answer = WrenchStamped()
        answer.header.frame_id = topics.FRAME
        set_stamp(answer.header.stamp, stamp_ns)
        answer.wrench.force.x, answer.wrench.force.y, answer.wrench.force.z = force
        self.probe.publish(topics.mu_thrust(mu), answer, qos.CONTROL)

    def _heartbeat(self, message: NetState) -> None:
        if self.beating:
            self.probe.publish(topics.PLANNER_HEARTBEAT, message.header, qos.CONTROL)

    def fly(self, ticks: int) -> None:
        told = [self.net, *self.odometry.values()]
        self.probe.wait_for(lambda: min(map(len, told)) >= ticks, f"{ticks} control ticks")


def start(processes, *parameters: str):
    return processes.node("tethernet_sim.ros.sim_node", "system:=zenit_4mu", "pace:=lockstep", *parameters)


def test_lockstep_flies_on_answers_and_tells_everything(probe, processes):
    start(processes)
    crew = Crew(probe)
    debris = probe.listen(topics.DEBRIS_ODOMETRY, Odometry, qos.STATE)
    markers = probe.listen(topics.NET_MARKERS, MarkerArray, qos.BULK)
    probe.wait_for(lambda: debris, "the debris' odometry before launch")
    assert not crew.net, "nothing flies before launch"
    crew.launch()
    crew.fly(41)
    stamps = [nanoseconds(message.header.stamp) for message in crew.net[:41]]
    assert stamps == [FIRST + tick * TICK for tick in range(41)]
    last = crew.net[40]
    assert len(last.knot_positions) == 3 * 529
    assert len(last.mu_positions) == 12
    # 1 N on 2.5 kg for 2 s; the threads to the net are still slack.
    assert np.allclose(np.reshape(last.mu_positions, (4, 3))[:, 2], -1.5 - 0.5 * (1.0 / 2.5) * 2.0**2, atol=1e-3)
    odometry = crew.odometry[1][10]
    assert odometry.header.frame_id == "launch"
    assert odometry.child_frame_id == "mu1"
    variances = np.diag(np.reshape(odometry.pose.covariance, (6, 6)))
    assert np.allclose(variances[:3], (0.1 / 3.0) ** 2)
    measured = np.array([crew.odometry[1][k].pose.pose.position.x for k in range(41)])
    true = np.array([crew.net[k].mu_positions[0] for k in range(41)])
    assert 0.01 < (measured - true).std() < 0.06, "noise of 3 sigma = 0.1 m"
    probe.wait_for(lambda: len(markers) >= 4, "markers")
    assert {marker.ns for marker in markers[0].markers} >= {"net", "units", "debris", "chaser", "tether"}
    for marker in markers[0].markers:  # RViz warns of a line's scale.y and scale.z
        scale = marker.scale.x, marker.scale.y, marker.scale.z
        is_line = marker.type in {Marker.LINE_LIST, Marker.LINE_STRIP}
        assert [value > 0.0 for value in scale] == [True, not is_line, not is_line], marker.ns


def test_before_launch_the_clock_goes_on_for_drivers_and_stays_below_the_first_tick(probe, processes):
    start(processes, "external_mus:='2'", "answer_timeout_s:=0.3")
    clock = probe.listen(topics.CLOCK, Clock, qos.CONTROL)
    net = probe.listen(topics.NET_STATE, NetState, qos.BULK)
    probe.wait_for(lambda: len(clock) >= 3, "the clock before launch")
    armed = arm(Mission(4), (0.0, 0.0, -50.0), "nominal")
    probe.publish(topics.MISSION_STATE, mission_message(armed, FIRST, confirmed=True), qos.STATE)
    probe.spin_for(0.5)
    before = [nanoseconds(message.clock) for message in clock]
    assert before == [before[0] + k * TICK for k in range(len(before))]
    assert before[0] >= FIRST
    launched = mission_message(launch(armed, before[-1] + TICK), before[-1] + TICK, confirmed=True)
    probe.publish(topics.MISSION_STATE, launched, qos.STATE)
    probe.wait_for(lambda: net, "the first tick")
    assert nanoseconds(net[0].header.stamp) == before[-1] + TICK


def test_bad_commands_are_counted_and_never_fly(probe, processes):
    start(processes)
    crew = Crew(probe)
    crew.thrust[1] = (math.nan, 0.0, 0.0)
    crew.thrust[2] = (0.0, 0.0, -50.0)
    crew.launch()
    crew.fly(25)
    probe.wait_for(lambda: crew.status and crew.status[-1].tick >= 20, "status")
    status = crew.status[-1]
    assert status.rejected_commands[0] >= 20
    assert status.zeroed_commands[0] >= 20, "there never was a good command"
    assert status.clipped_commands[1] >= 20
    assert list(status.clipped_commands)[2:] == [0, 0]
    state = np.array(crew.net[24].mu_positions).reshape(4, 3)
    assert np.isfinite(state).all()
    assert abs(state[0, 2] + 1.5) < 0.05, "MU 1 has not flown"
    assert state[1, 2] < state[2, 2] - 0.1, "MU 2 has, at the limit"
    # 20 ticks at the limit of 5.1 N, by the paper's fuel equation
    assert status.applied_fuel[1] == pytest.approx(5.1 * status.tick * 0.05 / (9.81 * 60.0), rel=1e-9)
    assert status.applied_fuel[0] == 0.0


def test_a_silent_controller_costs_one_bounded_wait(probe, processes):
    start(processes, "answer_timeout_s:=0.3")
    crew = Crew(probe, silent=[3])
    crew.launch()
    crew.fly(30)
    probe.wait_for(lambda: crew.status and crew.status[-1].tick >= 20, "status")
    assert list(crew.status[-1].lost_controllers) == [3]
    assert crew.status[-1].late_commands[2] >= 20
    assert list(crew.status[-1].late_commands[:2]) == [0, 0]
    crew.silent.clear()
    reached = len(crew.net)
    crew.fly(reached + 45)
    probe.wait_for(lambda: not crew.status[-1].lost_controllers, "MU 3 to be waited for again")


def test_a_simulator_that_stood_still_itself_blames_nobody(probe, processes):
    sim = start(processes, "answer_timeout_s:=0.3")
    crew = Crew(probe)
    crew.launch()
    for stop in range(5):  # one or the other finds it with a tick open
        crew.fly(20 * (stop + 1))
        sim.send(signal.SIGSTOP)
        probe.spin_for(0.6)
        sim.send(signal.SIGCONT)
    crew.fly(len(crew.net) + 45)
    probe.wait_for(lambda: crew.status[-1].tick >= 100, "status")
    assert list(crew.status[-1].late_commands) == [0] * 4
    assert "no answer" not in sim.output


def test_without_the_planners_heartbeat_lockstep_waits_and_then_goes_on(probe, processes):
    sim = start(processes, "answer_timeout_s:=0.3")
    crew = Crew(probe)
    crew.beating = False
    crew.launch()
    crew.fly(5)
    assert "planner" in sim.output


def test_realtime_pace_goes_on_without_answers(probe, processes):
    processes.node("tethernet_sim.ros.sim_node", "system:=zenit_4mu", "pace:=realtime")
    crew = Crew(probe, silent=MUS)
    crew.launch()
    crew.fly(25)
    probe.wait_for(lambda: crew.status and crew.status[-1].tick >= 20, "status")
    assert min(crew.status[-1].late_commands) >= 20
    assert crew.status[-1].real_time_factor <= 1.05, "never faster than the clock"


@pytest.mark.parametrize(
    ("parameter", "words"),
    [
        ("system:=zenit_5mu", ["zenit_5mu", "zenit_4mu, zenit_8mu"]),
        ("friction:=0.3", ["friction", "friction_coefficient"]),
        ("time_step_s:=0.01", ["time_step_s", "0.01"]),
        ("pace:=fast", ["pace", "realtime", "lockstep"]),
        ("external_mus:='9'", ["external_mus", "1 to 8"]),
        ("debris_attitude:=[0.0, 0.0, 0.0, 0.5]", ["debris_attitude", "unit quaternion"]),
    ],
)
def test_bad_parameters_are_explained(processes, parameter, words):
    node = processes.node("tethernet_sim.ros.sim_node", parameter, expected=2)
    assert node.wait() == 2
    for word in words:
        assert word in node.output
