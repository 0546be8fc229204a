"""The controller's process: odometry in, thrust out, and what it does when something is wrong."""

import dataclasses
import math

import pytest
from geometry_msgs.msg import Point, WrenchStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from tethernet_core.mission import Mission, Mode, Phase, abort, arm, launch
from tethernet_msgs.msg import MissionState, MuStatus
from tethernet_msgs.srv import PlanAimingPoints
from tethernet_ros import topics
from tethernet_ros.conversions import mission_message, nanoseconds, set_stamp
from tethernet_ros.qos import CONTROL, STATE

PERIOD = 50_000_000
DEBRIS = (0.0, 0.0, -50.0)
NOMINAL_3 = (-12.0, 12.0, -50.0)
ZERO = (0.0, 0.0, 0.0)


class Bench:
    """Everything around the controller of MU 3: planner, driver, and a look at what it says."""

    def __init__(self, probe, processes, *parameters, wall_factor=100.0):
        self.probe = probe
        self.thrust = probe.listen(topics.mu_thrust(3), WrenchStamped, CONTROL)
        self.status = probe.listen(topics.mu_status(3), MuStatus, STATE)
        self.process = processes.node(
            "tethernet_control.controller_node", "mu:=3", f"watchdog_wall_factor:={wall_factor}", *parameters
        )
        probe.matched(topics.mu_thrust(3), "mu3_controller")

    def serve_plan(self, change=lambda response: None):
        """Stand in for the planner's service."""
        self.asked = []

        def serve(request, response):
            self.asked.append(request)
            response.success, response.policy = True, "mine"
            response.aiming_points = [Point(x=float(mu), y=2.0, z=-50.0) for mu in range(1, 9)]
            change(response)
            return response

        self.probe.node.create_service(PlanAimingPoints, topics.PLAN_AIMING_POINTS, serve)

    def tell(self, mission):
        self.probe.publish(topics.MISSION_STATE, mission_message(mission, 0, False), STATE, "mu3_controller")

    def send(
        self, tick, position=(0.0, 0.0, -1.5), velocity=(0.0, 0.0, 0.0), frame=topics.FRAME, attitude=(0, 0, 0, 1)
    ):
        message = Odometry()
        message.header.frame_id, message.child_frame_id = frame, "mu3"
        set_stamp(message.header.stamp, tick * PERIOD)
        place, speed, q = message.pose.pose.position, message.twist.twist.linear, message.pose.pose.orientation
        place.x, place.y, place.z = position
        speed.x, speed.y, speed.z = velocity
        q.x, q.y, q.z, q.w = map(float, attitude)
        self.probe.publish(topics.mu_odometry(3), message, CONTROL, "mu3_controller")

    def answer(self, tick, **odometry):
        """Send one sample and wait for the thrust that answers it."""
        self.send(tick, **odometry)
        self.probe.wait_for(
            lambda: self.thrust and nanoseconds(self.thrust[-1].header.stamp) == tick * PERIOD,
            f"thrust for tick {tick}",
        )
        return self.thrust[-1]

    def wait_status(self, condition, what):
        self.probe.wait_for(lambda: self.status and condition(self.status[-1]), what)
        return self.status[-1]

    def launched(self):
        """Bring the controller into flight with the nominal points."""
        self.serve_plan()
        armed = arm(Mission(8), DEBRIS, "mine")
        self.tell(armed)
        self.wait_status(lambda s: s.mission_sequence == 1, "echo of ARMED")
        self.mission = launch(armed, 0)
        self.tell(self.mission)
        self.wait_status(lambda s: s.mission_sequence == 2, "echo of DEPLOYING")
        return self


@pytest.fixture
def bench(probe, processes):
    return lambda *parameters, **options: Bench(probe, processes, *parameters, **options)


def force(message):
    vector = message.wrench.force
    return (vector.x, vector.y, vector.z)


def test_answers_every_sample_with_its_stamp_and_echoes_only_with_aiming_points_in_hand(bench):
    b = bench()
    first = b.answer(0)
    assert force(first) == ZERO
    assert first.header.frame_id == topics.FRAME
    b.wait_status(lambda s: s.mode == Mode.IDLE, "status before the mission")
    b.launched()
    assert (b.asked[0].debris_position.z, b.asked[0].mu_count, b.asked[0].policy) == (-50.0, 8, "mine")
    status = b.status[-1]
    assert status.aiming_source == "mine"
    assert (status.aiming_point.x, status.aiming_point.y) == (3.0, 2.0)
    thrusts = [force(b.answer(tick)) for tick in range(1, 20)]
    assert thrusts[-1] != ZERO
    status = b.wait_status(lambda s: s.mode == Mode.DEPLOYING and s.commands >= 20, "status in flight")
    assert status.fuel > 0.0
    assert status.tracking_error > 0.0
    assert (status.rejected_odometry, status.deadline_misses) == (0, 0)


