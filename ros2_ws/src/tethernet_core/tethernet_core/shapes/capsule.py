"""A cylinder round the z axis with a half sphere on each end, its centre the origin."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .arithmetic import larger, root, select, smaller
from .cylinder import Cylinder
from .shape import SMALLEST_M, Shape, ShapeError, dimension, norm, principal
from .sphere import Sphere
from .tessellation import revolved


def surface(p: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any, Any]:
    """Signed distance of a point from the capsule [m], negative inside, and the outward unit normal there.

    Args:
        p: radius and half length of the cylinder between the half spheres [m].
        x: of the point [m].
        y: of the point [m].
        z: of the point, along the axis [m].
    """
    beyond = z - smaller(larger(z, -p[1]), p[1])
    # The axis has no nearest point: x is as good as any direction.
    x = select(x * x + y * y + beyond * beyond < 1e-200, 1e-100, x)
    length = root(x * x + y * y + beyond * beyond)
    share = 1.0 / length
    return length - p[0], x * share, y * share, beyond * share


@dataclass(frozen=True)
class Capsule(Shape):
    """A capsule round the z axis."""

    kind: ClassVar[str] = "capsule"
    axisymmetric: ClassVar[bool] = True

    radius_m: float = dimension("radius of the cylinder and of its two half spheres")
    length_m: float = dimension("length along z, half spheres included")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.length_m < 2.0 * self.radius_m:
            raise ShapeError(
                f"length_m = {self.length_m:g}: shorter than its two half spheres; "
                f"allowed: at least 2 radius_m = {2.0 * self.radius_m:g} m"
            )

    @property
    def _straight(self) -> float:
        """Length of the cylinder between the half spheres [m]."""
        return self.length_m - 2.0 * self.radius_m

    @property
    def numbers(self) -> np.ndarray:
        return np.array([self.radius_m, 0.5 * self._straight])

    @property
    def volume_m3(self) -> float:
        return math.pi * self.radius_m**2 * (self._straight + 4.0 / 3.0 * self.radius_m)

    @property
    def area_m2(self) -> float:
        return 2.0 * math.pi * self.radius_m * self.length_m

    @property
    def inertia_per_mass(self) -> np.ndarray:
        r, straight = self.radius_m, self._straight
        cylinder = straight / (straight + 4.0 / 3.0 * r)
        caps = 1.0 - cylinder
        # A half sphere's centroid is 3/8 r from its base.
        across = cylinder * (r * r / 4.0 + straight**2 / 12.0) + caps * (
            0.4 * r * r + 0.25 * straight**2 + 3.0 / 8.0 * r * straight
        )
        return principal(across, across, cylinder * 0.5 * r * r + caps * 0.4 * r * r)

    @property
    def extent_m(self) -> float:
        return self.length_m

    def reach_from(self, point: np.ndarray) -> float:
        x, y, z = (float(c) for c in point)
        return norm(x, y, abs(z) + 0.5 * self._straight) + self.radius_m

    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        # The farthest exit of the pieces that it is the union of.
        o, end = np.asarray(origin, float), np.array([0.0, 0.0, 0.5 * self._straight])
        ball = Sphere(self.radius_m)
        exits = np.maximum(ball.ray_exit(o - end, directions), ball.ray_exit(o + end, directions))
        if self._straight < SMALLEST_M:
            return exits
        return np.maximum(exits, Cylinder(self.radius_m, self._straight).ray_exit(o, directions))

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        angle = np.linspace(0.0, 0.5 * math.pi, 17)
        cap = self.radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        cap[-1, 0] = 0.0
        upper = cap + np.array([0.0, 0.5 * self._straight])
        lower = (upper * np.array([1.0, -1.0]))[::-1]
        return revolved(np.concatenate([lower, upper if self._straight > 0.0 else upper[1:]]))
