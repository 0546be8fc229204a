"""A sphere round the origin."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .arithmetic import root, select
from .shape import Shape, dimension, interval_exit, principal, quadratic
from .tessellation import revolved


def surface(p: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any, Any]:
    """Signed distance of a point from the sphere [m], negative inside, and the outward unit normal there.

    Args:
        p: radius [m].
        x: of the point [m].
        y: of the point [m].
        z: of the point [m].
    """
    # The centre has no nearest point: x is as good as any.
    x = select(x * x + y * y + z * z < 1e-200, 1e-100, x)
    length = root(x * x + y * y + z * z)
    share = 1.0 / length
    return length - p[0], x * share, y * share, z * share


@dataclass(frozen=True)
class Sphere(Shape):
    """A sphere."""

    kind: ClassVar[str] = "sphere"
    axisymmetric: ClassVar[bool] = True

    radius_m: float = dimension("radius")

    @property
    def numbers(self) -> np.ndarray:
        return np.array([self.radius_m])

    @property
    def volume_m3(self) -> float:
        return 4.0 / 3.0 * math.pi * self.radius_m**3

    @property
    def area_m2(self) -> float:
        return 4.0 * math.pi * self.radius_m**2

    @property
    def inertia_per_mass(self) -> np.ndarray:
        same = 0.4 * self.radius_m**2
        return principal(same, same, same)

    @property
    def extent_m(self) -> float:
        return 2.0 * self.radius_m

    def reach_from(self, point: np.ndarray) -> float:
        return float(np.linalg.norm(point)) + self.radius_m

    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        o, d = np.asarray(origin, float), np.asarray(directions, float)
        ones = np.ones(d.shape[:-1])
        return interval_exit(*quadratic(ones, d @ o, (float(o @ o) - self.radius_m**2) * ones))

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        angle = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 33)
        profile = self.radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        profile[[0, -1], 0] = 0.0
        return revolved(profile)