def test_without_the_planner_it_takes_the_nominal_points_and_says_so(bench):
    b = bench("plan_timeout_s:=0.3")
    b.tell(arm(Mission(8), DEBRIS, "nominal"))
    status = b.wait_status(lambda s: s.mission_sequence == 1, "echo although there is no planner")
    assert status.aiming_source == "nominal (fallback)"
    assert (status.aiming_point.x, status.aiming_point.y, status.aiming_point.z) == NOMINAL_3
    assert "no answer from /planner/plan_aiming_points within 0.3 s" in b.process.output


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda r: (setattr(r, "success", False), setattr(r, "message", "out of bounds")), "out of bounds"),
        (lambda r: setattr(r, "aiming_points", r.aiming_points[:4]), "the number of aiming_points is 4; allowed: 8"),
        (lambda r: setattr(r.aiming_points[0], "x", math.nan), "aiming_points[0].x is nan; allowed: finite"),
    ],
)
def test_an_unusable_plan_is_not_flown(bench, change, words):
    b = bench()
    b.serve_plan(change)
    b.tell(arm(Mission(8), DEBRIS, "mine"))
    status = b.wait_status(lambda s: s.mission_sequence == 1, "echo although the plan is unusable")
    assert status.aiming_source == "nominal (fallback)"
    b.probe.wait_for(lambda: words in b.process.output, "the reason in the log")


def test_a_controller_that_comes_late_still_gets_its_plan(bench):
    b = bench()
    b.serve_plan()
    b.tell(launch(arm(Mission(8), DEBRIS, "mine"), 0))
    assert b.wait_status(lambda s: s.mission_sequence == 2, "echo of DEPLOYING").aiming_source == "mine"
    b.answer(100)
    b.wait_status(lambda s: s.mode == Mode.DEPLOYING, "flight")


def test_nan_and_stale_odometry_is_dropped_and_counted(bench):
    b = bench().launched()
    before = len(b.thrust)
    b.answer(0)
    b.send(1, position=(math.nan, 0.0, 0.0))
    b.send(2, velocity=(0.0, math.inf, 0.0))
    b.send(0)
    b.send(3, frame="map")
    b.send(4, attitude=(0, 0, 0, 0))
    status = b.wait_status(lambda s: s.rejected_odometry == 5, "five rejected samples")
    thrust = b.answer(5)
    assert all(map(math.isfinite, force(thrust)))
    assert [nanoseconds(t.header.stamp) for t in b.thrust[before:]] == [0, 5 * PERIOD]
    assert status.commands < b.wait_status(lambda s: s.commands > status.commands or s.mode, "status").commands + 1


def test_velocity_is_turned_into_frame_launch(bench):
    straight = bench("estimator:=raw", "feed_forward:=false", "dead_band_n:=0.0", "kd:=6.0").launched()
    half = math.sqrt(0.5)
    straight.answer(0)
    # Turned by 90 degrees about z: what the MU calls +x is +y in frame launch.
    turned = force(straight.answer(1, velocity=(0.1, 0.0, 0.0), attitude=(0.0, 0.0, half, half)))
    still = force(straight.answer(2, velocity=(0.0, 0.0, 0.0)))
    assert turned[1] == pytest.approx(still[1] - 6.0 * 0.1, abs=0.1)
    assert turned[0] == pytest.approx(still[0], abs=0.1)


def answers(bench, tick):
    return [force(t) for t in bench.thrust if nanoseconds(t.header.stamp) == tick * PERIOD]


def test_lost_odometry_zeroes_thrust_once_and_comes_back(bench):
    b = bench(wall_factor=2.0).launched()
    for tick in range(10):
        b.answer(tick)
    assert force(b.thrust[-1]) != ZERO
    b.wait_status(lambda s: s.mode == Mode.NO_ODOMETRY, "watchdog")
    b.probe.wait_for(lambda: answers(b, 9)[-1] == ZERO, "zero thrust")
    assert "no odometry for 0.5 s" in b.process.output
    assert force(b.answer(30)) != ZERO
    assert len(answers(b, 9)) == 2
    status = b.wait_status(lambda s: s.mode == Mode.DEPLOYING, "recovery")
    assert status.deadline_misses == 20


