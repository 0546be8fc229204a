"""The control law against numbers worked out by hand, and compiled against interpreted."""

import math
import random

import numpy as np
import pytest

from tethernet_control import estimator, law
from tethernet_control.law_numbers import law_numbers
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, paper
from tethernet_core.system import load_system

UNIT = load_system("zenit_8mu").units[0]
PAPER = law_numbers(paper(ControlParameters), UNIT)
OURS = law_numbers(load(ControlParameters), UNIT)
START, AIM, CLOSE = (1.0, 2.0, -1.0), (11.0, -8.0, -51.0), (0.0, 0.0, -60.0)


def desired(elapsed, closing_elapsed=-1.0, closing_duration=8.0, p=PAPER):
    out, speed, push = [0.0] * 3, [0.0] * 3, [0.0] * 3
    law.reference(p, elapsed, closing_elapsed, closing_duration, START, AIM, CLOSE, out, speed, push)
    return out


@pytest.mark.parametrize(
    ("elapsed", "expected"),
    [(0.0, START), (12.5, (6.0, -3.0, -26.0)), (25.0, AIM), (39.0, AIM), (-3.0, START)],
)
def test_deployment_is_a_straight_line_held_at_its_end(elapsed, expected):
    assert desired(elapsed) == pytest.approx(expected)


def test_a_follow_through_goes_on_at_the_same_speed_and_is_held_at_its_end():
    p = PAPER._replace(follow_through=6.0)
    direction = [(a - b) / math.dist(AIM, START) for a, b in zip(AIM, START, strict=True)]
    assert desired(25.0, p=p) == pytest.approx(AIM)
    later = math.dist(AIM, START) / 25.0 * 2.0  # two seconds at its speed, short of 6 m
    assert desired(27.0, p=p) == pytest.approx([a + later * d for a, d in zip(AIM, direction, strict=True)])
    assert desired(39.0, p=p) == pytest.approx([a + 6.0 * d for a, d in zip(AIM, direction, strict=True)])
    # Closing begins where the line stood, beyond the aiming point.
    assert desired(27.0, 0.0, p=p) == pytest.approx(desired(27.0, p=p))


def test_a_follow_through_from_the_aiming_point_itself_stays_there():
    out, speed, push = [0.0] * 3, [1.0] * 3, [0.0] * 3
    law.reference(OURS, 30.0, -1.0, 8.0, AIM, AIM, CLOSE, out, speed, push)
    assert (tuple(out), speed) == (AIM, [0.0] * 3)


def test_closing_starts_where_deployment_stood_and_ends_at_the_closing_point():
    # Closing began at 20 s, when deployment was at 4/5 of its line.
    stood = (9.0, -6.0, -41.0)
    assert desired(20.0, 0.0) == pytest.approx(stood)
    assert desired(24.0, 4.0) == pytest.approx([0.5 * (a + b) for a, b in zip(stood, CLOSE, strict=True)])
    assert desired(28.0, 8.0) == pytest.approx(CLOSE)
    assert desired(35.0, 15.0) == pytest.approx(CLOSE)


def thrust(position, velocity, target, integral=None, period=0.05, p=PAPER, speed=(0.0, 0.0, 0.0)):
    out, integral = [0.0] * 3, integral if integral is not None else [0.0] * 3
    law.pid_thrust(p, position, velocity, target, speed, integral, period, out)
    saturated = law.apply_thruster_limits(p, period, [0.0] * 3, out)
    return out, saturated, integral


