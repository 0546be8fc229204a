"""The debris as the closing plan sees it: a cylinder of known size that tumbles freely."""

from __future__ import annotations

import math

import numpy as np

_OUTLINE = 65
"""Points of the outline, from the debris' front round one side to its back."""


def axis_after(axis: np.ndarray, rate: np.ndarray, duration: float, radius: float, length: float) -> np.ndarray:
    """The long axis of a freely tumbling cylinder after ``duration``: it circles round the angular momentum.

    Args:
        axis: unit vector now, shape (3,).
        rate: angular rate now [rad/s], shape (3,).
        duration: [s].
        radius: of the cylinder [m].
        length: of the cylinder [m].
    """
    return tumbled(axis, axis, rate, duration, radius, length)


def tumbled(
    vector: np.ndarray, axis: np.ndarray, rate: np.ndarray, duration: float, radius: float, length: float
) -> np.ndarray:
    """A vector that circles round the angular momentum of a freely tumbling cylinder as its long axis does: that axis
    itself, or the angular rate.

    Args:
        vector: now, shape (3,).
        axis: the long axis now, unit vector, shape (3,).
        rate: angular rate now [rad/s], shape (3,).
        duration: [s].
        radius: of the cylinder [m].
        length: of the cylinder [m].
    """
    inertia_ratio = 6.0 * radius**2 / (3.0 * radius**2 + length**2)  # along the axis over across it
    along = float(rate @ axis) * axis
    turn = (rate - along + inertia_ratio * along) * duration
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return vector
    u = turn / angle
    cosine, sine = math.cos(angle), math.sin(angle)
    return vector * cosine + np.cross(u, vector) * sine + u * float(u @ vector) * (1.0 - cosine)


class Outline:
    """Section of the debris through its centre, in the plane of the approach (z) and one sideways direction: what a row
    of the net is laid round.
    """

    def __init__(self, axis: np.ndarray, sideways: np.ndarray, radius: float, half_length: float):
        """Args:
        axis: unit vector of the long axis, shape (3,).
        sideways: horizontal unit vector, shape (2,).
        radius: of the cylinder, clearance included [m].
        half_length: likewise [m].
        """
        angle = np.linspace(0.0, math.pi, _OUTLINE)
        rays = np.stack([np.sin(angle) * sideways[0], np.sin(angle) * sideways[1], np.cos(angle)], axis=1)
        along = rays @ axis
        across = np.sqrt(np.maximum(1.0 - along**2, 1e-12))
        distance = np.minimum(radius / across, half_length / np.maximum(np.abs(along), 1e-12))
        self.sideways = sideways
        self.points = np.stack([np.sin(angle) * distance, np.cos(angle) * distance], axis=1)
        """From front (+z) to back, (sideways, z) [m], shape (K, 2)."""
        # The string leaves the outline at the first edge whose outer side the target lies on: cross product of edge and
        # target above that of edge and the edge's own line.
        self._edge_x, self._edge_z = np.diff(self.points, axis=0).T
        self._level = self._edge_x * self.points[:-1, 1] - self._edge_z * self.points[:-1, 0]
        self._arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))])

    def path_length(self, targets: np.ndarray) -> np.ndarray:
        """Length of a string from the debris' front round this side to each target [m], shape (T,).

        Args:
            targets: relative to the debris' centre [m], shape (T, 3).
        """
        flat = np.stack([targets[:, :2] @ self.sideways, targets[:, 2]], axis=1)
        beside = targets[:, 0] * self.sideways[1] - targets[:, 1] * self.sideways[0]
        outer = self._edge_x * flat[:, 1:] - self._edge_z * flat[:, :1] > self._level
        leaves = np.where(outer.any(axis=1), outer.argmax(axis=1), _OUTLINE - 1)
        length = self._arc[leaves] + np.linalg.norm(flat - self.points[leaves], axis=1)
        return np.hypot(length, beside)


def gap(points: np.ndarray, axis: np.ndarray, radius: float, half_length: float) -> np.ndarray:
    """Distance of points from the surface of a cylinder [m], negative inside.

    Args:
        points: relative to its centre [m], shape (..., 3).
        axis: unit vector of its long axis, shape (3,).
        radius: [m].
        half_length: [m].
    """
    along = points @ axis
    across = np.sqrt(np.maximum((points * points).sum(axis=-1) - along**2, 0.0))
    side, end = across - radius, np.abs(along) - half_length
    return np.where((side > 0.0) & (end > 0.0), np.hypot(side, end), np.maximum(side, end))
