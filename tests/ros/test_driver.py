"""The driver contract: the example driver keeps it, the check finds who does not, missions are flown with it."""

import math
import time

import pytest
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from tethernet_core.aiming import nominal_aiming_points
from tethernet_core.mission import Phase
from tethernet_core.system import load_system
from tethernet_msgs.msg import CaptureAssessment, MissionState, MuStatus, NetState
from tethernet_ros import topics
from tethernet_ros.connections import read_connections, service_name
from tethernet_ros.conversions import nanoseconds, set_stamp
from tethernet_ros.qos import CONTROL, RECORD, STATE

from .graph import PATIENCE_S

DRIVER = "examples/mu_driver.py"
CHECK = ("-m", "tethernet_bringup.cli", "check-driver")
PERIOD = 50_000_000

BAD_DRIVER = """
import rclpy
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data
rclpy.init()
node = rclpy.create_node("bad_driver")
publishers = [node.create_publisher(Odometry, "/mu3/odom", quality) for quality in (10, qos_profile_sensor_data)]
message = Odometry()
message.header.frame_id = "map"
def tell():
    message.header.stamp = node.get_clock().now().to_msg()
    publishers[0].publish(message)
node.create_timer(0.1, tell)
try:
    rclpy.spin(node)
except BaseException:
    pass
"""


class SimulatedClock:
    """The simulator's and the controller's side of the example driver of MU 3, which has no noise."""

    def __init__(self, probe, processes):
        self.probe = probe
        self.odometry = probe.listen(topics.mu_odometry(3), Odometry, CONTROL)
        self.process = processes.start(
            "driver", DRIVER, "--mu", "3", "--clock", "sim", "--sigma", "0", "--start", "0", "0", "0"
        )
        self.clock_out = probe.node.create_publisher(Clock, topics.CLOCK, CONTROL)
        self.thrust_out = probe.node.create_publisher(WrenchStamped, topics.mu_thrust(3), CONTROL)
        probe.wait_for(
            lambda: self.clock_out.get_subscription_count() and self.thrust_out.get_subscription_count(), "driver"
        )
        # The driver itself tells nobody what it has found: ask it for tick 0 until it answers.
        probe.wait_for(lambda: self.clock(0) or self.odometry, "odometry at tick 0")

    def clock(self, tick):
        message = Clock()
        set_stamp(message.clock, tick * PERIOD)
        self.clock_out.publish(message)

    def thrust(self, tick, x, y=0.0, z=0.0):
        message = WrenchStamped()
        message.header.frame_id = topics.FRAME
        set_stamp(message.header.stamp, tick * PERIOD)
        force = message.wrench.force
        force.x, force.y, force.z = x, y, z
        self.thrust_out.publish(message)

    def at(self, tick):
        """The odometry of a tick."""
        self.probe.wait_for(
            lambda: self.odometry and nanoseconds(self.odometry[-1].header.stamp) == tick * PERIOD,
            f"odometry at {tick}",
        )
        message = self.odometry[-1]
        return message.pose.pose.position.x, message.twist.twist.linear.x


def test_on_the_simulated_clock_each_step_waits_for_its_own_thrust(probe, processes):
    s = SimulatedClock(probe, processes)
    for tick in range(1, 20):
        # The clock overtakes the command, as it may between processes: the step still takes its own command.
        s.clock(tick)
        s.thrust(tick - 1, 2.5)
        position, velocity = s.at(tick)
        assert velocity == pytest.approx(tick * 0.05, rel=1e-12)  # 2.5 N on 2.5 kg
        assert position == pytest.approx(0.5 * (tick * 0.05) ** 2, rel=1e-12)


def test_thrust_acts_for_five_periods_at_most_and_nonsense_not_at_all(probe, processes):
    s = SimulatedClock(probe, processes)
    s.thrust(0, 2.5)
    for tick in range(1, 12):
        s.thrust(tick - 1, math.nan)
        s.clock(tick)  # nobody answers: after a bounded wait the driver goes on
        _, velocity = s.at(tick)
        assert velocity == pytest.approx(min(tick, 5) * 0.05)
    assert "thrust is not finite: dropped" in s.process.output
    s.thrust(11, 100.0)
    s.clock(12)
    assert s.at(12)[1] == pytest.approx(0.25 + 0.05 * 5.1 / 2.5)  # no thruster gives more


