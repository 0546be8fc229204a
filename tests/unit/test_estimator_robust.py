"""The Kalman filter and the controller under odometry that is rubbish: never dead, and soon right again."""

import math

import numpy as np
import pytest

from tethernet_control import estimator
from tethernet_control.controller import MuController
from tethernet_control.law_numbers import law_numbers
from tethernet_core.mission import Mission, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system

CONTROL = load(ControlParameters)
UNIT = load_system("zenit_8mu").units[0]
P = law_numbers(CONTROL, UNIT)
T = CONTROL.control_period_s
SPEED = np.array([0.5, 0.4, -2.0])
RECOVERY = 32
"""Good samples after which the estimate must be right: 15 until it begins anew, the rest until it has settled."""


def good(random, tick):
    """A sample of an MU that coasts along a line."""
    place = SPEED * T * tick
    return (
        (place + random.normal(0.0, CONTROL.position_sigma_m, 3)).tolist(),
        (SPEED + random.normal(0.0, CONTROL.velocity_sigma_m_s, 3)).tolist(),
    )


def uniform(size):
    return lambda random, tick: (random.uniform(-size, size, 3).tolist(), random.uniform(-size, size, 3).tolist())


def alternating(random, tick):
    return uniform(500.0)(random, tick) if tick % 2 else good(random, tick)


def elsewhere(random, tick):
    place, speed = good(random, tick)
    return [place[0] + 3e5, place[1] - 2e5, place[2]], speed


def frozen(random, tick):
    return [100.0, -30.0, 7.0], [0.0, 0.0, 0.0]


def of_any_size(random, tick):
    size = 10.0 ** random.uniform(-3.0, 6.0)
    return uniform(size)(random, tick)


RUBBISH = {
    "near": uniform(3.0), "100 m": uniform(100.0), "1 km": uniform(1000.0), "1000 km": uniform(1e6),
    "every other sample": alternating, "another place": elsewhere, "frozen": frozen, "of any size": of_any_size,
}  # fmt: skip


def matrix(c):
    return np.array([[c[0], c[1], c[2]], [c[1], c[3], c[4]], [c[2], c[4], c[5]]])


@pytest.mark.parametrize("kind", RUBBISH)
@pytest.mark.parametrize("seed", range(8))
def test_rubbish_never_kills_the_filter_and_good_samples_bring_it_back(kind, seed):
    random = np.random.default_rng([seed, len(kind)])
    state, covariance = [0.0] * 9, [0.0] * 6
    begin, end = 100, 100 + int(random.integers(1, 200))
    for tick in range(end + RECOVERY):
        sample = RUBBISH[kind](random, tick) if begin <= tick < end else good(random, tick)
        estimator.observe(P, (0.0, 0.0, 0.0), T, *sample, state, covariance)
        assert all(map(math.isfinite, state))
        assert np.all(np.linalg.eigvalsh(matrix(covariance)) > 0.0)
        assert covariance[0] <= estimator.FORGOTTEN_M2 * estimator.SURPRISE
    truth = SPEED * T * tick
    assert math.dist(state[:3], truth) < 5.0 * math.sqrt(3.0 * covariance[0])
    assert math.dist(state[3:6], SPEED) < 5.0 * math.sqrt(3.0 * covariance[3])
    assert math.sqrt(covariance[0]) < CONTROL.position_sigma_m


def test_numbers_whose_squares_overflow_are_outliers():
    state, covariance = [0.0] * 9, [0.0] * 6
    estimator.observe(P, (0.0,) * 3, T, (0.0,) * 3, (0.0,) * 3, state, covariance)
    assert estimator.observe(P, (0.0,) * 3, T, (1e200, 0.0, 0.0), (-1e200, 0.0, 0.0), state, covariance)
    assert state[:3] == [0.0, 0.0, 0.0]


def test_a_covariance_that_rounding_has_spoilt_begins_anew():
    state, covariance = [0.0] * 9, [1e-3, 1.0, 0.0, 1e-3, 0.0, 1.0]
    assert not estimator.known(covariance)
    assert not estimator.observe(P, (0.0,) * 3, T, (4.0, 5.0, 6.0), (1.0, 2.0, 3.0), state, covariance)
    assert state == [4.0, 5.0, 6.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0]
    assert estimator.known(covariance)


@pytest.mark.parametrize("sigma", [0.0, CONTROL.position_sigma_m, 10.0])
@pytest.mark.parametrize("kind", RUBBISH)
def test_a_controller_outlives_rubbish(kind, sigma):
    random = np.random.default_rng(len(kind))
    noise = {"position_sigma_m": sigma, "velocity_sigma_m_s": sigma, "velocity_noise": 0.0}
    made = MuController(1, load(ControlParameters, noise), UNIT)
    made.take_mission(launch(arm(Mission(8), (0.0, 0.0, -50.0), "nominal"), 0))
    made.aim((12.0, 12.0, -50.0), "nominal")
    for tick in range(300):
        sample = RUBBISH[kind](random, tick) if 100 <= tick < 140 else good(random, tick)
        thrust = made.on_odometry(tick * CONTROL.period_ns, *sample)
        assert thrust is None or max(map(abs, thrust)) <= UNIT.thrust_limit_n
        assert math.isfinite(made.statistics.position_sigma_m)
