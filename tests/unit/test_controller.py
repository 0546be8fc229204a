"""One MU's controller without ROS."""

import dataclasses
import math

import pytest

from tethernet_control import law
from tethernet_control.controller import MuController
from tethernet_control.law_numbers import law_numbers
from tethernet_core.mission import Mission, Mode, Phase, abort, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters, paper
from tethernet_core.system import load_system
from tethernet_planner.mission_rules import advance

# An MU that is held where it is, as in most of these tests, burns more than it has on board.
CONTROL, RULES = paper(ControlParameters), paper(MissionParameters)
RELEASING = dataclasses.replace(RULES, release_docked=True)
PERIOD = CONTROL.period_ns
DEBRIS = (0.0, 0.0, -50.0)
STILL = (0.0, 0.0, 0.0)
START = (0.55, 0.55, -1.5)

UNIT = dataclasses.replace(load_system("zenit_8mu").units[3], propellant_kg=1.0)


def launched(mus=8, launch_ns=0):
    return launch(arm(Mission(mus), DEBRIS, "nominal"), launch_ns)


def closing(mission, tick):
    system = load_system(f"zenit_{mission.mu_count}mu")
    return advance(mission, system, tick * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)


def controller(mission=None, aim=(12.0, 12.0, -50.0)):
    made = MuController(4, CONTROL, UNIT)
    if mission is not None:
        made.take_mission(mission)
        made.aim(aim, "nominal")
    return made


def fly(made, ticks, position=START, velocity=STILL):
    for tick in ticks:
        made.on_heartbeat(tick * PERIOD)
        thrust = made.on_odometry(tick * PERIOD, position, velocity)
    return thrust


def test_idle_without_a_mission():
    made = controller()
    assert fly(made, range(3)) == STILL
    assert made.mode == Mode.IDLE
    assert made.statistics.commands == 3


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
    assert made.statistics.tracking_error_m == pytest.approx(math.dist(made.desired, START))
    assert made.statistics.max_tracking_error_m >= made.statistics.tracking_error_m


def test_thrust_is_the_laws():
    made = controller(launched())
    fly(made, [0])
    thrust = made.on_odometry(PERIOD, (0.5, 0.5, -1.4), (0.01, 0.0, -0.02))
    p, integral, expected = law_numbers(CONTROL, UNIT), [0.0] * 3, [0.0] * 3
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
    assert made.statistics.rejected_odometry == 1
    assert all(map(math.isfinite, (*before, *made.on_odometry(7 * PERIOD, START, STILL))))
    assert made.statistics.deadline_misses == 1  # the period of the dropped sample


def test_odometry_out_of_order_is_dropped_and_counted():
    made = controller(launched())
    fly(made, range(5))
    assert made.on_odometry(4 * PERIOD, START, STILL) is None
    assert made.on_odometry(3 * PERIOD, START, STILL) is None
    assert made.statistics.rejected_odometry == 2


def test_lost_odometry_zeroes_thrust_until_it_comes_back():
    made = controller(launched())
    fly(made, range(20))
    assert made.odometry_lost()
    assert made.mode == Mode.NO_ODOMETRY
    assert not made.odometry_lost()  # told once
    held = tuple(made._thrust)
    before = made.statistics.fuel_kg
    fly(made, [40])
    assert made.mode == Mode.DEPLOYING
    assert made.statistics.deadline_misses == 20
    # The last command acted until the first tick at which it was more than five periods old: for six.
    assert made.statistics.fuel_kg - before == pytest.approx(law.fuel_used(held, 0.3, 60.0, 9.81))


def test_a_halted_lock_step_does_not_change_the_account():
    undisturbed, disturbed = controller(launched()), controller(launched())
    for tick in range(100):
        thrusts = [made.on_odometry(tick * PERIOD, START, STILL) for made in (undisturbed, disturbed)]
        assert thrusts[0] == thrusts[1]
        if tick % 7 == 3:
            disturbed.odometry_lost()  # wall time passed, no time on the stamps
    assert dataclasses.asdict(undisturbed.statistics) == dataclasses.asdict(disturbed.statistics)


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
    fuel = made.statistics.fuel_kg
    fly(made, range(482, 500))
    assert made.statistics.fuel_kg == made.statistics.fuel_at_trigger_kg == fuel


