"""The planner's process: plans, leads the mission, keeps the beat."""

import itertools
import math
import signal
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from tests import tiny_models
from tests.ros.sound import mu_status, net_state
from tests.systems import zenit
from tethernet_core.aiming import FALLBACK, nominal_aiming_points
from tethernet_core.mission import Phase
from tethernet_core.parameters import load
from tethernet_core.settings import MissionParameters
from tethernet_core.system import load_system
from tethernet_msgs.msg import MissionState, MuStatus
from tethernet_msgs.srv import PlanAimingPoints
from tethernet_planner.closing import plan as plan_closing
from tethernet_planner.closing_situation import closing_situation
from tethernet_ros import topics
from tethernet_ros.conversions import nanoseconds, set_stamp
from tethernet_ros.qos import BULK, CONTROL, SERVICE, STATE

PERIOD = 50_000_000
DEBRIS, FAR = (0.0, 0.0, -50.0), (0.0, 0.0, -10.0)


class Bench:
    """Everything around the planner: controllers that echo, a net, a debris."""

    def __init__(self, probe, processes, *parameters):
        self.probe = probe
        # The tests leap from one moment of a mission to the next.
        self.process = processes.node("tethernet_planner.planner_node", "longest_gap_s:=100.0", *parameters)
        self.echoing = set(range(1, 9))
        self.states = probe.listen(topics.MISSION_STATE, MissionState, STATE, self._echo)
        self.beats = probe.listen(topics.PLANNER_HEARTBEAT, Header, CONTROL)
        self.diagnostics = probe.listen(topics.DIAGNOSTICS, DiagnosticArray, BULK)
        self.status_publishers = {
            mu: probe.node.create_publisher(MuStatus, topics.mu_status(mu), STATE) for mu in range(1, 9)
        }
        probe.matched(topics.MISSION_STATE, "planner")

    def _echo(self, state):
        if not state.confirmed:
            for mu in self.echoing:
                self.status_publishers[mu].publish(mu_status(mu, state.sequence))

    def debris(self, tick, position=DEBRIS):
        message = Odometry()
        message.header.frame_id = topics.FRAME
        set_stamp(message.header.stamp, tick * PERIOD)
        place = message.pose.pose.position
        place.x, place.y, place.z = position
        message.pose.pose.orientation.w = 1.0
        self.probe.publish(topics.DEBRIS_ODOMETRY, message, STATE, "planner")

    def mu(self, mu, tick, position):
        message = Odometry(child_frame_id=topics.mu_frame(mu))
        message.header.frame_id = topics.FRAME
        set_stamp(message.header.stamp, tick * PERIOD)
        place = message.pose.pose.position
        place.x, place.y, place.z = position
        message.pose.pose.orientation.w = 1.0
        self.probe.publish(topics.mu_odometry(mu), message, CONTROL, "planner")

    def net(self, tick, center=FAR):
        message = net_state(load_system("zenit_8mu"), tick * PERIOD, center)
        # Where it says the MUs are, which no planner could know, is not where their odometry has them.
        message.mu_positions, message.mu_velocities = [9.0] * 24, [1.0] * 24
        self.probe.publish(topics.NET_STATE, message, BULK, "planner")

    def ticked(self, tick, center=FAR, debris=DEBRIS):
        """One control tick: net and debris out, wait for the beat."""
        self.net(tick, center)
        self.debris(tick, debris)
        self.probe.wait_for(
            lambda: self.beats and nanoseconds(self.beats[-1].stamp) == tick * PERIOD, f"heartbeat of tick {tick}"
        )

    def start(self):
        return self.probe.call(topics.START, Trigger)

    def reached(self, phase, confirmed=True):
        self.probe.wait_for(
            lambda: any(s.phase == phase and s.confirmed == confirmed for s in self.states), f"{phase.name} {confirmed}"
        )
        return next(s for s in self.states if s.phase == phase and s.confirmed == confirmed)

    def deployed(self):
        self.debris(0)
        self.probe.wait_for(lambda: self.start().success, "start")
        self.reached(Phase.DEPLOYING)
        self.probe.matched(topics.PLANNER_HEARTBEAT, "planner")
        return self


