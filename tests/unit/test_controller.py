"""One MU's controller without ROS."""

import dataclasses
import math

import pytest

from tethernet_control import law
from tethernet_control.controller import Mode, MuController
from tethernet_control.mission import Mission, Phase, abort, advance, arm, launch
from tethernet_control.settings import ControlParameters, MissionParameters, paper

CONTROL, RULES = paper(ControlParameters), paper(MissionParameters)
RELEASING = dataclasses.replace(RULES, release_docked=True)
PERIOD = CONTROL.period_ns
DEBRIS = (0.0, 0.0, -50.0)
STILL = (0.0, 0.0, 0.0)
START = (0.55, 0.55, -1.5)


def launched(mus=8, launch_ns=0):
    return launch(arm(Mission(mus), DEBRIS, "nominal"), launch_ns)


def closing(mission, tick):
    return advance(mission, tick * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)


def controller(mission=None, aim=(12.0, 12.0, -50.0)):
    made = MuController(4, CONTROL)
    if mission is not None:
        made.take_mission(mission)
        made.aim(aim, "nominal")
    return made


def fly(made, ticks, position=START, velocity=STILL):
    for tick in ticks:
        thrust = made.on_odometry(tick * PERIOD, position, velocity)
    return thrust


def test_idle_without_a_mission():
    made = controller()
    assert fly(made, range(3)) == STILL
    assert made.mode == Mode.IDLE
    assert made.account.commands == 3


def test_zero_thrust_until_launch_time():
    made = controller(launched(launch_ns=2 * PERIOD))
    assert fly(made, range(2)) == STILL
    assert made.mode == Mode.IDLE
    fly(made, [2])
    assert made.mode == Mode.DEPLOYING


def test_follows_the_line_from_where_it_was_at_launch():
    made = controller(launched())
    fly(made, range(21))
    assert made.desired == pytest.approx([s + (a - s) / 25.0 for s, a in zip(START, (12.0, 12.0, -50.0), strict=True)])
    assert made.account.tracking_error_m == pytest.approx(math.dist(made.desired, START))
    assert made.account.max_tracking_error_m >= made.account.tracking_error_m


def test_thrust_is_the_laws():
    made = controller(launched())
    fly(made, [0])
    thrust = made.on_odometry(PERIOD, (0.5, 0.5, -1.4), (0.01, 0.0, -0.02))
    p, integral, expected = CONTROL.law(), [0.0] * 3, [0.0] * 3
    law.pid_thrust(p, START, STILL, START, STILL, integral, 0.05, expected)
    law.pid_thrust(p, (0.5, 0.5, -1.4), (0.01, 0.0, -0.02), made.desired, STILL, integral, 0.05, expected)
    assert thrust == tuple(expected)


@pytest.mark.parametrize(
    ("position", "velocity"),
    [((math.nan, 0.0, 0.0), STILL), (START, (0.0, math.inf, 0.0)), ((-math.inf, 0.0, math.inf), STILL)],
)
def test_odometry_that_is_not_finite_is_dropped_and_counted(position, velocity):
    made = controller(launched())
    fly(made, range(5))
    before = made.on_odometry(5 * PERIOD, START, STILL)
    assert made.on_odometry(6 * PERIOD, position, velocity) is None
    assert made.account.rejected_odometry == 1
    assert all(map(math.isfinite, (*before, *made.on_odometry(7 * PERIOD, START, STILL))))
    assert made.account.deadline_misses == 1  # the period of the dropped sample


def test_odometry_out_of_order_is_dropped_and_counted():
    made = controller(launched())
    fly(made, range(5))
    assert made.on_odometry(4 * PERIOD, START, STILL) is None
    assert made.on_odometry(3 * PERIOD, START, STILL) is None
    assert made.account.rejected_odometry == 2


def test_lost_odometry_zeroes_thrust_until_it_comes_back():
    made = controller(launched())
    fly(made, range(20))
    assert made.odometry_lost()
    assert made.mode == Mode.NO_ODOMETRY
    assert not made.odometry_lost()  # told once
    held = tuple(made._thrust)
    before = made.account.fuel_kg
    fly(made, [40])
    assert made.mode == Mode.DEPLOYING
    assert made.account.deadline_misses == 20
    # The last command acted until the watchdogs let go of it, five periods later.
    assert made.account.fuel_kg - before == pytest.approx(law.fuel_used(held, 0.25, 60.0, 9.81))


