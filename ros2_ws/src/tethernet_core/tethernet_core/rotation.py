"""Rotations by unit quaternions x y z w, child (body) to parent (launch): the one place where they are written down.

The arithmetic is plain, so that the same functions serve single numbers, arrays and, compiled, the physics kernels.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

NORM_TOLERANCE = 1e-3
"""[-] A quaternion in a message whose norm is further from 1 is no attitude (all zeros: it was never filled)."""

Quaternion = tuple[float, float, float, float]


def unit(attitude: Quaternion) -> Quaternion:
    """A quaternion that is nearly of norm 1, made exactly so.

    Args:
        attitude: x y z w.

    Raises:
        ValueError: when its norm is not 1 within :data:`NORM_TOLERANCE`, or not finite.
    """
    x, y, z, w = attitude
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(norm - 1.0) <= NORM_TOLERANCE:  # also catches NaN
        raise ValueError(
            f"attitude quaternion ({x:g}, {y:g}, {z:g}, {w:g}) has norm {norm:g}; allowed: 1 within {NORM_TOLERANCE:g}"
        )
    return (x / norm, y / norm, z / norm, w / norm)


def turned(attitude: Any, vector: Any) -> tuple[Any, Any, Any]:
    """Components x y z, in the parent's frame, of a vector given in the child's.

    Args:
        attitude: the four components of a unit quaternion, single numbers or arrays.
        vector: the three components of the vector, likewise.
    """
    x, y, z, w = attitude
    vx, vy, vz = vector
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + (y * tz - z * ty),
        vy + w * ty + (z * tx - x * tz),
        vz + w * tz + (x * ty - y * tx),
    )


def product(second: Any, first: Any) -> tuple[Any, Any, Any, Any]:
    """The rotation that turns as ``first`` does and then as ``second`` does: the four components x y z w of each,
    single numbers or arrays.
    """
    x, y, z, w = second
    fx, fy, fz, fw = first
    return (
        w * fx + x * fw + y * fz - z * fy,
        w * fy - x * fz + y * fw + z * fx,
        w * fz + x * fy - y * fx + z * fw,
        w * fw - x * fx - y * fy - z * fz,
    )


def rotate(attitude: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Vectors in the parent's frame from vectors in the child's.

    Args:
        attitude: unit quaternions, shape (..., 4).
        vector: shape (..., 3).

    Returns:
        Shape (..., 3).
    """
    components = turned(np.moveaxis(attitude, -1, 0), np.moveaxis(vector, -1, 0))
    return np.stack(components, axis=-1)


def inverse(attitude: np.ndarray) -> np.ndarray:
    """The opposite rotations, parent to child, shape (..., 4)."""
    return attitude * np.array([-1.0, -1.0, -1.0, 1.0])


def entries(x: float, y: float, z: float, w: float) -> tuple[float, ...]:
    """The nine entries of the rotation matrix of a unit quaternion, row by row."""
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


def matrix(attitude: Any) -> np.ndarray:
    """Rotation matrix of one unit quaternion, shape (3, 3)."""
    x, y, z, w = (float(value) for value in attitude)
    return np.array(entries(x, y, z, w)).reshape(3, 3)


def quaternion_of(rotation: Any) -> Quaternion:
    """Unit quaternion x y z w of a rotation matrix, shape (3, 3), its largest component positive."""
    m = np.asarray(rotation, float)
    trace = float(m[0, 0] + m[1, 1] + m[2, 2])
    # Four times the squares of the components; the largest one is taken as divisor.
    squares = [1.0 + 2.0 * float(m[i, i]) - trace for i in range(3)] + [1.0 + trace]
    largest = squares.index(max(squares))
    double = math.sqrt(squares[largest])  # twice that component
    if largest == 3:
        off = (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1])
        x, y, z = (0.5 * float(value) / double for value in off)
        return (x, y, z, 0.5 * double)
    i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
    components = [0.0, 0.0, 0.0]
    components[i] = 0.5 * double
    components[j] = 0.5 * float(m[j, i] + m[i, j]) / double
    components[k] = 0.5 * float(m[k, i] + m[i, k]) / double
    return (components[0], components[1], components[2], 0.5 * float(m[k, j] - m[j, k]) / double)