@pytest.fixture
def bench(probe, processes):
    return lambda *parameters: Bench(probe, processes, *parameters)


def test_leads_a_mission_from_start_to_end(bench):
    b = bench()
    b.probe.wait_for(lambda: b.states and b.states[0].phase == Phase.WAITING, "latched WAITING")
    b.deployed()
    b.ticked(0)
    b.ticked(480, center=(0.0, 0.0, -48.0))
    closing = b.reached(Phase.CLOSING)
    assert nanoseconds(closing.header.stamp) == 480 * PERIOD
    assert nanoseconds(closing.closing_time) == 481 * PERIOD
    assert nanoseconds(closing.end_time) == 781 * PERIOD
    assert [(p.x, p.y, p.z) for p in closing.closing_points] == [(0.0, 0.0, -56.0)] * 8
    b.ticked(781)
    b.reached(Phase.COMPLETE)
    assert [(s.phase, s.sequence, s.confirmed) for s in b.states] == [(0, 0, True)] + [
        (phase, phase, confirmed) for phase, confirmed in itertools.product((1, 2, 3, 4), (False, True))
    ]
    assert {s.reason for s in b.states} == {""}
    assert "over" in b.probe.call(topics.ABORT, Trigger).message
    assert "COMPLETE" in b.start().message


def test_as_many_as_ask_at_the_same_moment_are_answered_alike(bench):
    b = bench()
    node, wait_for = b.probe.node, b.probe.wait_for
    clients = [node.create_client(PlanAimingPoints, topics.PLAN_AIMING_POINTS, qos_profile=SERVICE) for _ in range(24)]
    request = PlanAimingPoints.Request(debris_position=Point(x=1.0, y=2.0, z=-48.0))
    for client in clients:  # both ends have found each other
        wait_for(client.service_is_ready, "service")
        first = client.call_async(request)
        wait_for(first.done, "first answer")
    request.debris_position.z = -47.0
    b.process.send(signal.SIGSTOP)
    answers = [client.call_async(request) for client in clients]
    time.sleep(0.2)
    b.process.send(signal.SIGCONT)
    wait_for(lambda: all(answer.done() for answer in answers), "all answers")
    plans = [answer.result() for answer in answers]
    assert plans[0].success and plans[0].aiming_points != first.result().aiming_points
    assert all(plan == plans[0] for plan in plans)


def test_the_closing_is_planned_from_the_odometry_of_that_tick_which_is_waited_for(bench):
    b = bench().deployed()
    aims = nominal_aiming_points(load_system("zenit_8mu"), DEBRIS)
    for mu, point in enumerate(aims, start=1):
        b.mu(mu, 0, point)
    b.ticked(0)
    places = [(x, y, z + 0.25) for x, y, z in aims]
    for mu in range(1, 8):
        b.mu(mu, 1, places[mu - 1])
    b.net(1, (0.0, 0.0, -48.0))
    b.debris(1)
    b.probe.spin_for(0.3)
    assert nanoseconds(b.beats[-1].stamp) == 0, "MU 8 keeps step and is waited for"
    b.mu(8, 1, places[7])
    closing = b.reached(Phase.CLOSING)
    assert nanoseconds(closing.closing_time) == 2 * PERIOD
    q = (0.0, 0.0, 0.0, 1.0)
    seen = closing_situation(places, [(0.0,) * 3] * 8, DEBRIS, q, (0.0,) * 3, (0.0,) * 3, [False] * 8)
    plan = plan_closing(seen, load_system("zenit_8mu"), load(MissionParameters))
    assert tuple((p.x, p.y, p.z) for p in closing.closing_points) == plan.points


