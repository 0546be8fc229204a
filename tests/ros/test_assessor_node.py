"""The assessor's process: verdicts from hand-made nets."""

import array
import itertools
import math

import numpy as np
import pytest
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry

from tests import tiny_models
from tethernet_core.capture_quality import hull_quality, mouth_area
from tethernet_core.mission import Mission, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_msgs.msg import CaptureAssessment, MissionState, NetState
from tethernet_planner.mission_rules import advance
from tethernet_ros import topics
from tethernet_ros.conversions import mission_message, nanoseconds, set_stamp
from tethernet_ros.qos import BULK, CONTROL, STATE, STATE_BACKLOG

PERIOD = 50_000_000
DEBRIS = (0.1, -0.2, -50.0)
CONTROL_P, RULES = load(ControlParameters), load(MissionParameters)
SYSTEM = {mus: load_system(f"zenit_{mus}mu") for mus in (4, 8)}


class Bench:
    """Everything around the assessor."""

    def __init__(self, probe, processes, *parameters, mus=8):
        self.probe, self.mus = probe, mus
        # The tests leap from one moment of a mission to the next.
        leap = "longest_gap_s:=100.0"
        self.process = processes.node("tethernet_planner.assessor_node", f"system:=zenit_{mus}mu", leap, *parameters)
        self.found = probe.listen(topics.CAPTURE_ASSESSMENT, CaptureAssessment, STATE_BACKLOG)
        probe.matched(topics.CAPTURE_ASSESSMENT, "assessor")

    def tell(self, mission):
        self.probe.publish(topics.MISSION_STATE, mission_message(mission, 0, False), STATE, "assessor")

    def launched(self):
        self.mission = launch(arm(Mission(self.mus), DEBRIS, "nominal"), 0)
        self.tell(self.mission)
        return self

    def closed(self, tick=480):
        self.mission = advance(self.mission, SYSTEM[self.mus], tick * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL_P)
        self.tell(self.mission)

    def debris(self, tick, position=DEBRIS, velocity=(0.0, 0.0, 0.0)):
        message = Odometry()
        message.header.frame_id = topics.FRAME
        set_stamp(message.header.stamp, tick * PERIOD)
        place = message.pose.pose.position
        place.x, place.y, place.z = position
        message.pose.pose.orientation.w = 1.0
        speed = message.twist.twist.linear
        speed.x, speed.y, speed.z = velocity
        self.probe.publish(topics.DEBRIS_ODOMETRY, message, STATE, "assessor")

    def net(self, tick, knots, mus, locked=8, pairs=8, center=DEBRIS, columns=None):
        grid = SYSTEM[self.mus].net.grid
        message = NetState(rows=grid.rows, columns=grid.columns if columns is None else columns)
        message.header.frame_id = topics.FRAME
        message.center_of_mass = Point(x=center[0], y=center[1], z=center[2])
        message.center_of_mass_all_valid = True
        message.center_of_mass_all = Point(x=center[0], y=center[1], z=center[2] + 1.0)
        message.knot_positions = array.array("f", knots.ravel())
        message.knot_velocities = array.array("f", bytes(4 * knots.size))
        message.mu_positions = array.array("f", mus.ravel())
        message.mu_velocities = array.array("f", bytes(4 * mus.size))
        message.locked = [True] * locked + [False] * (pairs - locked)
        set_stamp(message.header.stamp, tick * PERIOD)
        self.probe.publish(topics.NET_STATE, message, BULK, "assessor")

    def stage(self, stage):
        self.probe.wait_for(lambda: any(a.stage == stage for a in self.found), f"stage {stage}")
        return next(a for a in self.found if a.stage == stage)


@pytest.fixture
def bench(probe, processes):
    return lambda *parameters, **options: Bench(probe, processes, *parameters, **options)


def shape(seed, spread=2.0, mus=8):
    generator = np.random.default_rng(seed)
    points = (np.array(DEBRIS) + generator.normal(0.0, spread, (529, 3))).astype(np.float32)
    return points, points[:mus] * np.float32(1.01)