def test_a_ramp_gets_up_to_speed_and_arrives_at_the_same_time():
    ramped = OURS._replace(ramp_time=2.0)
    assert desired(0.0, p=ramped) == pytest.approx(START)
    assert desired(25.0, p=ramped) == pytest.approx(AIM)
    step = 1e-4
    for elapsed in (0.7, 1.999, 2.5, 20.0):
        speed, push, later, unused = [0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3
        law.reference(ramped, elapsed, -1.0, 1.0, START, AIM, CLOSE, unused, speed, push)
        law.reference(ramped, elapsed + step, -1.0, 1.0, START, AIM, CLOSE, unused, later, unused.copy())
        ahead, behind = desired(elapsed + step, p=ramped), desired(elapsed - step, p=ramped)
        assert speed == pytest.approx([(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)], rel=1e-3)
        if abs(elapsed - 2.0) > 2 * step:
            acceleration = [(a - b) / step for a, b in zip(later, speed, strict=True)]
            assert push == pytest.approx([OURS.mass * a for a in acceleration], abs=1e-6)


def test_feed_forward_asks_for_no_thrust_on_the_ramps_cruise():
    speed = (0.4, -0.4, -2.0)
    force, _, _ = thrust(START, speed, START, p=OURS, speed=speed)
    assert force == [0.0, 0.0, 0.0]
    force, _, _ = thrust(START, speed, START, p=PAPER, speed=speed)
    assert force == pytest.approx([-2.4, 2.4, 5.1])  # the paper's derivative brakes


def test_the_dead_band_keeps_small_thrust_back_and_winds_nothing_up():
    p = OURS._replace(kp=10.0, ki=6.0, dead_band=0.5)
    force, _, integral = thrust((0.0,) * 3, (0.0,) * 3, (0.048, 0.0, 0.06), p=p)
    assert force == pytest.approx([0.0, 0.0, 0.618])
    assert integral == pytest.approx([0.0, 0.0, 0.003])


def test_anti_windup_stops_the_integral_at_the_limit():
    for p, expected in ((OURS, 0.0), (PAPER, 0.1)):
        _, saturated, integral = thrust((0.0,) * 3, (0.0,) * 3, (2.0, 0.0, 0.0), p=p)
        assert saturated
        assert integral[0] == pytest.approx(expected)


def test_the_minimum_impulse_bit_saves_up_what_is_too_small():
    p = PAPER._replace(minimum_impulse=0.02)
    carry, fired = [0.0] * 3, []
    for _ in range(10):
        force = [0.15, -5.0, 0.0]  # 0.0075 N s a period
        law.apply_thruster_limits(p, 0.05, carry, force)
        fired.append(force[0])
        assert force[1:] == [-5.0, 0.0]
    assert fired == pytest.approx([0.0, 0.0, 0.45] * 3 + [0.0])
    assert sum(fired) * 0.05 + carry[0] == pytest.approx(10 * 0.0075)


def test_intercept_gains_what_is_missing_and_nothing_else():
    out = [0.0] * 3
    # 10 m in 5 s: 2 m/s; 1.5 m/s are there
    law.intercept_thrust(OURS, (0.0,) * 3, (1.5, 0.0, 0.0), (10.0, 0.0, 0.0), 5.0, out)
    assert out == pytest.approx([OURS.mass * 0.5 / OURS.closing_response, 0.0, 0.0])
    law.intercept_thrust(OURS, (0.0,) * 3, (1.9, 0.0, 0.0), (10.0, 0.0, 0.0), 5.0, out)
    assert out == [0.0, 0.0, 0.0], "0.1 m/s is within the dead band"
    law.intercept_thrust(OURS, (0.0,) * 3, (0.0,) * 3, (1.0, 0.0, 0.0), 0.01, out)
    assert out[0] == pytest.approx(OURS.mass * (1.0 / OURS.shortest_to_go) / OURS.closing_response)


def closing_thrust(elapsed, closing_elapsed):
    """Of a unit that the net has not turned yet: it flies outwards."""
    force, at, velocity = [0.0] * 3, (16.0, 0.0, -50.0), (0.6, 0.0, -2.0)
    law.command(
        OURS, elapsed, closing_elapsed, 13.0, 0.05, at, velocity, START, AIM, CLOSE, [*at, *velocity, 0.0, 0.0, 0.0],
        [0.0] * 3, [0.0] * 3, force, [0.0] * 3, [0.0] * 3,
    )  # fmt: skip
    return force


@pytest.mark.parametrize(
    ("trigger", "begins"),
    [(23.0, 25.0 + OURS.closing_turn), (24.9, 24.9 + OURS.closing_coast), (30.0, 30.0 + OURS.closing_coast)],
    ids=["net came early", "net came in time", "net came late"],
)
def test_closing_begins_when_the_units_have_been_where_they_were_aimed(trigger, begins):
    """A net whose threads damp little comes more than a second before its mouth is open."""
    before, after = begins - 0.05, begins + 0.05
    assert closing_thrust(before, before - trigger) == [0.0, 0.0, 0.0]
    assert closing_thrust(after, after - trigger)[0] < 0.0


def test_pid_is_the_papers_equation():
    force, saturated, integral = thrust((0.0, 0.0, 0.0), (0.1, 0.0, -0.2), (0.2, -0.1, 0.0))
    # Kp e - Kd v + Ki (e dt)
    assert force == pytest.approx([2.0 - 0.6 + 0.06, -1.0 - 0.03, 1.2])
    assert not saturated
    assert integral == pytest.approx([0.01, -0.005, 0.0])


def test_integral_grows_with_time_and_is_returned_not_hidden():
    integral = [0.0] * 3
    for _ in range(20):
        force, _, integral = thrust((0.0,) * 3, (0.0,) * 3, (0.1, 0.0, 0.0), integral)
    assert integral[0] == pytest.approx(0.1)  # 0.1 m for 1 s
    assert force[0] == pytest.approx(10.0 * 0.1 + 6.0 * 0.1)


def test_thrust_is_limited_on_each_axis_by_itself():
    force, saturated, _ = thrust((0.0,) * 3, (0.0,) * 3, (3.0, -7.0, 0.1))
    assert force[:2] == [5.1, -5.1]
    assert force[2] == pytest.approx(1.03)
    assert saturated


def test_fuel_of_a_constant_thrust_in_closed_form():
    # |F| t / (g0 Isp): 5 N for 2 s
    assert law.fuel_used((3.0, 0.0, -4.0), 2.0, 60.0, 9.81) == pytest.approx(10.0 / (9.81 * 60.0))
    assert law.fuel_used((0.0, 0.0, 0.0), 2.0, 60.0, 9.81) == 0.0


def test_the_papers_parameters():
    p = paper(ControlParameters)
    assert (p.estimator, p.feed_forward, p.ramp_time_s, p.dead_band_n) == ("raw", False, 0.0, 0.0)
    assert p.follow_through_m == 0.0
    assert (p.kp, p.ki, p.kd, UNIT.thrust_limit_n) == (10.0, 6.0, 6.0, 5.1)
    assert (p.control_period_s, p.deployment_time_s, UNIT.specific_impulse_s) == (0.05, 25.0, 60.0)
    assert 3.0 * p.position_sigma_m == pytest.approx(0.1)
    assert p.period_ns == 50_000_000


@pytest.mark.parametrize("p", [PAPER, OURS, OURS._replace(minimum_impulse=0.02)], ids=["paper", "ours", "impulse bit"])
def test_compiled_and_interpreted_give_the_same_bits(p):
    numba = pytest.importorskip("numba")
    from numba.extending import register_jitable

    for function in law.CALLED:
        register_jitable(function)
    observe, command, fuel = numba.njit(estimator.observe), numba.njit(law.command), numba.njit(law.fuel_used)
    generator = random.Random(7)

    def vector(scale):
        return [generator.gauss(0.0, scale) for _ in range(3)]

    start, aim, close = vector(1.0), vector(20.0), vector(40.0)
    plain = [
        [0.0] * size for size in (9, 6, 3, 3, 3, 3, 3)
    ]  # state, covariance, integral, carry, thrust, desired, speed
    fast = [np.zeros(size) for size in (9, 6, 3, 3, 3, 3, 3)]
    for tick in range(1500):
        elapsed = 0.05 * tick
        closing = elapsed - 30.0 if elapsed >= 30.0 else -1.0
        position, velocity = vector(20.0), vector(1.0)
        if p.estimate:
            one = estimator.observe(p, plain[4], 0.05, position, velocity, plain[0], plain[1])
            other = observe(p, fast[4], 0.05, np.array(position), np.array(velocity), fast[0], fast[1])
            assert one == other
        one = law.command(p, elapsed, closing, 13.0, 0.05, position, velocity, start, aim, close, plain[0], *plain[2:])
        other = command(
            p, elapsed, closing, 13.0, 0.05, np.array(position), np.array(velocity), np.array(start), np.array(aim),
            np.array(close), fast[0], *fast[2:],
        )  # fmt: skip
        assert one == other
        assert plain == [values.tolist() for values in fast]
        assert law.fuel_used(plain[4], 0.05, 60.0, 9.81) == fuel(fast[4], 0.05, 60.0, 9.81)
    assert math.isfinite(sum(plain[4]))
