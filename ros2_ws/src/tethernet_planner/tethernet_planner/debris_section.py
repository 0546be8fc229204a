"""The debris as the closing plan sees it: a body of known shape in some attitude, and the strings of net round it."""

from __future__ import annotations

import functools
import math

import numpy as np

from tethernet_core.shapes import Primitive
from tethernet_core.system import Debris

_OUTLINE = 65
"""Points of the outline, from the debris' front round one side to its back."""


@functools.lru_cache(maxsize=64)
def longest_axis(debris: Debris) -> np.ndarray:
    """The body axis of the least moment of inertia, unit vector, shape (3,): along what a debris is long."""
    inertia = debris.inertia
    if not (inertia - np.diag(np.diag(inertia))).any():
        return np.eye(3)[int(np.argmin(np.diag(inertia)))]
    return np.linalg.eigh(inertia)[1][:, 0]


class DebrisPose:
    """The debris in one attitude. All places are relative to its centre of mass, axes of the launch frame."""

    def __init__(self, debris: Debris, attitude: np.ndarray):
        """Args:
        debris: shape and centre of mass.
        attitude: rotation matrix, body to launch, shape (3, 3).
        """
        self._debris, self._attitude = debris, attitude
        self._parts = debris.shape.primitives()

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points from the surface [m], negative inside, shape (...).

        Args:
            points: [m], shape (..., 3).
        """
        in_shape = np.asarray(points, float) @ self._attitude + self._debris.center_of_mass
        return self._debris.shape.distance(in_shape)[0]

    def outline(self, sideways: np.ndarray) -> Outline:
        """What a row of the net is laid round on one side.

        Args:
            sideways: horizontal unit vector, shape (2,).
        """
        if len(self._parts) == 1 and np.array_equal(self._center(self._parts[0]), self._debris.center_of_mass):
            half_turn = np.linspace(0.0, math.pi, _OUTLINE)
            points = self._section(self._parts[0], sideways, half_turn)
            if _is_convex(points):
                return Outline(points, sideways)
        # Parts of a body may lie beside the plane through its middle: each is cut through its own centre instead.
        full_turn = np.linspace(0.0, 2.0 * math.pi, 2 * _OUTLINE - 1)[:-1]
        sections = []
        for part in self._parts:
            offset = self._attitude @ (self._center(part) - self._debris.center_of_mass)
            beside = np.array([offset[:2] @ sideways, offset[2]])
            sections.append(beside + self._section(part, sideways, full_turn))
        return Outline(_one_side(np.concatenate([*sections, np.zeros((1, 2))])), sideways)

    def _section(self, part: Primitive, sideways: np.ndarray, angle: np.ndarray) -> np.ndarray:
        """Where rays from a part's centroid leave it, (sideways, z) [m], shape (K, 2); angles from the front [rad]."""
        sine, cosine = np.sin(angle), np.cos(angle)
        rays = np.stack([sine * sideways[0], sine * sideways[1], cosine], axis=1)
        distance = part.shape.exit_distance(rays @ self._attitude @ part.matrix)
        return np.stack([sine * distance, cosine * distance], axis=1)

    @staticmethod
    def _center(part: Primitive) -> np.ndarray:
        """A part's centroid in the frame of the whole shape [m], shape (3,)."""
        return part.position + part.matrix @ part.shape.centroid


class Outline:
    """A convex curve round one side of the debris, in the plane of the approach (z) and one sideways direction."""

    def __init__(self, points: np.ndarray, sideways: np.ndarray):
        """Args:
        points: from front (+z) to back, (sideways, z) relative to the centre of mass [m], shape (K, 2).
        sideways: horizontal unit vector, shape (2,).
        """
        self.sideways = sideways
        self.points = points
        # The string leaves the outline at the first edge whose outer side the target lies on: cross product of edge and
        # target above that of edge and the edge's own line.
        self._edge_x, self._edge_z = np.diff(self.points, axis=0).T
        self._level = self._edge_x * self.points[:-1, 1] - self._edge_z * self.points[:-1, 0]
        self._arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))])

    def path_length(self, targets: np.ndarray) -> np.ndarray:
        """Length of a string from the debris' front round this side to each target [m], shape (T,).

        Args:
            targets: relative to the debris' centre of mass [m], shape (T, 3).
        """
        flat = np.stack([targets[:, :2] @ self.sideways, targets[:, 2]], axis=1)
        beside = targets[:, 0] * self.sideways[1] - targets[:, 1] * self.sideways[0]
        outer = self._edge_x * flat[:, 1:] - self._edge_z * flat[:, :1] > self._level
        leaves = np.where(outer.any(axis=1), outer.argmax(axis=1), len(self.points) - 1)
        length = self._arc[leaves] + np.linalg.norm(flat - self.points[leaves], axis=1)
        return np.hypot(length, beside)


def _is_convex(points: np.ndarray) -> bool:
    """Whether a curve from front to back turns one way only, but for rounding."""
    edges = np.diff(points, axis=0)
    turn = edges[:-1, 0] * edges[1:, 1] - edges[:-1, 1] * edges[1:, 0]
    return bool((turn <= 1e-9 * float(np.abs(points).max()) ** 2).all())


def _one_side(points: np.ndarray) -> np.ndarray:
    """The convex hull of points, (sideways, z), as far as it lies on the positive side, from front to back, (K, 2)."""
    upper, lower = (_chain(points[np.lexsort((side * points[:, 1], points[:, 0]))], side) for side in (-1.0, 1.0))
    front, back = (float(np.interp(0.0, chain[:, 0], chain[:, 1])) for chain in (upper, lower))
    return np.concatenate([[(0.0, front)], upper[upper[:, 0] > 0.0], lower[lower[:, 0] > 0.0][::-1], [(0.0, back)]])


def _chain(points: np.ndarray, side: float) -> np.ndarray:
    """The upper (side -1) or lower (side 1) chain of the hull of points sorted by their first coordinate."""
    chain: list[np.ndarray] = []
    for point in points:
        while len(chain) > 1:
            (ax, az), (bx, bz) = chain[-2], chain[-1]
            if side * ((bx - ax) * (point[1] - az) - (bz - az) * (point[0] - ax)) > 0.0:
                break
            chain.pop()
        chain.append(point)
    hull = np.array(chain)
    return hull[: int(hull[:, 0].argmax()) + 1]  # without the edge down the far end, which is in both chains