def test_a_tick_that_lacks_an_mus_odometry_is_decided_on_when_the_next_one_is_there(bench):
    b = bench().deployed()
    for mu, point in enumerate(nominal_aiming_points(load_system("zenit_8mu"), DEBRIS), start=1):
        b.mu(mu, 0, point)
    b.ticked(0)
    b.debris(1)
    b.net(1)
    b.net(2)
    b.probe.wait_for(lambda: nanoseconds(b.beats[-1].stamp) == PERIOD, "heartbeat of tick 1")
    b.ticked(6)  # more than five periods: nobody waits for MUs that are silent


def test_service_gives_nominal_points_and_explains_refusals(bench):
    b = bench("system:=zenit_4mu", "policy:=nominal")

    def ask(**request):
        return b.probe.call(topics.PLAN_AIMING_POINTS, PlanAimingPoints, PlanAimingPoints.Request(**request))

    good = ask(debris_position=Point(x=1.0, y=2.0, z=-50.0))
    assert (good.success, good.policy, len(good.aiming_points)) == (True, "nominal", 4)
    assert (good.aiming_points[3].x, good.aiming_points[3].y, good.aiming_points[3].z) == (13.0, 14.0, -50.0)
    assert len(ask(debris_position=Point(z=-50.0), mu_count=4).aiming_points) == 4
    for request, words in (
        ({"debris_position": Point(z=-70.0)}, "z = -70 m is out of bounds; allowed: -60 to -40 m"),
        ({"debris_position": Point(x=math.nan, z=-50.0)}, "debris_position.x is nan"),
        ({"debris_position": Point(z=-50.0), "mu_count": 8}, "points for 8 units; allowed: 4, of system zenit_4mu"),
        ({"debris_position": Point(z=-50.0), "policy": "best"}, "no policy named 'best'; allowed: nominal"),
    ):
        answer = ask(**request)
        assert not answer.success
        assert words in answer.message
        assert len(answer.aiming_points) == 0


def test_over_the_network_policies_have_names_and_no_paths(bench, tmp_path):
    own = tiny_models.policy(tmp_path / "own.safetensors", zenit(8))
    other = tiny_models.policy(tmp_path / "other.safetensors", zenit(8))
    b = bench(f"policy:={own}")

    def ask(name):
        request = PlanAimingPoints.Request(policy=name, debris_position=Point(z=-50.0))
        return b.probe.call(topics.PLAN_AIMING_POINTS, PlanAimingPoints, request)

    assert ask("").policy == ask(str(own)).policy == str(own)
    assert ask("nominal").success
    # Whether there is such a file makes no difference to what is answered.
    answers = [ask(str(name)) for name in (other, other.with_name("nothing.safetensors"), "/etc/hostname", "./x")]
    assert not any(answer.success for answer in answers)
    assert len({answer.message.split("; allowed: ")[1] for answer in answers}) == 1
    assert all(answer.message.startswith("no policy named") for answer in answers)
    for name in ("/" + "a" * 300, "a" * 100_000, "\x1b[31mred\x07\n"):
        answer = ask(name)
        assert not answer.success
        assert answer.message.isprintable()
        assert len(answer.message) < 300
    assert ask("nominal").success


def test_where_a_trained_policy_was_never_trained_the_nominal_points_stand_in_and_controllers_are_told(bench, tmp_path):
    policy = tiny_models.policy(tmp_path / "policy.safetensors", zenit(4))
    b = bench("system:=zenit_4mu", f"policy:={policy}", "debris_bound_xy_m:=12.0")

    def ask(**request):
        return b.probe.call(topics.PLAN_AIMING_POINTS, PlanAimingPoints, PlanAimingPoints.Request(**request))

    inside = ask(debris_position=Point(x=1.0, y=2.0, z=-50.0))
    assert (inside.success, inside.policy, inside.message) == (True, str(policy), "4 aiming points")
    assert inside.aiming_points[3].x == pytest.approx(13.5)
    outside = ask(debris_position=Point(x=11.0, y=2.0, z=-50.0))
    assert (outside.success, outside.policy) == (True, FALLBACK)
    assert "was not trained for it (debris at (11, 2, -50) m" in outside.message
    assert (outside.aiming_points[3].x, outside.aiming_points[3].y) == (23.0, 14.0)


