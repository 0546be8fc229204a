"""A rectangular box, its sides along the axes, its centre the origin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .arithmetic import larger, magnitude, root, select
from .shape import Shape, dimension, interval_exit, norm, principal, slab
from .tessellation import cuboid


def surface(p: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any, Any]:
    """Signed distance of a point from the box [m], negative inside, and the outward unit normal there.

    Args:
        p: half sides along x, y and z [m].
        x: of the point [m].
        y: of the point [m].
        z: of the point [m].
    """
    ex, ey, ez = magnitude(x) - p[0], magnitude(y) - p[1], magnitude(z) - p[2]
    nearest = larger(ex, larger(ey, ez))
    outside = nearest > 0.0
    # Inside, the nearest side counts alone, outside what sticks out.
    on_x = ex == nearest
    on_y = (ey == nearest) & (ex < nearest)
    nx = select(outside, larger(ex, 0.0), select(on_x, 1.0, 0.0))
    ny = select(outside, larger(ey, 0.0), select(on_y, 1.0, 0.0))
    nz = select(outside, larger(ez, 0.0), select(on_x | on_y, 0.0, 1.0))
    length = root(nx * nx + ny * ny + nz * nz)
    share = 1.0 / length
    return (
        select(outside, length, nearest),
        select(x >= 0.0, nx, -nx) * share,
        select(y >= 0.0, ny, -ny) * share,
        select(z >= 0.0, nz, -nz) * share,
    )


@dataclass(frozen=True)
class Box(Shape):
    """A rectangular box."""

    kind: ClassVar[str] = "box"

    size_m: tuple[float, ...] = dimension("sides along x, y and z", count=3)

    @property
    def numbers(self) -> np.ndarray:
        return 0.5 * np.array(self.size_m)

    @property
    def volume_m3(self) -> float:
        x, y, z = self.size_m
        return x * y * z

    @property
    def area_m2(self) -> float:
        x, y, z = self.size_m
        return 2.0 * (x * y + y * z + z * x)

    @property
    def inertia_per_mass(self) -> np.ndarray:
        x, y, z = (side**2 / 12.0 for side in self.size_m)
        return principal(y + z, z + x, x + y)

    @property
    def extent_m(self) -> float:
        return norm(*self.size_m)

    def reach_from(self, point: np.ndarray) -> float:
        return float(np.linalg.norm(np.abs(point) + self.numbers))

    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        o, d = np.asarray(origin, float), np.asarray(directions, float)
        spans = [slab(o[axis], d[..., axis], half) for axis, half in enumerate(self.numbers)]
        enter = np.maximum(np.maximum(spans[0][0], spans[1][0]), spans[2][0])
        leave = np.minimum(np.minimum(spans[0][1], spans[1][1]), spans[2][1])
        return interval_exit(enter, leave)

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        return cuboid(self.numbers)
