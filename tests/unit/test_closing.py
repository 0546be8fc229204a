"""The closing plan of 8 MUs: reach of the net, meeting places, who is left out."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.physics import make_world
from tethernet_core.parameters import load
from tethernet_core.settings import MissionParameters
from tethernet_core.system import load_system
from tethernet_planner import closing
from tethernet_planner.closing_situation import closing_situation, foreseen, off_course
from tethernet_planner.debris_section import DebrisPose
from tethernet_planner.docking_groups import docking_groups, most_parts, regroup
from tethernet_planner.meeting_places import MeetingPlaces
from tethernet_planner.mouth import project_to_reachable

RULES = load(MissionParameters)
SYSTEM = load_system("zenit_8mu")
RADIUS_M, HALF_LENGTH_M = SYSTEM.debris.shape.numbers
MOUTH = np.array([(x, y, 0.5) for x, y in SYSTEM.aiming.offsets])
DIAGONAL, ROW, APPROACH = (1.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
CENTER = np.array((3.0, -4.0, -50.0))
GRID_M = 0.5
"""Meeting places are looked for at such distances."""


def seen(axis, mouth=MOUTH, rate=(0.0, 0.0, 0.0), lost=(False,) * 8, velocity=(0.0, 0.0, -2.0)):
    attitude = Rotation.align_vectors([np.array(axis) / np.linalg.norm(axis)], [[0.0, 0.0, 1.0]])[0]
    velocities = np.tile(velocity, (8, 1))
    in_body = attitude.inv().apply(rate)
    return closing_situation(mouth + CENTER, velocities, CENTER, attitude.as_quat(), (0.0,) * 3, in_body, lost)


def pose(axis):
    return DebrisPose(SYSTEM.debris, seen(axis).debris_attitude)


def relative(plan):
    return np.array(plan.points) - CENTER


def test_a_sight_takes_odometry_as_messages_carry_it():
    attitude = Rotation.from_rotvec((0.3, -0.5, 0.2))
    linear, angular = (1.0, 2.0, 3.0), (0.1, 0.2, 0.3)
    got = closing_situation(MOUTH, MOUTH, CENTER, attitude.as_quat(), linear, angular)
    assert np.allclose(got.debris_velocity, attitude.apply(linear))
    assert np.allclose(got.debris_rate, attitude.apply(angular))
    assert np.allclose(got.debris_attitude, attitude.as_matrix())


def test_the_axis_tumbles_as_the_simulated_debris_does():
    world = make_world(8, attitude=Rotation.from_rotvec((0.4, 0.9, 0.0)).as_quat(), rate=(0.06, -0.04, 0.09))
    before = closing_situation(np.zeros((8, 3)), np.zeros((8, 3)), *world.body_motion(0, 0))
    for _ in range(200):
        world.advance(np.zeros((1, 8, 3)))
    after = closing_situation(np.zeros((8, 3)), np.zeros((8, 3)), *world.body_motion(0, 0))
    then = foreseen(before, 10.0, SYSTEM)
    assert np.allclose(then.debris_attitude, after.debris_attitude, atol=1e-6)
    assert np.allclose(then.debris_rate, after.debris_rate, atol=1e-6)
    assert np.allclose(then.debris_position, after.debris_position)
    assert np.linalg.norm(after.debris_attitude[:, 2] - before.debris_attitude[:, 2]) > 0.3


@pytest.mark.parametrize(
    ("axis", "sideways", "target", "length"),
    [
        # Round the side of a cylinder that lies across: a quarter of the circle and on to the side, or half of it.
        ((0.0, 1.0, 0.0), (1.0, 0.0), (5.0, 0.0, 1.95), 5.0),
        ((0.0, 1.0, 0.0), (1.0, 0.0), (1.95, 0.0, -4.0), np.pi / 2 * 1.95 + 4.0),
        ((0.0, 1.0, 0.0), (1.0, 0.0), (0.0, 0.0, -1.95), np.pi * 1.95),
        # Along the axis: over the edge, down the flat end, back underneath.
        ((1.0, 0.0, 0.0), (1.0, 0.0), (5.55, 0.0, -3.0), 5.55 + 1.95 + 3.0),
        # Beside the plane of the row.
        ((0.0, 1.0, 0.0), (1.0, 0.0), (5.0, 3.0, 1.95), np.hypot(5.0, 3.0)),
    ],
)
def test_length_of_a_string_round_the_debris(axis, sideways, target, length):
    outline = pose(axis).outline(np.array(sideways))
    assert outline.path_length(np.array([target]))[0] == pytest.approx(length, rel=0.02)


def test_distance_from_the_debris():
    points = np.array([(0.0, 3.0, 0.0), (6.0, 0.0, 0.0), (5.55 + 0.3, 1.95 + 0.4, 0.0), (0.0, 0.0, 0.0)])
    assert np.allclose(pose((1.0, 0.0, 0.0)).distance(points), (1.05, 0.45, 0.5, -1.95))


def test_all_meet_behind_a_debris_along_the_diagonal():
    plan = closing.plan(seen(DIAGONAL), SYSTEM, RULES)
    assert plan.feasible
    assert plan.pairs == 8
    assert plan.duration_s == RULES.closing_duration_s
    assert len(set(plan.points)) == 1
    assert relative(plan)[0, 2] < -RADIUS_M - RULES.closing_clearance_m


@pytest.mark.parametrize("axis", [ROW, APPROACH, (1.0, 0.0, 1.0), (0.3, 1.0, 0.2)])
def test_two_bunches_meet_where_one_place_is_out_of_reach(axis):
    plan = closing.plan(seen(axis), SYSTEM, RULES)
    assert plan.feasible
    assert plan.pairs == 6
    assert plan.duration_s == RULES.group_duration_s
    groups = docking_groups(plan.points, SYSTEM)
    assert sorted(map(len, groups)) == [4, 4]
    one, other = (relative(plan)[group[0] - 1] for group in groups)
    assert one[:2] @ other[:2] < 0.0, "on either side of the debris"
    for group in groups:
        place = relative(plan)[group[0] - 1]
        assert pose(axis).distance(place) >= RULES.closing_clearance_m
        middle = MOUTH[np.array(group) - 1, :2].mean(axis=0)
        assert middle @ place[:2] > 0.0, "each docking group on its own side"


@pytest.mark.parametrize(
    ("axis", "rate"),
    [(ROW, 0.0), (APPROACH, 0.0), ((1.0, 0.0, 1.0), 0.0), ((0.3, 1.0, 0.2), 0.0), (ROW, 0.03), (APPROACH, 0.03)],
)
def test_two_bunches_meet_as_deep_as_the_net_lets_them(axis, rate):
    """At shallower places the mouth stays a slit through which an end of the debris comes out."""
    view = seen(axis, rate=(0.0, rate, 0.0))
    slack = RULES.closing_slack_m + (RULES.tumbling_slack_m if rate else 0.0)
    plan = closing.plan(view, SYSTEM, RULES)
    places = MeetingPlaces(view, SYSTEM, RULES, plan.duration_s)
    for group in docking_groups(plan.points, SYSTEM):
        place = relative(plan)[group[0] - 1]
        deeper = place - (0.0, 0.0, GRID_M)
        assert places.net_left(group, place[None]).min() >= slack
        assert places.net_left(group, deeper[None]).min() < slack


def test_all_meet_no_farther_behind_the_debris_than_they_must():
    """The units are 20 of the 21 kg of the closed net: where they meet is where its centre of mass is."""
    far, near = (
        closing.plan(seen(DIAGONAL), SYSTEM, dataclasses.replace(RULES, place_gain=gain))
        for gain in (0.0, RULES.place_gain)
    )
    assert far.pairs == near.pairs == 8
    distance = [float(pose(DIAGONAL).distance(relative(plan)[0])) for plan in (far, near)]
    assert distance[0] > RULES.ring_clearance_m + GRID_M
    assert RULES.ring_clearance_m - GRID_M < distance[1] <= RULES.ring_clearance_m


def test_depth_is_worth_some_thrust():
    slow = seen((1.0, 0.0, 1.0), velocity=(0.0, 0.0, -0.3))
    shallow, deep = (closing.plan(slow, SYSTEM, dataclasses.replace(RULES, place_gain=gain)) for gain in (0.0, 0.1))
    assert shallow.pairs == deep.pairs == 6
    assert relative(deep)[:, 2].mean() < relative(shallow)[:, 2].mean() - GRID_M


def test_every_attitude_has_a_plan_that_can_be_flown():
    for axis in Rotation.random(40, random_state=3).apply((0.0, 0.0, 1.0)):
        plan = closing.plan(seen(axis), SYSTEM, RULES)
        assert plan.feasible, axis
        assert plan.pairs >= 6, axis


def test_a_tumbling_debris_is_met_where_it_will_be():
    turning = closing.plan(seen(ROW, rate=(0.0, 0.0, np.radians(45.0 / RULES.closing_duration_s))), SYSTEM, RULES)
    still = closing.plan(seen(ROW), SYSTEM, RULES)
    assert not np.allclose(turning.points, still.points)


def test_two_bunches_meet_sooner_round_a_debris_that_turns():
    turning = closing.plan(seen(ROW, rate=(0.0, 0.0, np.radians(5.0))), SYSTEM, RULES)
    assert turning.pairs == 6
    assert turning.duration_s == pytest.approx(38.0 / 5.0)
    rolling = closing.plan(seen(ROW, rate=(np.radians(5.0), 0.0, 0.0)), SYSTEM, RULES)
    assert rolling.duration_s == RULES.group_duration_s, "a cylinder looks the same whichever way it has rolled"
    wild = closing.plan(seen(ROW, rate=(0.0, 0.0, np.radians(60.0))), SYSTEM, RULES)
    assert wild.duration_s == pytest.approx(0.55 * RULES.group_duration_s)


@pytest.mark.parametrize("lost", [(), (2,), (1, 5), (1, 6), range(1, 8), range(1, 9)])
def test_a_plan_made_in_parts_is_the_same_plan(lost):
    view = seen((0.3, 1.0, 0.2), rate=(0.05, 0.02, 0.0), lost=tuple(mu in lost for mu in range(1, 9)))
    parts = closing.planning(view, SYSTEM, RULES)
    count = 0
    while True:
        try:
            next(parts)
        except StopIteration as end:
            assert end.value == closing.plan(view, SYSTEM, RULES)
            break
        count += 1
    assert count <= most_parts(SYSTEM)


def test_foreseen_mus_fly_on():
    now = seen(ROW)
    then = foreseen(now, 0.5, SYSTEM)
    assert np.allclose(then.mu_positions, np.add(now.mu_positions, (0.0, 0.0, -1.0)))
    assert np.array_equal(then.mu_velocities, now.mu_velocities)
    assert np.array_equal(then.debris_attitude, now.debris_attitude)


def test_the_lost_is_left_out_and_the_others_meet():
    lost = tuple(mu == 6 for mu in range(1, 9))
    plan = closing.plan(seen(DIAGONAL, lost=lost), SYSTEM, RULES)
    assert plan.pairs == 6
    assert plan.points[5] == pytest.approx(MOUTH[5] + CENTER), "it stays where it is"
    assert docking_groups(plan.points, SYSTEM) == [[1, 5, 2, 4, 8, 3, 7]]


def test_who_is_far_beside_its_aiming_point_is_lost():
    aims = MOUTH * (1.0, 1.0, 0.0)
    places = np.add(MOUTH, (0.5, -0.3, 1.0))
    assert off_course(places, aims, SYSTEM, RULES) == (False,) * 8, "all late alike is not lost"
    places[2] += (RULES.off_course_m, 0.0, 0.0)
    assert off_course(places, aims, SYSTEM, RULES) == (False, False, True, *(False,) * 5)


def test_nobody_is_lost_whom_a_net_too_short_holds_back():
    aims = MOUTH * (1.0, 1.0, 0.0)
    aims[4, :2] += (0.0, -5.0)  # side MU 5 out,
    aims[0, :2] += (-5.0, 5.0)  # its neighbour in corner 1 away from it
    places = project_to_reachable(aims, SYSTEM)
    assert np.linalg.norm(places - aims, axis=1).max() > 2.0
    places[:, 2] = MOUTH[:, 2]
    assert off_course(places, aims, SYSTEM, RULES) == (False,) * 8
    places[3, :2] -= RULES.off_course_m
    assert off_course(places, aims, SYSTEM, RULES) == (False, False, False, True, *(False,) * 4)


def test_a_rally_goes_to_the_last_and_gives_up_who_is_too_far():
    point = (0.0, 0.0, -55.0)
    places = np.tile(point, (8, 1)) + np.arange(8)[:, None] * (0.05, 0.0, 0.0)
    places[4] += (1.5, 0.0, 0.0)
    nothing = [False] * 8
    rallied = regroup([point] * 8, places, nothing, SYSTEM, RULES)
    assert set(rallied) == {tuple(places[4])}
    places[1] += (0.0, RULES.regroup_reach_m + 1.0, 0.0)
    rallied = regroup([point] * 8, places, nothing, SYSTEM, RULES)
    assert rallied[1] == tuple(places[1])
    assert {rallied[m] for m in range(8) if m != 1} == {tuple(places[4])}
    assert regroup([point] * 8, places, [True] * 8, SYSTEM, RULES) is None