def test_trigger_and_verdict_are_the_library_functions_on_what_was_published(bench):
    b = bench("progress_every:=10000", "predictor:=none").launched()
    b.debris(480)
    b.net(480, *shape(0))
    b.closed()
    at_trigger, at_end = shape(1, spread=8.0), shape(2)
    b.net(481, *at_trigger)  # before the debris' odometry of its time
    b.debris(481, (0.5, 0.0, -49.0))
    trigger = b.stage(CaptureAssessment.TRIGGER)
    expected = hull_quality(*at_trigger, DEBRIS, (0.5, 0.0, -49.0), SYSTEM[8])
    assert (trigger.cqi, trigger.hull_volume, trigger.hull_area) == (expected.cqi, expected.volume, expected.area)
    assert trigger.mouth_area == mouth_area(at_trigger[1], SYSTEM[8])
    assert nanoseconds(trigger.header.stamp) == 481 * PERIOD
    assert not trigger.prediction_valid
    b.debris(781)
    b.net(781, *at_end, locked=7)
    final = b.stage(CaptureAssessment.FINAL)
    expected = hull_quality(*at_end, DEBRIS, DEBRIS, SYSTEM[8], (DEBRIS[0], DEBRIS[1], DEBRIS[2] + 1.0))
    assert final.cqi_all == expected.cqi_all
    assert (final.cqi, final.locked_pairs, final.captured) == (expected.cqi, 7, True)
    assert final.verdict.startswith("captured: CQI")
    assert (final.max_locked_pairs, final.required_locked_pairs, final.source) == (8, 6, "net_state")


def test_a_surrogate_is_asked_at_the_trigger_and_the_end_tells_its_error(bench, tmp_path):
    # Predicts 3 locked pairs and one for each m/s of the first knot along z, relative to the debris.
    file = tiny_models.surrogate(tmp_path / "surrogate.safetensors", SYSTEM[8], cqi=1.5, pairs=3.0, seen=5)
    b = bench("progress_every:=10000", f"predictor:={file}").launched()
    b.closed()
    generator = np.random.default_rng(0)
    knots = (np.array(DEBRIS) + generator.normal(0.0, 2.0, (529, 3))).astype(np.float32)
    b.debris(481, velocity=(0.0, 0.0, -2.0))
    b.net(481, knots, knots[:8])
    trigger = b.stage(CaptureAssessment.TRIGGER)
    assert (trigger.prediction_valid, trigger.predictor) == (True, str(file))
    assert trigger.predicted_cqi == pytest.approx(1.5)
    assert trigger.predicted_locked_pairs == pytest.approx(5.0)
    assert trigger.predicted_capture_probability == pytest.approx(0.5)
    assert (trigger.cqi_error_valid, trigger.cqi_error) == (False, 0.0)
    b.debris(781)
    b.net(781, knots, knots[:8], locked=7)
    final = b.stage(CaptureAssessment.FINAL)
    assert final.predicted_cqi == trigger.predicted_cqi
    assert final.cqi_error_valid
    assert final.locked_pairs_error_valid
    assert final.cqi_error == final.cqi - trigger.predicted_cqi
    assert final.locked_pairs_error == pytest.approx(2.0)


@pytest.mark.parametrize(("mus", "locked", "captured"), [(8, 5, False), (4, 8, True), (4, 7, False)])
def test_locked_pairs_decide(bench, mus, locked, captured):
    b = bench("progress_every:=10000", mus=mus).launched()
    b.closed()
    for tick in (481, 781):
        b.debris(tick)
        b.net(tick, *shape(3, mus=mus), locked=locked, pairs=12 if mus == 4 else 8)
    final = b.stage(CaptureAssessment.FINAL)
    assert final.captured is captured
    assert f"{locked} of {12 if mus == 4 else 8} pairs locked" in final.verdict


def test_a_flat_net_and_a_loose_one_are_judged_too(bench):
    b = bench("progress_every:=1").launched()
    flat, mus = shape(4)
    flat, mus = flat * np.float32([1, 1, 0]), mus * np.float32([1, 1, 0])
    b.debris(10)
    b.net(10, flat, mus, locked=0)
    progress = b.stage(CaptureAssessment.PROGRESS)
    assert progress.hull_volume == 0.0
    assert math.isfinite(progress.cqi)
    b.closed(10)
    for tick in (11, 311):
        b.debris(tick)
        b.net(tick, *shape(5, spread=30.0))
    assert not b.stage(CaptureAssessment.FINAL).captured