def test_odometry_says_everything_the_contract_asks_for(probe, processes):
    s = SimulatedClock(probe, processes)
    message = s.odometry[-1]
    assert (message.header.frame_id, message.child_frame_id) == ("launch", "mu3")
    assert message.pose.pose.orientation.w == 1.0


@pytest.mark.parametrize("clock", ["own", "sim"])
def test_the_example_driver_passes_the_check(processes, clock):
    processes.start("driver", DRIVER, "--mu", "3", "--clock", clock)
    check = processes.start("check", *CHECK, "--mu", "3", "--clock", clock, "--duration", "2", "--push", "0.5")
    assert check.wait() == 0, check.output
    assert "21 of 21 checks passed for the driver of MU 3" in check.output


def test_the_check_finds_a_bad_driver(processes, tmp_path):
    program = tmp_path / "bad_driver.py"
    program.write_text(BAD_DRIVER)
    processes.start("bad_driver", str(program))
    arguments = ["--mu", "3", "--duration", "2", "--no-thrust"]
    check = processes.start("check", *CHECK, *arguments, expected=1)
    assert check.wait() == 1
    failed = [line for line in check.output.splitlines() if line.startswith("FAIL")]
    for words in (
        "2: best effort, volatile; reliable, volatile",
        "/mu3/thrust is listened to",
        "rate on the wall clock",
        "frame_id is 'launch'",
        "child_frame_id",
        "variances",
    ):
        assert any(words in line for line in failed), f"{words} not in {failed}"


def test_the_check_tells_of_a_driver_that_is_not_there(processes):
    check = processes.start("check", *CHECK, "--mu", "3", "--wait", "0.5", expected=1)
    assert check.wait() == 1
    assert "FAIL  odometry arrives on /mu3/odom" in check.output


@pytest.mark.parametrize("arguments", [["--mu", "9"], ["--mu", "3", "--thrust", "6"], ["--mu", "3", "--push", "0"], []])
def test_bad_usage_of_the_check_ends_with_status_2(processes, arguments):
    assert processes.start("check", *CHECK, *arguments, expected=2).wait() == 2


def test_an_external_mu_flies_a_capture_and_the_net_feels_it(probe, processes):
    """MU 3 comes from the example driver, all else from the simulator, in lock-step."""
    odometry = probe.listen(topics.mu_odometry(3), Odometry, RECORD)
    nets = probe.listen(topics.NET_STATE, NetState, RECORD)
    found = probe.listen(topics.CAPTURE_ASSESSMENT, CaptureAssessment, STATE)
    status = probe.listen(topics.mu_status(3), MuStatus, STATE)
    for mu in range(1, 9):
        processes.node("tethernet_control.controller_node", f"mu:={mu}", name=f"controller_{mu}")
    processes.node("tethernet_planner.planner_node", name="planner")
    processes.node("tethernet_planner.assessor_node", name="assessor")
    processes.start("driver", DRIVER, "--mu", "3", "--clock", "sim")
    processes.node("tethernet_sim.ros.sim_node", "pace:=lockstep", "external_mus:='3'", name="sim")
    wait_until_connected(probe, [*(f"mu{mu}_controller" for mu in range(1, 9)), "planner", "sim"])
    probe.wait_for(lambda: probe.node.count_publishers(topics.mu_odometry(3)) == 1, "the driver, and nobody else")
    probe.wait_for(lambda: odometry, "odometry before launch")  # a publisher that is seen need not see us yet
    start(probe)
    probe.wait_for(lambda: found and found[-1].stage == CaptureAssessment.FINAL, "verdict", 120.0)
    assert found[-1].captured, found[-1].verdict
    assert status[-1].aiming_source == "rl"
    assert status[-1].deadline_misses == status[-1].rejected_odometry == 0
    end_ns = nanoseconds(found[-1].header.stamp)
    probe.wait_for(lambda: all(nanoseconds(told[-1].header.stamp) == end_ns for told in (odometry, nets)), "last tick")
    driven = {nanoseconds(m.header.stamp): m.pose.pose.position for m in odometry}
    first = min(driven)
    assert first < min(nanoseconds(net.header.stamp) for net in nets), "there is odometry before launch"
    assert sorted(driven) == [first + tick * PERIOD for tick in range(len(driven))]
    apart = []
    for net in nets:
        place = driven[nanoseconds(net.header.stamp)]
        apart.append(math.dist(net.mu_positions[6:9], (place.x, place.y, place.z)))
    print(f"apart: mean {sum(apart) / len(apart):.3f} m, at most {max(apart):.3f} m")
    assert max(apart) < 1.0  # the stand-in in the net follows the real MU, which is pulled away by nothing
    assert sum(apart) / len(apart) < 0.3


