"""Debris and chaser as free rigid bodies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.physics import coast, make_world
from tethernet_sim import audit
from tethernet_sim.kernels import rigid_body
from tethernet_sim.state import ATTITUDE, DEBRIS, MOMENTUM


def test_torque_free_debris_keeps_momentum_and_energy():
    world = make_world(8, rate=(0.08, -0.03, 0.2))
    momentum = world.state.bodies[0, DEBRIS, MOMENTUM].copy()
    energy = audit.kinetic_energy(world.model, world.state)[0]
    for _ in coast(world, 800):  # 40 s
        pass
    assert np.array_equal(world.state.bodies[0, DEBRIS, MOMENTUM], momentum)
    assert audit.kinetic_energy(world.model, world.state)[0] == pytest.approx(energy, rel=1e-12)
    assert np.linalg.norm(world.state.bodies[0, DEBRIS, ATTITUDE]) == pytest.approx(1.0, abs=1e-12)


def test_tumbling_follows_eulers_equations():
    rate = np.array([0.08, -0.03, 0.2])
    world = make_world(8, rate=rate)
    across, along = world.model.debris.across, world.model.debris.along
    inertia = np.array([across, across, along])

    def euler(_, y):
        q, w = y[:4], y[4:]
        axis, scalar = q[:3], q[3]
        turning = 0.5 * np.concatenate([scalar * w + np.cross(axis, w), [-axis @ w]])
        return np.concatenate([turning, -np.cross(w, inertia * w) / inertia])

    start = np.concatenate([world.state.bodies[0, DEBRIS, ATTITUDE], rate])
    reference = solve_ivp(euler, (0.0, 20.0), start, rtol=1e-11, atol=1e-13).y[:4, -1]
    for _ in coast(world, 400):
        pass
    got = world.state.bodies[0, DEBRIS, ATTITUDE]
    assert abs(got @ reference) == pytest.approx(1.0, abs=1e-10)


def test_inertia_is_that_of_a_cylinder_and_a_cube():
    numbers, debris = make_world(8).model.numbers, make_world(8).model.debris
    assert debris.along == pytest.approx(0.5 * 9000.0 * 1.95**2)
    assert debris.across == pytest.approx(9000.0 * (3 * 1.95**2 + 11.1**2) / 12.0)
    assert numbers.chaser_inertia == pytest.approx(1600.0 * 1.5**2 / 6.0)


def test_the_cheap_step_is_the_exact_drift():
    exact, cheap = np.zeros(13), np.zeros(13)
    exact[3:6], exact[9], exact[10:13] = (1.0, -2.0, 0.5), 1.0, (3e3, -5e3, 2e3)
    cheap[:] = exact
    matrix, other = np.eye(3), np.eye(3)
    for _ in range(8000):
        rigid_body.small_rotation_step(cheap, other, 9e4, 1.7e4, 1.25e-4)
    rigid_body.drift_body(exact, matrix, 9e4, 1.7e4, 1.0)
    assert np.allclose(cheap, exact, atol=1e-11)
    assert np.allclose(other, matrix, atol=1e-11)