def test_a_halted_lock_step_does_not_change_the_account():
    undisturbed, disturbed = controller(launched()), controller(launched())
    for tick in range(100):
        thrusts = [made.on_odometry(tick * PERIOD, START, STILL) for made in (undisturbed, disturbed)]
        assert thrusts[0] == thrusts[1]
        if tick % 7 == 3:
            disturbed.odometry_lost()  # wall time passed, no time on the stamps
    assert dataclasses.asdict(undisturbed.account) == dataclasses.asdict(disturbed.account)


def test_closing_flies_to_the_closing_point_from_the_tick_after_the_trigger():
    mission = launched()
    made = controller(mission)
    fly(made, range(481))
    made.take_mission(closing(mission, 480))
    fly(made, [481])
    assert made.mode == Mode.CLOSING
    fly(made, range(482, 481 + 160 + 1))
    assert made.desired == pytest.approx((0.0, 0.0, -53.5))


def test_four_mus_switch_off_when_the_winches_take_over():
    mission = launched(mus=4)
    made = controller(mission)
    assert fly(made, range(481)) != STILL
    made.take_mission(closing(mission, 480))
    assert fly(made, [481]) == STILL
    assert made.mode == Mode.OFF
    fuel = made.account.fuel_kg
    fly(made, range(482, 500))
    assert made.account.fuel_kg == made.account.fuel_at_trigger_kg == fuel


def test_fuel_at_trigger_stands_whatever_comes_after():
    mission = launched()
    made = controller(mission)
    fly(made, range(481))
    closed = closing(mission, 480)
    made.take_mission(closed)
    fly(made, [481])
    at_trigger = made.account.fuel_kg
    assert made.account.fuel_at_trigger_kg == at_trigger > 0.0
    fly(made, range(482, 481 + 300))
    assert made.mode == Mode.CLOSING
    assert fly(made, [481 + 300]) == STILL  # end_ns
    assert made.mode == Mode.OFF
    end = made.account.fuel_kg
    fly(made, range(782, 800))
    assert made.account.fuel_kg == end > at_trigger
    assert made.account.fuel_at_trigger_kg == at_trigger


def test_fuel_is_the_integral_of_thrust():
    made = controller(launched())
    expected, previous = 0.0, STILL
    for tick in range(60):
        expected += law.fuel_used(previous, 0.05, 60.0, 9.81) if tick else 0.0
        previous = made.on_odometry(tick * PERIOD, (0.5, 0.6, -1.4 - 0.01 * tick), STILL)
    assert made.account.fuel_kg == pytest.approx(expected, rel=1e-12)
    assert made.account.saturated > 0


def test_an_abort_switches_off():
    mission = launched()
    made = controller(mission)
    fly(made, range(10))
    assert made.take_mission(abort(mission, "asked for"))
    assert made.mode == Mode.OFF
    assert fly(made, [10]) == STILL


def test_states_that_are_not_newer_change_nothing():
    mission = launched()
    made = controller(mission)
    assert not made.take_mission(mission)
    assert not made.take_mission(arm(Mission(8), DEBRIS, "other"))
    assert made.mission.phase == Phase.DEPLOYING


def test_a_docked_unit_switches_off():
    mission = launched()
    made = controller(mission)
    fly(made, range(481))
    closed = closing(mission, 480)
    made.take_mission(closed)
    assert fly(made, [481, 482]) != STILL
    almost = advance(closed, 483 * PERIOD, DEBRIS, DEBRIS, RELEASING, CONTROL, [1, 1, 1, 0, 1, 1, 1, 1])
    assert almost is closed, "the bunch has not docked as a whole"
    done = advance(closed, 483 * PERIOD, DEBRIS, DEBRIS, RELEASING, CONTROL, [1] * 8)
    assert done.docked_ns == (484 * PERIOD,) * 8
    made.take_mission(done)
    assert fly(made, [483]) != STILL, "it takes effect at the next tick, whoever hears of it when"
    assert fly(made, [484]) == STILL
    assert made.mode == Mode.OFF


def test_new_closing_points_hold_from_their_time_on():
    mission = launched()
    made, other = controller(mission), controller(mission)
    closed = closing(mission, 480)
    moved = dataclasses.replace(
        closed, sequence=closed.sequence + 1, closing_points=((-50.0, 0.0, -50.0),) * 8, points_ns=600 * PERIOD
    )
    for one in (made, other):
        fly(one, range(481))
        one.take_mission(closed)
        fly(one, range(481, 590))
    made.take_mission(moved)
    assert fly(made, range(590, 600)) == fly(other, range(590, 600))
    assert made.desired == other.desired
    for one in (made, other):
        fly(one, [600])
    assert made.desired[0] < other.desired[0] - 10.0