def start(probe):
    """Ask until the planner has what it needs."""
    deadline = time.monotonic() + PATIENCE_S
    while not (answer := probe.call(topics.START, Trigger)).success:
        assert time.monotonic() < deadline, answer.message
        probe.spin_for(0.05)


def wait_until_connected(probe, nodes):
    """Wait until every publisher of these nodes has found a subscriber; what nobody listens to here does not count."""
    pictures = {topics.TF, topics.NET_MARKERS, topics.NET_POINTS}
    unheard = pictures | {topics.CHASER_ODOMETRY, topics.SIM_STATUS, topics.DIAGNOSTICS}
    deadline = time.monotonic() + PATIENCE_S
    for node in nodes:
        while time.monotonic() < deadline:
            counts = read_connections(probe.call(service_name(node), Trigger)).subscribers
            ours = {topic: count for topic, count in counts.items() if topic not in unheard}
            if all(count for topic, count in ours.items() if topic not in ("/rosout", "/parameter_events")):
                break
            probe.spin_for(0.05)
    assert time.monotonic() < deadline, "not every node found all its partners"


def test_eight_drivers_fly_a_mission_without_a_simulator(probe, processes):
    """The whole plan with real MUs, shortened: the debris is near and the MUs half-way there."""
    debris = (0.0, 0.0, -10.0)
    place = "debris_position:=[0.0, 0.0, -10.0]"
    control = ["deployment_time_s:=4.0"]
    rules = ["debris_near_m:=5.0", "closing_duration_s:=7.0", "capture_duration_s:=13.0", "give_up_s:=20.0"]
    processes.node(
        "tethernet_planner.planner_node", "simulated:=false", "policy:=nominal", place, *control, *rules, name="planner"
    )
    processes.node("tethernet_planner.assessor_node", "simulated:=false", place, *control, name="assessor")
    states = probe.listen(topics.MISSION_STATE, MissionState, STATE)
    found = probe.listen(topics.CAPTURE_ASSESSMENT, CaptureAssessment, STATE)
    statuses = [probe.listen(topics.mu_status(mu), MuStatus, STATE) for mu in range(1, 9)]
    for mu, aim in enumerate(nominal_aiming_points(load_system("zenit_8mu"), debris), 1):
        processes.node("tethernet_control.controller_node", f"mu:={mu}", *control, name=f"controller_{mu}")
        place_m = [str(value) for value in (0.5 * aim[0], 0.5 * aim[1], -4.0)]
        processes.start(f"driver_{mu}", DRIVER, "--mu", str(mu), "--start", *place_m)
    probe.wait_for(lambda: all(statuses), "all controllers")
    start(probe)
    probe.wait_for(lambda: found and found[-1].stage == CaptureAssessment.FINAL, "verdict", 60.0)
    final = found[-1]
    assert final.source == "mu_odometry"
    assert final.locked_pairs >= final.required_locked_pairs == 6  # in real time, on a machine that may be busy
    assert not final.hull_valid
    assert final.verdict.startswith(f"docked: {final.locked_pairs} of 8 pairs")
    assert "CQI not available" in final.verdict
    probe.wait_for(lambda: states[-1].phase == Phase.COMPLETE, "COMPLETE")
    assert {s.aiming_source for (*_, s) in statuses} == {"nominal"}
    assert all(s.fuel > s.fuel_at_trigger > 0.0 for (*_, s) in statuses)
    assert [s.rejected_odometry for (*_, s) in statuses] == [0] * 8
