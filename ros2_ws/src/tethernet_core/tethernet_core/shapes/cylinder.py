"""A circular cylinder, its axis the z axis, its centre the origin."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .arithmetic import larger, magnitude, root, select
from .shape import Shape, dimension, interval_exit, norm, principal, quadratic, slab
from .tessellation import revolved


def surface(p: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any, Any]:
    """Signed distance of a point from the cylinder [m], negative inside, and the outward unit normal there.

    Args:
        p: radius and half length [m].
        x: of the point [m].
        y: of the point [m].
        z: of the point, along the axis [m].
    """
    radius, half_length = p[0], p[1]
    squared = x * x + y * y
    inverse = 1.0 / root(larger(squared, 1e-300))
    side, flat = squared * inverse - radius, magnitude(z) - half_length
    # Inside, the nearer of side and end counts, outside what sticks out.
    nearer = larger(side, flat)
    outside = nearer > 0.0
    radial = select(outside, larger(side, 0.0), select(side > flat, 1.0, 0.0))
    axial = select(outside, larger(flat, 0.0), select(side > flat, 0.0, 1.0))
    length = root(radial * radial + axial * axial)
    share = 1.0 / length
    axial, radial = select(z >= 0.0, axial, -axial) * share, radial * share * inverse
    return select(outside, length, nearer), radial * x, radial * y, axial


@dataclass(frozen=True)
class Cylinder(Shape):
    """A circular cylinder round the z axis."""

    kind: ClassVar[str] = "cylinder"
    axisymmetric: ClassVar[bool] = True

    radius_m: float = dimension("radius")
    length_m: float = dimension("length along z")

    @property
    def numbers(self) -> np.ndarray:
        return np.array([self.radius_m, 0.5 * self.length_m])

    @property
    def volume_m3(self) -> float:
        return math.pi * self.radius_m**2 * self.length_m

    @property
    def area_m2(self) -> float:
        return 2.0 * math.pi * self.radius_m * (self.radius_m + self.length_m)

    @property
    def inertia_per_mass(self) -> np.ndarray:
        across = (3.0 * self.radius_m**2 + self.length_m**2) / 12.0
        return principal(across, across, 0.5 * self.radius_m**2)

    @property
    def extent_m(self) -> float:
        return norm(2.0 * self.radius_m, self.length_m)

    def reach_from(self, point: np.ndarray) -> float:
        x, y, z = (float(c) for c in point)
        return norm(norm(x, y) + self.radius_m, abs(z) + 0.5 * self.length_m)

    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        o, d = np.asarray(origin, float), np.asarray(directions, float)
        if not o.any():
            # From the centre: the nearer of side and end.
            along = d[..., 2]
            across = np.sqrt(np.maximum(1.0 - along**2, 1e-12))
            return np.minimum(self.radius_m / across, 0.5 * self.length_m / np.maximum(np.abs(along), 1e-12))
        low, high = slab(o[2], d[..., 2], 0.5 * self.length_m)
        dx, dy = d[..., 0], d[..., 1]
        enter, leave = quadratic(
            dx * dx + dy * dy, o[0] * dx + o[1] * dy, o[0] ** 2 + o[1] ** 2 - self.radius_m**2 + np.zeros_like(dx)
        )
        return interval_exit(np.maximum(low, enter), np.minimum(high, leave))

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        r, h = self.radius_m, 0.5 * self.length_m
        return revolved(np.array([[0.0, -h], [r, -h], [r, h], [0.0, h]]))
