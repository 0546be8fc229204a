"""The mission's phases."""

import math

import pytest

from tethernet_control.mission import (
    Mission,
    Phase,
    abort,
    advance,
    arm,
    check_debris_position,
    closing_points,
    docked_mus,
    launch,
    triggered,
)
from tethernet_control.settings import ControlParameters, MissionParameters, paper

CONTROL, RULES = paper(ControlParameters), paper(MissionParameters)
PERIOD = CONTROL.period_ns
DEBRIS, FAR, NEAR = (1.0, -2.0, -50.0), (1.0, -2.0, -40.0), (1.0, -2.0, -47.6)


def step(mission, tick, net):
    return advance(mission, tick * PERIOD, net, DEBRIS, RULES, CONTROL)


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
    assert step(launched(4), 480, NEAR).closing_points == ()
    assert closing_points(4, DEBRIS, RULES) == ()


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


def test_docked_with_both_neighbours():
    locked = [False] * 8
    assert docked_mus(8, locked) == (False,) * 8
    locked[0] = locked[1] = True  # (1 5) and (5 2)
    assert docked_mus(8, locked) == (False, False, False, False, True, False, False, False)
    assert docked_mus(8, [True] * 8) == (True,) * 8
    assert docked_mus(4, [True] * 12) == (False,) * 4, "winches close the net of 4 MUs"
    assert docked_mus(8, []) == (False,) * 8, "nobody knows"
