"""How a body turns that no torque acts on: attitude and angular rate some time ahead."""

from __future__ import annotations

import math

import numpy as np

from tethernet_core.rotation import matrix, quaternion_of

_SYMMETRY = 1e-9
"""Two principal moments are equal to this share of the largest one."""
_STEP_RAD = 0.1
"""The integration turns a body no further in one step; its error is then some 1e-7 rad a radian."""


def attitude_after(
    attitude: np.ndarray, rate: np.ndarray, inertia: np.ndarray, mass: float, duration: float
) -> tuple[np.ndarray, np.ndarray]:
    """Attitude and angular rate of a free rigid body after ``duration``.

    The angular momentum stays. A body whose inertia is the same all round its z axis turns round the angular momentum
    and, beside that, round its own axis, both steadily: exact. Any other is integrated.

    Args:
        attitude: rotation matrix, body to launch, shape (3, 3).
        rate: angular rate now, frame launch [rad/s], shape (3,).
        inertia: about the centre of mass, body axes [kg m^2], shape (3, 3).
        mass: [kg].
        duration: [s].

    Returns:
        Rotation matrix, shape (3, 3), and angular rate, frame launch [rad/s], shape (3,).
    """
    if round_z(inertia):
        return _round_body_after(attitude, rate, inertia, mass, duration)
    return _any_body_after(attitude, rate, inertia, duration)


def round_z(inertia: np.ndarray) -> bool:
    """Whether an inertia tensor is the same all round the body's z axis."""
    scale = _SYMMETRY * float(np.abs(inertia).max())
    diagonal = np.diag(inertia)
    return bool(np.abs(inertia - np.diag(diagonal)).max() <= scale and abs(float(diagonal[0] - diagonal[1])) <= scale)


def turned_by(vector: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """A vector turned by a rotation vector (Rodrigues' formula), both of shape (3,), the rotation in rad."""
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return vector
    u = turn / angle
    cosine, sine = math.cos(angle), math.sin(angle)
    return vector * cosine + np.cross(u, vector) * sine + u * float(u @ vector) * (1.0 - cosine)


def _round_body_after(
    attitude: np.ndarray, rate: np.ndarray, inertia: np.ndarray, mass: float, duration: float
) -> tuple[np.ndarray, np.ndarray]:
    axis = attitude[:, 2].copy()
    twelfth = 12.0 / mass  # moments so scaled are sums of squared dimensions, for boxes and cylinders
    ratio = (float(inertia[2, 2]) * twelfth) / (float(inertia[0, 0]) * twelfth)
    spin = float(rate @ axis)
    along = spin * axis
    turn = (rate - along + ratio * along) * duration  # angular momentum over the moment across the axis
    own = (1.0 - ratio) * spin * duration * axis
    x, y = (turned_by(turned_by(attitude[:, i].copy(), own), turn) for i in range(2))
    return np.stack([x, y, turned_by(axis, turn)], axis=1), turned_by(rate, turn)


def _any_body_after(
    attitude: np.ndarray, rate: np.ndarray, inertia: np.ndarray, duration: float
) -> tuple[np.ndarray, np.ndarray]:
    """Runge and Kutta's fourth order on the attitude alone, because the angular momentum is known."""
    momentum = attitude @ inertia @ attitude.T @ rate
    inverse = np.linalg.inv(inertia)
    fastest = float(np.linalg.norm(momentum)) * float(np.linalg.norm(inverse, 2))
    steps = max(1, math.ceil(fastest * abs(duration) / _STEP_RAD))
    step = duration / steps

    def slope(q: np.ndarray) -> np.ndarray:
        now = matrix(q / math.sqrt(float(q @ q)))
        wx, wy, wz = inverse @ (now.T @ momentum)
        x, y, z, w = q
        return 0.5 * np.array(
            [
                w * wx + y * wz - z * wy,
                w * wy + z * wx - x * wz,
                w * wz + x * wy - y * wx,
                -x * wx - y * wy - z * wz,
            ]
        )

    q = np.array(quaternion_of(attitude))
    for _ in range(steps):
        first = slope(q)
        second = slope(q + 0.5 * step * first)
        third = slope(q + 0.5 * step * second)
        fourth = slope(q + step * third)
        q = q + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        q /= math.sqrt(float(q @ q))
    after = matrix(q)
    return after, after @ (inverse @ (after.T @ momentum))
