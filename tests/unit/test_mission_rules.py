"""The mission's phases."""

import math

import numpy as np
import pytest

from tethernet_core.mission import Mission, Phase, abort, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters, paper
from tethernet_core.system import load_system
from tethernet_planner import closing
from tethernet_planner.closing_situation import closing_situation
from tethernet_planner.docking_groups import docked_mus
from tethernet_planner.mission_rules import advance, check_debris_position, triggered

CONTROL, RULES = paper(ControlParameters), paper(MissionParameters)
PERIOD = CONTROL.period_ns
DEBRIS, FAR, NEAR = (1.0, -2.0, -50.0), (1.0, -2.0, -40.0), (1.0, -2.0, -47.6)


EIGHT, FOUR = load_system("zenit_8mu"), load_system("zenit_4mu")


def step(mission, tick, net, system=EIGHT):
    return advance(mission, system, tick * PERIOD, net, DEBRIS, RULES, CONTROL)


def launched(mus=8):
    return launch(arm(Mission(mus), DEBRIS, "nominal"), 0)


def test_every_change_has_the_next_number():
    mission = Mission(8)
    armed = arm(mission, DEBRIS, "nominal")
    flying = launch(armed, 100)
    assert [m.sequence for m in (mission, armed, flying, abort(flying, "x"))] == [0, 1, 2, 3]
    assert (armed.phase, flying.phase, flying.launch_ns) == (Phase.ARMED, Phase.DEPLOYING, 100)
    assert armed.debris_position == DEBRIS


def test_trigger_distance_is_inclusive():
    assert triggered((0.0, 0.0, 2.5), (0.0, 0.0, 0.0), RULES)
    assert not triggered((0.0, 0.0, 2.5000001), (0.0, 0.0, 0.0), RULES)
    assert not triggered((math.nan,) * 3, (0.0, 0.0, 0.0), RULES)


def test_nothing_changes_while_the_net_is_far():
    mission = launched()
    assert step(mission, 100, FAR) is mission


def test_a_trigger_takes_effect_at_the_next_tick():
    mission = step(launched(), 480, NEAR)
    assert mission.phase == Phase.CLOSING
    assert mission.closing_ns == 481 * PERIOD
    assert mission.end_ns == mission.closing_ns + 15_000_000_000
    assert mission.closing_points == ((1.0, -2.0, -53.5),) * 8
    assert mission.closing_duration_s == 8.0
    assert step(mission, 780, NEAR) is mission
    assert step(mission, 781, NEAR).phase == Phase.COMPLETE


def test_winches_need_no_closing_points():
    assert step(launched(4), 480, NEAR, FOUR).closing_points == ()


def test_gives_up_in_the_end():
    mission = launched()
    assert step(mission, 799, FAR) is mission
    missed = step(mission, 800, FAR)
    assert (missed.phase, missed.end_ns) == (Phase.MISSED, 800 * PERIOD)
    assert "2.5 m" in missed.reason
    assert "40 s" in missed.reason


def test_time_goes_on_although_nothing_is_known_of_the_net():
    unknown = (math.nan,) * 3
    assert step(launched(), 100, unknown).phase == Phase.DEPLOYING
    assert step(launched(), 800, unknown).phase == Phase.MISSED


def test_what_is_over_stays_over():
    missed = step(launched(), 800, FAR)
    assert abort(missed, "late") is missed
    assert step(missed, 900, NEAR) is missed
    assert abort(launched(), "why").reason == "why"


@pytest.mark.parametrize("position", [(9.0, -9.0, -40.0), (0.0, 0.0, -60.0), (8.9, 6.2, -44.0)])
def test_positions_inside_the_bounds(position):
    assert check_debris_position(position, RULES) == position


@pytest.mark.parametrize(
    ("position", "named"),
    [((9.1, 0.0, -50.0), "x = 9.1"), ((0.0, -10.0, -50.0), "y = -10"), ((0.0, 0.0, -39.0), "z = -39"),
     ((0.0, 0.0, 50.0), "z = 50"), ((math.nan, 0.0, -50.0), "x = nan"), ((0.0, 0.0, -math.inf), "z = -inf")],
)  # fmt: skip
def test_positions_out_of_bounds_are_named_with_what_is_allowed(position, named):
    with pytest.raises(ValueError, match="allowed: ") as error:
        check_debris_position(position, RULES)
    assert named in str(error.value)