def test_does_not_start_without_debris_or_out_of_bounds_and_stays_waiting(bench):
    b = bench()
    refused = b.start()
    assert not refused.success
    assert "nobody has told where the debris is: publish /debris/odom" in refused.message
    b.debris(0, (20.0, 0.0, -50.0))
    b.probe.wait_for(lambda: "x = 20 m is out of bounds; allowed: -9 to 9 m" in b.start().message, "refusal")
    assert {s.phase for s in b.states} == {Phase.WAITING}
    b.debris(1)
    b.probe.wait_for(lambda: b.start().success, "start after all")


def test_controllers_that_do_not_echo_are_named_and_waited_for_only_once(bench):
    b = bench("plan_timeout_s:=0.2", "confirm_timeout_s:=0.3")
    b.echoing -= {2, 6}
    b.deployed()
    assert b.reached(Phase.ARMED).reason == "not confirmed by MU 2, MU 6"
    b.ticked(480, center=DEBRIS)
    assert b.reached(Phase.CLOSING).reason == "not confirmed by MU 2, MU 6"
    b.probe.wait_for(
        lambda: b.diagnostics and any(e.message == "does not answer" for e in b.diagnostics[-1].status), "diagnostics"
    )
    lost = {e.name for e in b.diagnostics[-1].status if e.level == DiagnosticStatus.ERROR}
    assert lost == {"mu2_controller", "mu6_controller"}


def test_nan_in_net_or_debris_is_dropped_and_counted_and_the_next_good_one_goes_on(bench):
    b = bench().deployed()
    nan = (math.nan,) * 3
    b.ticked(0)
    b.net(480, nan)
    b.debris(480, nan)
    b.ticked(481, center=(0.0, 0.0, -10.0))
    assert b.states[-1].phase == Phase.DEPLOYING

    def counted():
        values = [v for d in b.diagnostics for e in d.status if e.name == "planner" for v in e.values]
        return ("dropped_on", "/debris/odom: 1, /net/state: 1") in {(v.key, v.value) for v in values}

    b.probe.wait_for(counted, "two dropped messages on /diagnostics")
    b.ticked(482, center=(0.0, 0.0, -48.0))
    assert b.reached(Phase.CLOSING).closing_points[0].z == -56.0


def test_gives_up(bench):
    b = bench().deployed()
    b.ticked(799)
    b.ticked(800)
    missed = b.reached(Phase.MISSED)
    assert nanoseconds(missed.end_time) == 800 * PERIOD
    assert "did not come within 2.5 m of the debris in 40 s" in missed.reason


def test_abort_is_told_to_all(bench):
    b = bench().deployed()
    assert b.probe.call(topics.ABORT, Trigger).success
    assert "asked for" in b.reached(Phase.ABORTED).reason


def test_a_flight_that_nobody_measures_is_aborted(bench):
    b = bench("silence_timeout_s:=1.0").deployed()
    assert "nothing was measured for 1 s" in b.reached(Phase.ABORTED).reason


def test_without_simulator_it_needs_all_drivers_and_their_clocks_together(bench):
    b = bench("simulated:=false", "debris_position:=[0, 0, -50]")

    def odometry(mu, seconds):
        message = Odometry(child_frame_id=topics.mu_frame(mu))
        message.header.frame_id = topics.FRAME
        set_stamp(message.header.stamp, round(seconds * 1e9))
        message.pose.pose.orientation.w = 1.0
        b.probe.publish(topics.mu_odometry(mu), message, CONTROL, "planner")

    assert "no odometry from MU 1, MU 2" in b.start().message
    for mu in range(1, 9):
        odometry(mu, 100.0 if mu != 4 else 98.0)
    b.probe.wait_for(lambda: "MU 4 is 2.00 s older than the newest" in b.start().message, "refusal for the clock")
    odometry(4, 100.01)
    b.probe.wait_for(lambda: b.start().success, "start")
    assert nanoseconds(b.reached(Phase.DEPLOYING).launch_time) == 100_010_000_000
