"""Prediction of a freely tumbling body."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tethernet_core.free_rotation import attitude_after
from tethernet_core.rotation import matrix
from tethernet_core.shapes import Cylinder

QUATERNION = np.array([0.1, -0.3, 0.2, math.sqrt(0.86)])
ATTITUDE = matrix(QUATERNION)
RATE = np.array([0.03, -0.05, 0.08])


def test_a_body_of_any_inertia_follows_eulers_equations():
    turn = matrix((0.5, 0.5, -0.5, 0.5)) @ matrix((0.0, 0.6, 0.0, 0.8))
    inertia = turn @ np.diag([2.0, 5.0, 6.0]) @ turn.T

    def euler(_, y):
        q, w = y[:4], y[4:]
        turning = 0.5 * np.concatenate([q[3] * w + np.cross(q[:3], w), [-q[:3] @ w]])
        return np.concatenate([turning, -np.linalg.solve(inertia, np.cross(w, inertia @ w))])

    start = np.concatenate([QUATERNION, ATTITUDE.T @ RATE])
    end = solve_ivp(euler, (0.0, 60.0), start, rtol=1e-12, atol=1e-13, method="DOP853").y[:, -1]
    attitude, rate = attitude_after(ATTITUDE, RATE, inertia, 1.0, 60.0)
    np.testing.assert_allclose(attitude, matrix(end[:4] / np.linalg.norm(end[:4])), atol=1e-7)
    np.testing.assert_allclose(attitude.T @ rate, end[4:], atol=1e-8)
    back, before = attitude_after(attitude, rate, inertia, 1.0, -60.0)
    np.testing.assert_allclose(back, ATTITUDE, atol=1e-12)
    np.testing.assert_allclose(before, RATE, atol=1e-12)


def test_the_closed_form_of_a_body_of_revolution_agrees_with_the_turns():
    inertia = 9000.0 * Cylinder(1.95, 11.1).inertia_per_mass
    exact = attitude_after(ATTITUDE, RATE, inertia, 9000.0, 30.0)
    # Hardly unsymmetric: the other way of computing.
    turns = attitude_after(ATTITUDE, RATE, inertia + np.diag([1e-3, 0.0, 0.0]), 9000.0, 30.0)
    np.testing.assert_allclose(turns[0], exact[0], atol=1e-7)
    np.testing.assert_allclose(turns[1], exact[1], atol=1e-8)


@pytest.mark.parametrize("moments", [(1.0, 2.0, 2.5), (2.0, 2.0, 1.0)])
def test_what_does_not_turn_stays(moments):
    attitude, rate = attitude_after(ATTITUDE, np.zeros(3), np.diag(moments), 1.0, 100.0)
    np.testing.assert_allclose(attitude, ATTITUDE, atol=1e-15)
    np.testing.assert_array_equal(rate, 0.0)
