"""How a body turns that no torque acts on: attitude and angular rate some time ahead.

The angular momentum stays in the frame of the launch. The rotation of a body without symmetry is split into turns about
its principal axes, each of which is exact, and composed to the fourth order: attitudes stay attitudes, and energy stays
within a bound, however long the motion lasts. The arithmetic of these turns is plain, so that the simulator compiles
the same functions.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tethernet_core.rotation import Quaternion, matrix, product, quaternion_of, turned

_SYMMETRY = 1e-9
"""Two principal moments are equal to this share of the largest one."""
LARGEST_TURN = 0.02
"""Turn of one composed step at the most [rad]: its error is of the fifth power."""
_OUTER = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))
COMPOSITION = (_OUTER, _OUTER, 1.0 - 4.0 * _OUTER, _OUTER, _OUTER)
"""Shares of a step in Suzuki's composition of the fourth order (Phys. Lett. A 146, 1990)."""

Vector = tuple[float, float, float]


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
    """A vector turned by a rotation vector, both of shape (3,), the rotation in rad."""
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return vector
    x, y, z = (float(component) for component in math.sin(0.5 * angle) / angle * turn)
    return np.array(turned((x, y, z, math.cos(0.5 * angle)), vector))


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


def turn_about(
    ex: float, ey: float, ez: float, angle: float, attitude: Quaternion, momentum: Vector
) -> tuple[Quaternion, Vector]:
    """Turn a body about an axis of its own.

    Args:
        ex: x of the unit axis in the body frame.
        ey: y of it.
        ez: z of it.
        angle: [rad].
        attitude: quaternion x y z w, body to launch.
        momentum: angular momentum in the body frame, which the body turns away from.

    Returns:
        Attitude and momentum afterwards.
    """
    sine, cosine = math.sin(0.5 * angle), math.cos(0.5 * angle)
    ax, ay, az = ex * sine, ey * sine, ez * sine
    return product(attitude, (ax, ay, az, cosine)), turned((-ax, -ay, -az, cosine), momentum)


def turn_about_principal(
    axes: Any, rates: Any, i: int, duration: float, attitude: Quaternion, momentum: Vector
) -> tuple[Quaternion, Vector]:
    """Turn about principal axis ``i`` alone, as fast as the momentum along it says; see :func:`symmetric_step`."""
    ex, ey, ez = axes[i, 0], axes[i, 1], axes[i, 2]
    mx, my, mz = momentum
    return turn_about(ex, ey, ez, duration * rates[i] * (ex * mx + ey * my + ez * mz), attitude, momentum)


def symmetric_step(
    axes: Any, rates: Any, duration: float, attitude: Quaternion, momentum: Vector
) -> tuple[Quaternion, Vector]:
    """Turns about the principal axes one after the other, and back: of the second order in the duration.

    Args:
        axes: the principal axes in the body frame, in rows, shape (3, 3).
        rates: over one moment of inertia about each [1 / (kg m^2)], shape (3,).
        duration: [s].
        attitude: quaternion x y z w, body to launch.
        momentum: angular momentum in the body frame [N m s].

    Returns:
        Attitude and momentum afterwards.
    """
    half = 0.5 * duration
    attitude, momentum = turn_about_principal(axes, rates, 0, half, attitude, momentum)
    attitude, momentum = turn_about_principal(axes, rates, 1, half, attitude, momentum)
    attitude, momentum = turn_about_principal(axes, rates, 2, duration, attitude, momentum)
    attitude, momentum = turn_about_principal(axes, rates, 1, half, attitude, momentum)
    return turn_about_principal(axes, rates, 0, half, attitude, momentum)


def _any_body_after(
    attitude: np.ndarray, rate: np.ndarray, inertia: np.ndarray, duration: float
) -> tuple[np.ndarray, np.ndarray]:
    """Turns about the principal axes, see :func:`symmetric_step`, composed to the fourth order."""
    moments, columns = np.linalg.eigh(inertia)
    axes, rates = columns.T, 1.0 / moments
    kept = attitude @ inertia @ attitude.T @ rate
    x, y, z = (float(component) for component in attitude.T @ kept)
    parts = max(1, math.ceil(math.hypot(x, y, z) * float(rates.max()) * abs(duration) / LARGEST_TURN))
    quaternion, momentum = quaternion_of(attitude), (x, y, z)
    for _ in range(parts):
        for share in COMPOSITION:
            quaternion, momentum = symmetric_step(axes, rates, share * duration / parts, quaternion, momentum)
    norm = math.sqrt(sum(component * component for component in quaternion))
    after = matrix([component / norm for component in quaternion])
    return after, after @ ((axes @ (after.T @ kept) * rates) @ axes)
