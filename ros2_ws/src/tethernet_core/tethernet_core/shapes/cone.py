"""A cone or truncated cone round the z axis, the origin half way between base (below) and top."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .arithmetic import larger, root, select, smaller
from .shape import Shape, dimension, norm, principal
from .tessellation import revolved

_TOUCHING = 1e-9
"""Nearer than this [m] the way to the nearest point is too short to give a direction."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact to the seventh power: r^4 and r^2 z^2 are of the fourth


def surface(p: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any, Any]:
    """Signed distance of a point from the cone [m], negative inside, and the outward unit normal there.

    Args:
        p: radius of base and top, half length [m].
        x: of the point [m].
        y: of the point [m].
        z: of the point, along the axis [m].
    """
    base, top, half = p[0], p[1], p[2]
    squared = x * x + y * y
    x = select(squared < 1e-200, 1e-100, x)  # the axis has no side: x is as good as any
    squared = larger(squared, 1e-200)
    across = root(squared)
    # In the half plane of the point: the side goes from (base, -half) to (top, half).
    slope, length = top - base, 2.0 * half
    inverse = 1.0 / root(slope * slope + length * length)
    side_n, side_m = length * inverse, -slope * inverse  # outward normal of the side
    side = (across - base) * side_n + (z + half) * side_m
    along = ((across - base) * slope + (z + half) * length) * inverse * inverse
    share = smaller(larger(along, 0.0), 1.0)
    side_r, side_z = across - (base + share * slope), z + half - share * length
    under, over = -half - z, z - half
    under_r, over_r = larger(across - base, 0.0), larger(across - top, 0.0)
    # Squared distance of the nearest point of side, base and top.
    to_side = side_r * side_r + side_z * side_z
    to_base = under_r * under_r + under * under
    to_top = over_r * over_r + over * over
    nearest = smaller(to_side, smaller(to_base, to_top))
    on_side = to_side == nearest
    on_top = (to_top == nearest) & (to_side > nearest)
    inside = larger(side, larger(under, over)) <= 0.0
    distance = root(nearest)
    # The face's normal; outside the way from the nearest point, which differs at a rim.
    face_r = select(on_side, side_n, 0.0)
    face_z = select(on_side, side_m, select(on_top, 1.0, -1.0))
    way = 1.0 / larger(distance, _TOUCHING)
    way_r = select(on_side, side_r, select(on_top, over_r, under_r)) * way
    way_z = select(on_side, side_z, select(on_top, over, -under)) * way
    facing = inside | (distance < _TOUCHING)
    radial = select(facing, face_r, way_r) / across
    return select(inside, -distance, distance), radial * x, radial * y, select(facing, face_z, way_z)


@dataclass(frozen=True)
class Cone(Shape):
    """A cone round the z axis that narrows, or widens, from base to top; with a top radius of 0 it has a tip."""

    kind: ClassVar[str] = "cone"
    axisymmetric: ClassVar[bool] = True

    base_radius_m: float = dimension("radius of the base, at the lower end")
    length_m: float = dimension("length along z")
    top_radius_m: float = dimension("radius of the top, at the upper end; 0: a tip", low=0.0, default=0.0)

    @property
    def numbers(self) -> np.ndarray:
        return np.array([self.base_radius_m, self.top_radius_m, 0.5 * self.length_m])

    def _mean(self, power: int, moment: int) -> float:
        """Mean of radius**power z**moment over the length."""
        radius = 0.5 * (self.base_radius_m * (1.0 - _NODES) + self.top_radius_m * (1.0 + _NODES))
        return float(0.5 * _WEIGHTS @ (radius**power * (0.5 * self.length_m * _NODES) ** moment))

    @property
    def volume_m3(self) -> float:
        return math.pi * self.length_m * self._mean(2, 0)

    @property
    def area_m2(self) -> float:
        a, b = self.base_radius_m, self.top_radius_m
        return math.pi * (a * a + b * b + (a + b) * norm(self.length_m, a - b))

    @property
    def centroid(self) -> np.ndarray:
        return np.array([0.0, 0.0, self._mean(2, 1) / self._mean(2, 0)])

    @property
    def inertia_per_mass(self) -> np.ndarray:
        section = self._mean(2, 0)
        along = 0.5 * self._mean(4, 0) / section
        across = 0.5 * along + self._mean(2, 2) / section - (self._mean(2, 1) / section) ** 2
        return principal(across, across, along)

    @property
    def extent_m(self) -> float:
        a, b = self.base_radius_m, self.top_radius_m
        return max(2.0 * a, 2.0 * b, norm(a + b, self.length_m))

    def reach_from(self, point: np.ndarray) -> float:
        x, y, z = (float(c) for c in point)
        half = 0.5 * self.length_m
        return max(norm(norm(x, y) + r, z - at) for r, at in ((self.base_radius_m, -half), (self.top_radius_m, half)))

    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        o, d = np.asarray(origin, float), np.asarray(directions, float)
        half = 0.5 * self.length_m
        slope = (self.top_radius_m - self.base_radius_m) / self.length_m
        middle = 0.5 * (self.top_radius_m + self.base_radius_m) + slope * o[2]
        dx, dy, dz = d[..., 0], d[..., 1], d[..., 2]
        near = 1e-12 * (1.0 + abs(o).max() + half)
        farthest = np.zeros(d.shape[:-1])
        with np.errstate(divide="ignore", invalid="ignore"):
            for radius, z in ((self.base_radius_m, -half), (self.top_radius_m, half)):
                t = (z - o[2]) / dz
                on_it = np.hypot(o[0] + t * dx, o[1] + t * dy) <= radius + near
                farthest = np.where(on_it & (t > farthest), t, farthest)
            # |across|^2 = radius(z)^2 along the ray; the second branch of the quadratic serves the flat ones.
            a = dx * dx + dy * dy - (slope * dz) ** 2
            b = o[0] * dx + o[1] * dy - middle * slope * dz
            c = o[0] ** 2 + o[1] ** 2 - middle**2
            spread = np.sqrt(b * b - a * c)
            q = -(b + np.where(b >= 0.0, spread, -spread))
            for t in (q / a, c / q):
                z = o[2] + t * dz
                on_it = (np.abs(z) <= half + near) & (middle + slope * t * dz >= -near)
                farthest = np.where(on_it & (t > farthest), t, farthest)
        return farthest

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        a, b, h = self.base_radius_m, self.top_radius_m, 0.5 * self.length_m
        top = [[b, h], [0.0, h]] if b > 0.0 else [[0.0, h]]
        return revolved(np.array([[0.0, -h], [a, -h], *top]))