def test_a_bunch_is_done_when_all_its_neighbours_have_docked():
    # Pairs round the mouth: (1 5) (5 2) (2 6) (6 4) (4 8) (8 3) (3 7) (7 1)
    here, there = (0.0, 0.0, -53.0), (1.0, 0.0, -53.0)
    together = (here,) * 8
    assert docked_mus(EIGHT, [True] * 7 + [False], together) == (False,) * 8
    assert docked_mus(EIGHT, [True] * 8, together) == (True,) * 8
    halves = (here, here, there, there, here, here, there, there)  # 1 5 2 6 and 4 8 3 7
    assert docked_mus(EIGHT, [1, 1, 1, 0, 1, 1, 0, 0], halves) == (True, True, False, False, True, True, False, False)
    assert docked_mus(EIGHT, [1, 1, 1, 0, 1, 1, 1, 0], halves) == (True,) * 8
    left_out = (here, (9.0, 9.0, -50.0), *(here,) * 6)
    without_2 = docked_mus(EIGHT, [1, 0, 0, 1, 1, 1, 1, 1], left_out)
    assert without_2 == (True, False, *(True,) * 6), "nobody waits for MU 2"
    assert docked_mus(EIGHT, [], together) == (False,) * 8, "nobody knows"
    assert docked_mus(FOUR, [True] * 12, ()) == (False,) * 4, "winches close the net of 4 MUs"


PLANNED = load(MissionParameters)
ALL_BUT_ONE = [True] * 3 + [False] + [True] * 4


def seen(positions, **more):
    positions = np.array(positions, float)
    return closing_situation(positions, np.zeros((8, 3)), DEBRIS, (0.0, 0.0, 0.0, 1.0), (0.0,) * 3, (0.0,) * 3, **more)


def closing_since(tick=481):
    mission = advance(launched(), EIGHT, (tick - 1) * PERIOD, NEAR, DEBRIS, PLANNED, CONTROL)
    assert mission.closing_points == ((1.0, -2.0, -56.0),) * 8, "nothing known of the attitude: the fixed place"
    return mission


def test_the_plan_is_made_from_what_is_seen_at_the_trigger():
    mouth = [(x, y, -50.0) for x, y in EIGHT.aiming.offsets]
    planned = advance(launched(), EIGHT, 480 * PERIOD, NEAR, DEBRIS, PLANNED, CONTROL, look=lambda: seen(mouth))
    plan = closing.plan(seen(mouth), EIGHT, PLANNED)
    assert (planned.closing_points, planned.closing_duration_s) == (plan.points, plan.duration_s)
    assert planned.points_ns == planned.closing_ns == 481 * PERIOD
    printed = advance(launched(), EIGHT, 480 * PERIOD, NEAR, DEBRIS, RULES, CONTROL, look=lambda: seen(mouth))
    assert printed.closing_points == ((1.0, -2.0, -53.5),) * 8, "the paper's control has one fixed place"


def test_who_has_not_docked_in_time_flies_to_the_last():
    mission = closing_since()
    near = np.array([(1.0, -2.0, -56.0)] * 8)
    near[3] += (1.5, 0.0, 0.0)
    due = 481 + round(PLANNED.closing_duration_s / CONTROL.control_period_s)

    def at(tick, locked=ALL_BUT_ONE, mission=mission, look=lambda: seen(near)):
        return advance(mission, EIGHT, tick * PERIOD, NEAR, DEBRIS, PLANNED, CONTROL, locked, look)

    assert at(due - 1) is mission
    assert at(due, [True] * 8).closing_points == mission.closing_points, "all have docked"
    assert at(due, look=None) is mission, "nobody knows where they are"
    rallied = at(due)
    assert rallied.closing_points == ((2.5, -2.0, -56.0),) * 8
    assert rallied.points_ns == (due + 1) * PERIOD, "it holds from the next tick on, whoever hears of it when"
    near[3] += (0.1, 0.0, 0.0)
    pause = round(PLANNED.regroup_period_s / CONTROL.control_period_s)
    assert at(due + pause, mission=rallied) is rallied
    assert at(due + 1 + pause, mission=rallied).closing_points == ((2.6, -2.0, -56.0),) * 8
    printed = advance(mission, EIGHT, due * PERIOD, NEAR, DEBRIS, RULES, CONTROL, ALL_BUT_ONE, lambda: seen(near))
    assert printed is mission, "the paper has no such rule"