def test_an_abort_stops_the_thrust_at_once(bench):
    b = bench().launched()
    for tick in range(10):
        b.answer(tick)
    assert answers(b, 9) != [ZERO]
    b.tell(abort(b.mission, "asked for"))
    b.wait_status(lambda s: s.mode == Mode.OFF and s.mission_sequence == 3, "thrusters off")
    b.probe.wait_for(lambda: answers(b, 9)[1:] == [ZERO], "zero thrust")
    assert force(b.answer(10)) == ZERO


def test_without_the_planners_heartbeat_the_thrust_ends_until_it_is_back(bench):
    b = bench("planner_timeout_s:=0.5").launched()
    thrusts = [force(b.answer(tick)) for tick in range(20)]
    assert ZERO not in thrusts[1:10]
    assert thrusts[-1] == ZERO
    b.wait_status(lambda s: s.mode == Mode.NO_PLANNER, "watchdog on the planner")
    assert "no news of the planner for 0.5 s" in b.process.output
    beat = Header(frame_id=topics.FRAME)
    set_stamp(beat.stamp, 19 * PERIOD)
    b.probe.publish(topics.PLANNER_HEARTBEAT, beat, CONTROL, "mu3_controller")
    for tick in range(20, 29):  # within its patience
        b.answer(tick)
        if b.status[-1].mode == Mode.DEPLOYING:
            break
    b.wait_status(lambda s: s.mode == Mode.DEPLOYING, "the planner is back")


def test_the_abort_of_a_restarted_planner_stops_the_thrust(bench):
    b = bench().launched()
    for tick in range(10):
        b.answer(tick)
    b.tell(abort(Mission(8, mission_id=77), "stop"))
    b.wait_status(lambda s: s.mode == Mode.OFF and s.mission_sequence == 1, "thrusters off")
    assert force(b.answer(10)) == ZERO


def test_a_stamp_from_the_future_and_a_far_sequence_change_nothing(bench):
    b = bench().launched()
    for tick in range(5):
        b.answer(tick)
    b.send(2_000_000_000)
    forged = dataclasses.replace(b.mission, sequence=2**32 - 1)
    b.tell(forged)
    status = b.wait_status(lambda s: s.clock_jumps == 1 and s.refused_states == 1, "both counted")
    assert (status.rejected_odometry, status.mission_sequence) == (1, 2)
    assert status.propellant == pytest.approx(0.5 - status.fuel)
    assert force(b.answer(5)) != ZERO
    b.tell(abort(b.mission, "asked for"))
    b.wait_status(lambda s: s.mode == Mode.OFF and s.mission_sequence == 3, "the planner's own states go on")


def test_nonsense_about_the_mission_is_not_followed(bench):
    b = bench().launched()
    b.answer(0)
    state = mission_message(b.mission, 0, False)
    state.sequence, state.phase = 9, 77
    b.probe.publish(topics.MISSION_STATE, state, STATE, "mu3_controller")
    state = mission_message(b.mission, 0, False)
    state.sequence, state.phase = 10, MissionState.CLOSING
    state.closing_points = [Point(x=math.nan)] * 8
    b.probe.publish(topics.MISSION_STATE, state, STATE, "mu3_controller")
    complaint = f"phase is 77; allowed: 0 to {max(Phase)}; dropped (1 so far)"
    b.probe.wait_for(lambda: complaint in b.process.output, "complaint")
    b.wait_status(lambda s: s.rejected_messages == 2, "two dropped messages")
    assert all(map(math.isfinite, force(b.answer(1))))
    assert b.wait_status(lambda s: s.commands >= 2 or s.mode == Mode.DEPLOYING, "status").mission_sequence == 2


def test_an_mu_that_is_not_part_of_the_mission_stays_idle(probe, processes):
    status = probe.listen(topics.mu_status(7), MuStatus, STATE)
    process = processes.node("tethernet_control.controller_node", "mu:=7")
    probe.publish(
        topics.MISSION_STATE, mission_message(arm(Mission(4), DEBRIS, "nominal"), 0, False), STATE, "mu7_controller"
    )
    probe.wait_for(lambda: "a mission of 4 units; allowed: 8, of system zenit_8mu" in process.output, "complaint")
    assert all(message.mission_sequence == 0 for message in status)


def test_in_lock_step_a_halt_of_the_machine_is_no_loss_of_odometry(bench):
    b = bench(wall_factor=20.0).launched()
    for tick in range(3):
        b.answer(tick)
    count = len(b.thrust)
    b.probe.spin_for(0.6)  # more than two of the usual watchdog's patience
    assert len(b.thrust) == count
    b.answer(3)
    status = b.wait_status(lambda s: s.mode == Mode.DEPLOYING and s.commands >= 1, "still flying")
    assert status.deadline_misses == 0
