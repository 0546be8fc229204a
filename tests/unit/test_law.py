"""The control law against numbers worked out by hand, and compiled against interpreted."""

import math
import random

import numpy as np
import pytest

from tethernet_control import law
from tethernet_control.parameters import load
from tethernet_control.settings import ControlParameters

START, AIM, CLOSE = (1.0, 2.0, -1.0), (11.0, -8.0, -51.0), (0.0, 0.0, -60.0)


def desired(elapsed, closing_elapsed=-1.0, closing_duration=8.0):
    out = [0.0, 0.0, 0.0]
    law.desired_position(elapsed, 25.0, closing_elapsed, closing_duration, START, AIM, CLOSE, out)
    return out


@pytest.mark.parametrize(
    ("elapsed", "expected"),
    [(0.0, START), (12.5, (6.0, -3.0, -26.0)), (25.0, AIM), (39.0, AIM), (-3.0, START)],
)
def test_deployment_is_a_straight_line_held_at_its_end(elapsed, expected):
    assert desired(elapsed) == pytest.approx(expected)


def test_closing_starts_where_deployment_stood_and_ends_at_the_closing_point():
    # Closing began at 20 s, when deployment was at 4/5 of its line.
    stood = (9.0, -6.0, -41.0)
    assert desired(20.0, 0.0) == pytest.approx(stood)
    assert desired(24.0, 4.0) == pytest.approx([0.5 * (a + b) for a, b in zip(stood, CLOSE, strict=True)])
    assert desired(28.0, 8.0) == pytest.approx(CLOSE)
    assert desired(35.0, 15.0) == pytest.approx(CLOSE)


def thrust(position, velocity, target, integral=None, period=0.05, limit=5.1):
    out, integral = [0.0] * 3, integral if integral is not None else [0.0] * 3
    saturated = law.pid_thrust(position, velocity, target, integral, period, 10.0, 6.0, 6.0, limit, out)
    return out, saturated, integral


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


def test_default_parameters_are_the_papers():
    p = load(ControlParameters)
    assert (p.kp, p.ki, p.kd, p.thrust_limit_n) == (10.0, 6.0, 6.0, 5.1)
    assert (p.control_period_s, p.deployment_time_s, p.specific_impulse_s) == (0.05, 25.0, 60.0)
    assert 3.0 * p.position_sigma_m == pytest.approx(0.1)
    assert p.period_ns == 50_000_000


def test_compiled_and_interpreted_give_the_same_bits():
    numba = pytest.importorskip("numba")
    compiled = {name: numba.njit(getattr(law, name)) for name in ("desired_position", "pid_thrust", "fuel_used")}
    generator = random.Random(7)

    def vector(scale):
        return [generator.gauss(0.0, scale) for _ in range(3)]

    for _ in range(2000):
        line = (
            generator.uniform(-1, 45),
            25.0,
            generator.uniform(-5, 20),
            8.0,
            vector(1.0),
            vector(20.0),
            vector(40.0),
        )
        plain, fast = [0.0] * 3, np.zeros(3)
        law.desired_position(*line, plain)
        compiled["desired_position"](*line[:4], *(np.array(v) for v in line[4:]), fast)
        assert plain == fast.tolist()

        position, velocity, integral = vector(20.0), vector(1.0), vector(1.0)
        pid = (0.05, 10.0, 6.0, 6.0, 5.1)
        plain_integral, plain_force = list(integral), [0.0] * 3
        fast_integral, fast_force = np.array(integral), np.zeros(3)
        one = law.pid_thrust(position, velocity, plain, plain_integral, *pid, plain_force)
        other = compiled["pid_thrust"](np.array(position), np.array(velocity), fast, fast_integral, *pid, fast_force)
        assert (one, plain_integral, plain_force) == (other, fast_integral.tolist(), fast_force.tolist())

        burnt = law.fuel_used(plain_force, 0.05, 60.0, 9.81)
        assert burnt == compiled["fuel_used"](fast_force, 0.05, 60.0, 9.81)
        assert math.isfinite(burnt)
