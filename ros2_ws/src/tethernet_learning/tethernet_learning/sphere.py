"""The debris' attitude and the direction of one of its axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def attitude_along(direction: np.ndarray, axis: Sequence[float] = (0.0, 0.0, 1.0)) -> tuple[float, float, float, float]:
    """The attitude that turns the body's axis into a direction by the shortest way.

    Args:
        direction: unit vector, frame launch, shape (3,).
        axis: unit vector, body frame.

    Returns:
        Unit quaternion x y z w, body to launch.
    """
    from scipy.spatial.transform import Rotation

    rotation, _ = Rotation.align_vectors([direction], [axis])
    return tuple(rotation.as_quat(canonical=True).tolist())


def random_attitude(random: np.random.Generator) -> tuple[float, float, float, float]:
    """An attitude drawn evenly from all: unit quaternion x y z w."""
    quaternion = random.normal(size=4)
    return tuple((quaternion / np.linalg.norm(quaternion)).tolist())


def axes_of(attitudes: np.ndarray, axis: Sequence[float]) -> np.ndarray:
    """The directions of an axis of debris, signed so that z is not negative.

    Args:
        attitudes: unit quaternions x y z w, body to launch, shape (n, 4).
        axis: unit vector, body frame.

    Returns:
        Unit vectors, frame launch, shape (n, 3).
    """
    from scipy.spatial.transform import Rotation

    axes = Rotation.from_quat(attitudes).apply(axis)
    return np.where(axes[:, 2:] < 0.0, -axes, axes)


def in_launch_frame(attitudes: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors of the debris' body frame in the frame launch; shapes (n, 4), (n, 3) and (n, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(attitudes).apply(vectors)


def equal_area(axes: np.ndarray) -> np.ndarray:
    """Lambert's equal-area projection of the hemisphere z >= 0 on the unit disc, z in the middle.

    Args:
        axes: unit vectors, shape (n, 3).

    Returns:
        x and y on the disc, shape (n, 2).
    """
    return axes[:, :2] / np.sqrt(1.0 + axes[:, 2:])


def from_equal_area(points: np.ndarray) -> np.ndarray:
    """The reverse of :func:`equal_area`: shape (n, 2) in, (n, 3) out; NaN outside the disc."""
    square = np.sum(points**2, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        axes = np.hstack([points * np.sqrt(2.0 - square), 1.0 - square])
    return np.where(square <= 1.0, axes, np.nan)