def test_fuel_at_trigger_stands_whatever_comes_after():
    mission = launched()
    made = controller(mission)
    fly(made, range(481))
    closed = closing(mission, 480)
    made.take_mission(closed)
    fly(made, [481])
    at_trigger = made.statistics.fuel_kg
    assert made.statistics.fuel_at_trigger_kg == at_trigger > 0.0
    fly(made, range(482, 481 + 300))
    assert made.mode == Mode.CLOSING
    assert fly(made, [481 + 300]) == STILL  # end_ns
    assert made.mode == Mode.OFF
    end = made.statistics.fuel_kg
    fly(made, range(782, 800))
    assert made.statistics.fuel_kg == end > at_trigger
    assert made.statistics.fuel_at_trigger_kg == at_trigger


def test_fuel_is_the_integral_of_thrust():
    made = controller(launched())
    expected, previous = 0.0, STILL
    for tick in range(60):
        expected += law.fuel_used(previous, 0.05, 60.0, 9.81) if tick else 0.0
        previous = made.on_odometry(tick * PERIOD, (0.5, 0.6, -1.4 - 0.01 * tick), STILL)
    assert made.statistics.fuel_kg == pytest.approx(expected, rel=1e-12)
    assert made.statistics.saturated > 0


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
    almost = advance(
        closed, load_system("zenit_8mu"), 483 * PERIOD, DEBRIS, DEBRIS, RELEASING, CONTROL, [1, 1, 1, 0, 1, 1, 1, 1]
    )
    assert almost is closed, "the docking group has not docked as a whole"
    done = advance(closed, load_system("zenit_8mu"), 483 * PERIOD, DEBRIS, DEBRIS, RELEASING, CONTROL, [1] * 8)
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


# What ends a flight without a planner


def heard_last(made, tick, until):
    """Odometry goes on, the planner does not: thrusts and modes, tick by tick."""
    return [(made.on_odometry(t * PERIOD, START, STILL), made.mode) for t in range(tick + 1, until)]


def test_without_news_of_the_planner_the_thrust_ends_until_it_is_back():
    made = controller(launched())
    assert fly(made, range(50)) != STILL
    patience = round(CONTROL.planner_timeout_s / CONTROL.control_period_s) - 1  # the last heartbeat came in tick 48
    said = heard_last(made, 49, 50 + 2 * patience)
    assert all(thrust != STILL and mode == Mode.DEPLOYING for thrust, mode in said[:patience])
    assert all(thrust == STILL and mode == Mode.NO_PLANNER for thrust, mode in said[patience:])
    fuel = made.statistics.fuel_kg
    back = 50 + 2 * patience
    assert fly(made, range(back, back + CONTROL.clock_recovery_samples)) != STILL
    assert made.mode == Mode.DEPLOYING
    assert made.statistics.fuel_kg == fuel


def test_a_lock_step_that_halts_does_not_lose_the_planner():
    """The watchdog goes by the stamps: however long nothing at all happens, no time passes."""
    made = controller(launched())
    fly(made, range(50))
    made.odometry_lost()
    assert made.on_odometry(50 * PERIOD, START, STILL) != STILL
    assert made.mode == Mode.DEPLOYING


def test_a_heartbeat_from_the_future_keeps_nobody_flying():
    made = controller(launched())
    fly(made, range(50))
    for tick in range(50, 400):
        made.on_heartbeat(10**18)
        made.on_odometry(tick * PERIOD, START, STILL)
    assert made.mode == Mode.NO_PLANNER


def test_ten_minutes_without_a_planner_take_five_seconds_of_propellant():
    made = controller(launched())
    made.on_odometry(0, START, STILL)
    for tick in range(1, 12001):
        made.on_odometry(tick * PERIOD, (-10.0, -10.0, -50.0), STILL)
    assert made.statistics.fuel_kg < law.fuel_used((5.1, 5.1, 5.1), CONTROL.planner_timeout_s + 0.1, 60.0, 9.81)
    assert made.mode == Mode.OFF


def test_the_longest_flight_ends_the_thrust_whatever_the_planner_says():
    made = controller(launched())
    last = round(CONTROL.longest_flight_s / CONTROL.control_period_s)
    fly(made, range(0, last, 50))
    assert fly(made, [last - 1]) != STILL
    assert fly(made, [last]) == STILL
    assert made.mode == Mode.OFF


