"""A free rigid body of any inertia: what is conserved, and how fast it flips."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from tethernet_core.rotation import matrix, rotate
from tethernet_core.shapes import Box, Compound, Cone, Cylinder, Part
from tethernet_sim.debris import body_momentum, body_rate, debris_body, inertia_tensor
from tethernet_sim.kernels import debris_body as debris

BOX = debris_body(Box((1.0, 2.0, 3.0)), 600.0)
TURNED = debris_body(
    Compound((Part(Box((1.0, 2.0, 3.0)), (0.5, 0.0, 0.0), (0.5, 0.5, -0.5, 0.5)), Part(Box((4.0, 0.2, 0.5))))), 600.0
)
BODIES = {"box": BOX, "compound": TURNED}


@numba.njit
def drift(body, state, rotation, duration):
    debris.drift(body, state, rotation, duration)


@numba.njit
def steps(body, state, rotation, duration, count):
    for _ in range(count):
        debris.step(body, state, rotation, duration)


@numba.njit
def rate_of(body, state, rotation, output):
    debris.rate(body, state, rotation, output)


ATTITUDE = (0.1, -0.3, 0.2, math.sqrt(0.86))


def state_of(body, rate) -> tuple[np.ndarray, np.ndarray]:
    state = np.zeros(13)
    state[3:6], state[6:10] = (0.1, 0.2, -0.3), ATTITUDE
    state[10:] = rotate(state[6:10], body_momentum(body, np.array(rate)))
    return state, matrix(state[6:10])


def energy(body, state) -> float:
    momentum = matrix(state[6:10]).T @ state[10:]
    return 0.5 * float(momentum @ body_rate(body, momentum))


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_momentum_stays_exactly_and_energy_within_a_bound(body):
    state, rotation = state_of(body, (0.4, 0.6, -0.3))
    momentum, start = state[10:].copy(), energy(body, state)
    changes = []
    for _ in range(2000):  # 2000 s, some 200 turns
        drift(body, state, rotation, 1.0)
        changes.append(energy(body, state) / start - 1.0)
    np.testing.assert_array_equal(state[10:], momentum)
    np.testing.assert_array_equal(rotation, matrix(state[6:10]))
    assert np.abs(changes).max() < 1e-9
    assert abs(np.mean(changes[-500:]) - np.mean(changes[:500])) < 1e-11, "it does not drift"
    np.testing.assert_allclose(state[:3], np.array([0.1, 0.2, -0.3]) * 2000.0)


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_it_follows_eulers_equations(body):
    inertia, rate = inertia_tensor(body), np.array([0.3, 0.5, -0.2])
    state, rotation = state_of(body, rate)

    def euler(_, y):
        q, w = y[:4], y[4:]
        turning = 0.5 * np.concatenate([q[3] * w + np.cross(q[:3], w), [-q[:3] @ w]])
        return np.concatenate([turning, -np.linalg.solve(inertia, np.cross(w, inertia @ w))])

    begin = np.concatenate([state[6:10], rate])
    reference = solve_ivp(euler, (0.0, 40.0), begin, rtol=1e-12, atol=1e-13, method="DOP853").y[:, -1]
    other, turned = state.copy(), rotation.copy()
    drift(body, state, rotation, 40.0)
    assert abs(state[6:10] @ reference[:4]) == pytest.approx(1.0, abs=1e-12)
    got = np.zeros(3)
    rate_of(body, state, rotation, got)
    np.testing.assert_allclose(rotation.T @ got, reference[4:], atol=1e-7)
    # In steps of the integration the same.
    steps(body, other, turned, 1.25e-4, 320_000)
    assert abs(other[6:10] @ reference[:4]) == pytest.approx(1.0, abs=1e-12)


def test_the_flip_of_the_intermediate_axis_takes_what_the_elliptic_integral_says():
    """Dzhanibekov: spun about its middle axis and hardly disturbed, the body turns over again and again."""
    a, b, c = sorted(np.diag(inertia_tensor(BOX)))
    # Box sides 1, 2, 3: x has the largest moment, z the smallest.
    rate = np.array([1e-3, 1.0, 0.0])
    state, rotation = state_of(BOX, rate)
    twice_energy = c * rate[0] ** 2 + b * rate[1] ** 2
    squared = (c * rate[0]) ** 2 + (b * rate[1]) ** 2
    # Landau and Lifshitz, Mechanics, section 37, for L^2 > 2 E b: half a period is from one flip to the next.
    assert squared > twice_energy * b
    period = 4.0 * math.sqrt(a * b * c / ((c - b) * (squared - twice_energy * a)))
    modulus = (b - a) * (twice_energy * c - squared) / ((c - b) * (squared - twice_energy * a))
    period *= ellipk(modulus)
    crossings, before, step = [], None, 0.01
    for i in range(round(2.2 * period / step)):
        drift(BOX, state, rotation, step)
        about = float((rotation.T @ state[10:])[1])
        if before is not None and before * about < 0.0:
            crossings.append((i + before / (before - about)) * step)
        before = about
    assert len(crossings) >= 4
    np.testing.assert_allclose(np.diff(crossings), 0.5 * period, rtol=1e-6)


def test_a_body_of_revolution_in_the_general_form_moves_as_in_its_own():
    exact = debris_body(Cylinder(1.0, 4.0), 300.0)
    general = debris_body(Compound((Part(Cylinder(1.0, 4.0)),)), 300.0)
    state, rotation = state_of(exact, (0.2, -0.1, 0.5))
    other, turned = state.copy(), rotation.copy()
    drift(exact, state, rotation, 30.0)
    drift(general, other, turned, 30.0)
    np.testing.assert_allclose(other, state, atol=1e-9)
    np.testing.assert_allclose(turned, rotation, atol=1e-9)


def test_a_body_at_rest_stays():
    state, rotation = state_of(BOX, (0.0, 0.0, 0.0))
    before = state.copy()
    drift(BOX, state, rotation, 2.0)
    np.testing.assert_allclose(state[:3], [0.2, 0.4, -0.6])
    np.testing.assert_array_equal(state[3:], before[3:])


def test_rate_and_momentum_are_each_others_inverse():
    rate = np.array([[0.1, -0.2, 0.3], [1.0, 0.0, 0.0]])
    for body in (BOX, TURNED, debris_body(Cylinder(1.0, 4.0), 300.0)):
        np.testing.assert_allclose(body_momentum(body, rate), rate @ inertia_tensor(body), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(body_rate(body, body_momentum(body, rate)), rate, atol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mass": 0.0}, "mass_kg = 0: not positive"),
        ({"inertia": np.diag([1.0, 1.0, 3.0])}, "principal moments 1, 1, 3 kg m.2, which no body has"),
        ({"inertia": np.diag([1.0, -1.0, 1.0])}, "which no body has"),
        ({"inertia": np.array([[1.0, 0.2, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])}, "not symmetric"),
        ({"inertia": np.eye(2)}, "not 3 x 3"),
        ({"center_of_mass": np.array([9.0, 0.0, 0.0])}, "center_of_mass_m = .*allowed: less than its reach"),
    ],
)
def test_a_body_that_cannot_be_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        debris_body(Cone(1.0, 2.0), **({"mass": 1.0} | arguments))
