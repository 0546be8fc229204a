"""The Kalman filter: consistent, without lag, not to be fooled by outliers and gaps."""

import math

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from scipy.stats import chi2

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
T = 0.05
F = np.array([[1.0, T, 0.5 * T * T], [0.0, 1.0, T], [0.0, 0.0, 1.0]])
IMPULSES, WALK = P.velocity_noise**2 * T, P.disturbance_noise**2 * T
Q = np.array([[IMPULSES * T * T / 3, IMPULSES * T / 2, 0.0], [IMPULSES * T / 2, IMPULSES, 0.0], [0.0, 0.0, WALK]])
R = np.diag([P.position_variance, P.velocity_variance])
H = np.eye(3)[:2]


def matrix(c):
    return np.array([[c[0], c[1], c[2]], [c[1], c[3], c[4]], [c[2], c[4], c[5]]])


def run(ticks, random, thrust=(0.0, 0.0, 0.0), disturbance=(0.0, 0.0, 0.0), process=True):
    """Truth by the filter's own model, and the filter; yields (truth (3, 3), state, covariance) after each sample."""
    truth = np.zeros((3, 3))  # rows: position, velocity, disturbance; columns: axes
    truth[2] = disturbance
    state, covariance = [0.0] * 9, [0.0] * 6
    push = np.outer([0.5 * T * T, T, 0.0], np.divide(thrust, P.mass))
    for tick in range(ticks):
        if tick:
            noise = np.linalg.cholesky(Q) @ random.standard_normal((3, 3)) if process else 0.0
            truth = F @ truth + push + noise
        sample = truth[:2] + np.sqrt(np.diag(R))[:, None] * random.standard_normal((2, 3))
        estimator.observe(P, thrust, T, sample[0], sample[1], state, covariance)
        yield truth, np.array(state).reshape(3, 3), matrix(covariance)


def test_steady_state_is_the_riccati_equations():
    *_, (_, _, covariance) = run(2000, np.random.default_rng(1))
    predicted = solve_discrete_are(F.T, H.T, Q, R)
    gain = predicted @ H.T @ np.linalg.inv(H @ predicted @ H.T + R)
    assert np.allclose(covariance, (np.eye(3) - gain @ H) @ predicted, rtol=1e-6)


def test_normalised_error_is_within_its_chi_square_bounds():
    runs, ticks = 40, 200
    total = 0.0
    for seed in range(runs):
        *_, (truth, state, covariance) = run(ticks, np.random.default_rng(seed))
        error = truth - state
        total += sum(error[:, a] @ np.linalg.solve(covariance, error[:, a]) for a in range(3))
    degrees = 9 * runs
    assert chi2.ppf(0.005, degrees) < total < chi2.ppf(0.995, degrees)


def test_no_lag_on_the_ramp_under_thrust_and_a_steady_pull():
    errors = [
        truth - state
        for truth, state, _ in run(1200, np.random.default_rng(3), (0.5, -1.0, 2.0), (0.0, 0.2, -0.1), process=False)
    ][600:]
    mean = np.mean(errors, axis=0)
    assert np.abs(mean[0]).max() < 0.004
    assert np.abs(mean[1]).max() < 0.004
    assert np.abs(mean[2]).max() < 0.01
    deviation = np.std(errors, axis=0)
    assert deviation[0].max() < 0.5 * math.sqrt(P.position_variance), "better than the samples"
    assert deviation[1].max() < 0.5 * math.sqrt(P.velocity_variance)


def flying(ticks, spoil=lambda tick, position, velocity: (position, velocity), skip=()):
    """A controller in flight whose odometry is a straight ramp with noise."""
    random = np.random.default_rng(5)
    made = MuController(1, CONTROL, UNIT)
    made.take_mission(launch(arm(Mission(8), (0.0, 0.0, -50.0), "nominal"), 0))
    made.aim((-12.0, -12.0, -50.0), "nominal")
    thrusts = []
    for tick in range(ticks):
        if tick in skip:
            continue
        position = np.array([0.0, 0.0, -2.0 * T * tick]) + random.normal(0.0, CONTROL.position_sigma_m, 3)
        velocity = np.array([0.0, 0.0, -2.0]) + random.normal(0.0, CONTROL.velocity_sigma_m_s, 3)
        # What the commands would do is taken back: this MU is towed.
        made._thrust[:] = (0.0, 0.0, 0.0)
        thrusts.append(made.on_odometry(tick * CONTROL.period_ns, *spoil(tick, position.tolist(), velocity.tolist())))
    return made, thrusts


def test_an_outlier_is_turned_away_and_counted():
    def wild(tick, position, velocity):
        return ([1e3, 0.0, 0.0], velocity) if tick == 100 else (position, velocity)

    plain, _ = flying(101)
    spoilt, _ = flying(101, wild)
    assert plain.statistics.outliers == 0
    assert spoilt.statistics.outliers == 1
    assert np.allclose(spoilt._state[:3], plain._state[:3], atol=0.05)


def test_a_true_jump_of_the_velocity_is_believed_after_a_few_samples():
    def snapped(tick, position, velocity):
        if tick < 100:
            return position, velocity
        return [position[0] + 0.5 * T * (tick - 100), *position[1:]], [velocity[0] + 0.5, *velocity[1:]]

    made, _ = flying(115, snapped)
    assert 1 <= made.statistics.outliers <= 6
    assert made._state[3] == pytest.approx(0.5, abs=0.1)


def test_a_gap_is_bridged_and_the_estimate_admits_it():
    whole, _ = flying(101)
    gap, _ = flying(101, skip=range(96, 100))
    assert gap.statistics.deadline_misses == 4
    assert gap.statistics.position_sigma_m > whole.statistics.position_sigma_m
    assert gap._state[2] == pytest.approx(-2.0 * T * 100, abs=0.08)
    assert gap.statistics.outliers == 0


def test_raw_samples_stay_available():
    made = MuController(1, load(ControlParameters, {"estimator": "raw"}), UNIT)
    made.take_mission(launch(arm(Mission(8), (0.0, 0.0, -50.0), "nominal"), 0))
    made.aim((-12.0, -12.0, -50.0), "nominal")
    made.on_odometry(0, (0.0, 0.0, -1.5), (0.1, 0.0, 0.0))
    made.on_odometry(CONTROL.period_ns, (0.3, 0.0, -1.5), (0.2, 0.0, 0.0))
    assert made._state[:6] == [0.3, 0.0, -1.5, 0.2, 0.0, 0.0]
    assert made.statistics.position_sigma_m == pytest.approx(CONTROL.position_sigma_m)