def test_the_propellant_is_a_budget():
    little = dataclasses.replace(UNIT, propellant_kg=0.01)
    made = MuController(4, CONTROL, little)
    made.take_mission(launched())
    made.aim((12.0, 12.0, -50.0), "nominal")
    fly(made, range(400))
    assert made.mode == Mode.EMPTY
    assert made.propellant_kg == 0.0
    assert 0.01 <= made.statistics.fuel_kg <= 0.01 + law.fuel_used((5.1, 5.1, 5.1), 0.05, 60.0, 9.81)


def test_every_abort_is_obeyed_in_flight():
    """Also that of a planner that was started anew and counts from the beginning."""
    made = controller(launched())
    fly(made, range(10))
    assert made.take_mission(abort(Mission(8, mission_id=77), "stop"))
    assert made.mode == Mode.OFF
    assert fly(made, [10]) == STILL
    ongoing = dataclasses.replace(launched(), sequence=3)
    assert not made.take_mission(ongoing), "the mission that was aborted is over"
    assert fly(made, [11]) == STILL


def test_a_mission_of_a_new_planner_begins_with_an_aiming_point_of_its_own():
    made = controller(launched())
    fly(made, range(10))
    made.take_mission(abort(launched(), "asked for"))
    assert made.take_mission(arm(Mission(8, mission_id=77), DEBRIS, "nominal"))
    assert made.aiming_point is None
    made.take_mission(launch(arm(Mission(8, mission_id=77), DEBRIS, "nominal"), 20 * PERIOD))
    made.aim((5.0, 5.0, -50.0), "nominal")
    assert fly(made, [20, 21]) != STILL
    assert made.mode == Mode.DEPLOYING


# Stamps that cannot be


def test_one_stamp_from_the_future_is_dropped_and_nothing_else_happens():
    made, other = controller(launched()), controller(launched())
    for one in (made, other):
        fly(one, range(100))
    assert made.on_odometry(10**18, START, STILL) is None
    assert "off the last one" in made.dropped_because
    assert [fly(made, [k]) for k in range(100, 110)] == [fly(other, [k]) for k in range(100, 110)]
    assert (made.statistics.clock_jumps, made.statistics.rejected_odometry, made.statistics.deadline_misses) == (
        1,
        1,
        0,
    )


@pytest.mark.parametrize("offset_ns", [-4_000_000_000, 4_000_000_000])
def test_a_clock_that_was_set_anew_is_followed_after_some_samples(offset_ns):
    """One step back or forward by seconds: the flight goes on by the new clock."""
    made = controller(launched())
    fly(made, range(200))
    for tick in range(200, 210):
        made.on_odometry(tick * PERIOD + offset_ns, START, STILL)
        made.on_heartbeat(tick * PERIOD + offset_ns)
    assert made.stamp_ns == 209 * PERIOD + offset_ns
    assert made.mode == Mode.DEPLOYING
    assert made.statistics.clock_resets == (offset_ns < 0)


@pytest.mark.parametrize("offset_ns", [-(10**15), 10**18])
def test_a_clock_that_has_nothing_to_do_with_the_missions_gets_no_thrust(offset_ns):
    made = controller(launched())
    fly(made, range(200))
    answers = [made.on_odometry(tick * PERIOD + offset_ns, START, STILL) for tick in range(200, 210)]
    assert answers == [None] * (CONTROL.clock_recovery_samples - 1) + [STILL] * (11 - CONTROL.clock_recovery_samples)
    assert made.statistics.deadline_misses == 0


def test_positions_nobody_can_be_at_are_dropped():
    made = controller(launched())
    fly(made, range(5))
    assert made.on_odometry(5 * PERIOD, (1e7, 0.0, 0.0), STILL) is None
    assert made.on_odometry(5 * PERIOD, START, (0.0, -1e300, 0.0)) is None
    assert fly(made, [5]) is not None


def test_the_tracking_error_is_the_estimates():
    made = MuController(4, load(ControlParameters), UNIT)
    made.take_mission(launched())
    made.aim((12.0, 12.0, -50.0), "nominal")
    for tick in range(40):
        sample = (START[0] + 0.05 * (-1) ** tick, *START[1:])
        made.on_odometry(tick * PERIOD, sample, STILL)
    assert made.statistics.tracking_error_m == pytest.approx(math.dist(made.desired, made._state[:3]), rel=1e-12)
    assert made.statistics.tracking_error_m != pytest.approx(math.dist(made.desired, sample), abs=0.01)