def test_nan_is_dropped_and_the_verdict_still_comes(bench):
    b = bench("progress_every:=10000").launched()
    b.closed()
    for tick in (481, 780):
        b.debris(tick)
        b.net(tick, *shape(6))
    knots, mus = shape(7)
    knots[17, 1] = math.nan
    b.debris(781)
    b.net(781, knots, mus)
    b.net(782, *shape(8), columns=17)
    b.debris(782)
    b.probe.wait_for(lambda: "knot_positions reaches nan; allowed: finite" in b.process.output, "complaint about NaN")
    b.tell(advance(b.mission, SYSTEM[8], 781 * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL_P))
    final = b.stage(CaptureAssessment.FINAL)
    assert nanoseconds(final.header.stamp) == 780 * PERIOD
    assert final.captured


def test_missed(bench):
    b = bench("progress_every:=10000").launched()
    b.debris(800)
    b.net(800, *shape(9), locked=0)
    b.tell(advance(b.mission, SYSTEM[8], 800 * PERIOD, (0.0, 0.0, -10.0), DEBRIS, RULES, CONTROL_P))
    final = b.stage(CaptureAssessment.FINAL)
    assert final.verdict.startswith("missed: the net did not come")
    assert not final.captured


def test_progress_every_tenth_tick(bench):
    b = bench().launched()
    for tick in range(31):
        b.debris(tick)
        b.net(tick, *shape(tick))
    b.probe.wait_for(lambda: len(b.found) >= 4, "four reports")
    assert [nanoseconds(a.header.stamp) // PERIOD for a in b.found] == [0, 10, 20, 30]


def test_without_simulator_docked_pairs_come_from_the_mus_odometry(bench):
    b = bench("simulated:=false", "debris_position:=[0.1, -0.2, -50.0]", "progress_every:=10000").launched()
    b.closed()

    def odometry(tick, places):
        for mu, place in enumerate(places, 1):
            message = Odometry(child_frame_id=topics.mu_frame(mu))
            message.header.frame_id = topics.FRAME
            set_stamp(message.header.stamp, tick * PERIOD + mu * 1000)
            position = message.pose.pose.position
            position.x, position.y, position.z = place
            message.pose.pose.orientation.w = 1.0
            b.probe.publish(topics.mu_odometry(mu), message, CONTROL, "assessor")

    ring = (1, 5, 2, 6, 4, 8, 3, 7)
    line = [(0.45 * ring.index(mu), 0.0, -53.5) for mu in range(1, 9)]  # neighbours near, the ring not closed
    apart = [(10.0 * mu, 0.0, -53.5) for mu in range(1, 9)]
    for tick, places in ((481, apart), (482, line), (483, apart), (781, apart), (782, apart)):
        odometry(tick, places)
    final = b.stage(CaptureAssessment.FINAL)
    assert final.source == "mu_odometry"
    assert final.locked_pairs == 7  # docked once is docked for good
    assert (final.hull_valid, final.cqi, final.distance_valid) == (False, 0.0, True)
    assert "CQI not available" in final.verdict


def test_states_of_another_design_are_refused(bench):
    b = bench()
    state = mission_message(launch(arm(Mission(4), DEBRIS, "nominal"), 0), 0, False)
    assert isinstance(state, MissionState)
    b.probe.publish(topics.MISSION_STATE, state, STATE, "assessor")
    b.probe.wait_for(lambda: "a mission of 4 units; allowed: 8, of system zenit_8mu" in b.process.output, "complaint")


def test_every_tick_is_assessed_although_they_come_in_a_rush(bench):
    b = bench("progress_every:=1").launched()
    b.probe.spin_for(0.2)
    for tick, part in itertools.product(range(60), ("debris", "net")):
        getattr(b, part)(tick, *(shape(tick) if part == "net" else ()))
    b.probe.wait_for(lambda: len(b.found) >= 60, "sixty reports")
    assert [nanoseconds(a.header.stamp) // PERIOD for a in b.found] == list(range(60))
