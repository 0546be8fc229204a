"""What every shape of a rigid body offers: signed distance, rays, mass properties, triangles."""

from __future__ import annotations

import abc
import dataclasses
import functools
import hashlib
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

SMALLEST_M, LARGEST_M = 1e-3, 1e3
"""Allowed dimensions of a body [m]."""


class ShapeError(ValueError):
    """A shape's description is wrong: which entry, what it holds, what is allowed."""


class Primitive(NamedTuple):
    """A shape with a distance function of its own, placed in the frame of the body that it is part of."""

    shape: Shape
    position: np.ndarray  # (3,) of the primitive's origin [m]
    matrix: np.ndarray  # (3, 3) primitive's frame to the body's


def dimension(
    description: str, *, low: float = SMALLEST_M, high: float = LARGEST_M, count: int = 1, default: Any = None
) -> Any:
    """Describe a dataclass field as a length of a shape, or as ``count`` lengths [m]."""
    metadata = {"description": description, "unit": "m", "low": low, "high": high, "count": count}
    return dataclasses.field(metadata=metadata, default=dataclasses.MISSING if default is None else default)


def entry_error(name: str, value: Any, problem: str, allowed: str) -> ShapeError:
    """An error that names the entry, what it holds and what is allowed."""
    text = repr(value)
    text = text if len(text) <= 60 else text[:57] + "..."
    return ShapeError(f"{name} = {text}: {problem}; allowed: {allowed}")


def checked_number(name: str, value: Any, low: float, high: float, unit: str) -> float:
    """A finite number within its range.

    Raises:
        ShapeError: naming the entry.
    """
    allowed = f"{low:g} to {high:g} {unit}".rstrip()
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise entry_error(name, value, "not a number", allowed)
    if not low <= value <= high:  # NaN is not
        raise entry_error(name, value, "out of range", allowed)
    return float(value)


def checked_vector(name: str, value: Any, count: int, low: float, high: float, unit: str) -> tuple[float, ...]:
    """``count`` finite numbers within their range.

    Raises:
        ShapeError: naming the entry.
    """
    if not isinstance(value, list | tuple | np.ndarray) or len(value) != count:
        raise entry_error(
            name, value, f"not {count} numbers", f"a list of {count} numbers, each {low:g} to {high:g} {unit}"
        )
    return tuple(checked_number(f"{name}[{i}]", item, low, high, unit) for i, item in enumerate(value))


class Shape(abc.ABC):
    """The surface of a closed body in a frame of its own.

    A shape is a frozen dataclass in a file named after its ``kind``. Beside it that file holds ``surface(p, x, y, z)``:
    signed distance of a point and outward unit normal there, as ``(distance, nx, ny, nz)``, from the shape's
    :attr:`numbers` ``p``. It is written with :mod:`.arithmetic`, serves arrays here, and is compiled by the simulator.
    """

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]
    kind: ClassVar[str]
    """The word for it in a description."""
    axisymmetric: ClassVar[bool] = False
    """Whether it is a body of revolution round its z axis through the centroid."""
    convex: ClassVar[bool] = True
    """Whether the distance along any straight line has one minimum; what is made of primitives, has theirs."""

    def __post_init__(self) -> None:
        """Check all dimensions.

        Raises:
            ShapeError: naming the field.
        """
        for field in dataclasses.fields(self):
            meta = field.metadata
            if "count" not in meta:
                continue
            value = getattr(self, field.name)
            if meta["count"] == 1:
                value = checked_number(field.name, value, meta["low"], meta["high"], meta["unit"])
            else:
                value = checked_vector(field.name, value, meta["count"], meta["low"], meta["high"], meta["unit"])
            object.__setattr__(self, field.name, value)

    @classmethod
    def from_entries(cls, entries: Mapping[str, Any], folder: Path | None) -> Shape:
        """Make the shape from the entries of its description, its kind left out.

        Args:
            entries: the description.
            folder: where files that it names are, if their names are relative.

        Raises:
            ShapeError: naming the entry and what is allowed.
        """
        del folder
        fields = {f.name: f for f in dataclasses.fields(cls) if f.init}
        unknown_entries(entries, fields, cls.kind)
        missing = [name for name, field in fields.items() if name not in entries and not _has_default(field)]
        if missing:
            raise ShapeError(f"a {cls.kind} lacks {', '.join(missing)}; it has: {', '.join(fields)}")
        return cls(**entries)

    def entries(self) -> dict[str, Any]:
        """The description that makes this shape, with its kind."""
        values = {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.init}
        return {"kind": self.kind} | {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()}

    @property
    @abc.abstractmethod
    def numbers(self) -> np.ndarray:
        """What ``surface`` needs of this shape, shape (K,)."""

    @property
    @abc.abstractmethod
    def volume_m3(self) -> float:
        """Volume [m^3]."""

    @property
    @abc.abstractmethod
    def area_m2(self) -> float:
        """Area of the surface [m^2]."""

    @property
    def centroid(self) -> np.ndarray:
        """Centre of mass of the homogeneous body [m], shape (3,); the origin unless a shape says otherwise."""
        return np.zeros(3)

    @property
    @abc.abstractmethod
    def inertia_per_mass(self) -> np.ndarray:
        """Inertia tensor of the homogeneous body about its centroid over its mass [m^2], shape (3, 3)."""

    @property
    @abc.abstractmethod
    def extent_m(self) -> float:
        """Largest distance of two of its points [m]."""

    @abc.abstractmethod
    def reach_from(self, point: np.ndarray) -> float:
        """Distance of its farthest point from a point of its frame, shape (3,) [m]."""

    @property
    def reach_m(self) -> float:
        """Distance of its farthest point from the centroid [m]."""
        return self.reach_from(self.centroid)

    @abc.abstractmethod
    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Where rays leave the body for good.

        Args:
            origin: of all rays [m], shape (3,).
            directions: unit vectors, shape (..., 3).

        Returns:
            Distance of the farthest surface point along each ray [m], 0 where it meets none, shape (...).
        """

    @abc.abstractmethod
    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """A closed surface for pictures: vertices [m], shape (V, 3), and faces, counter-clockwise from outside, (F, 3).

        Vertices are on the true surface; a circle is a polygon.
        """

    def exit_distance(self, directions: np.ndarray) -> np.ndarray:
        """Distance of the farthest surface point along rays from the centroid [m]; directions (..., 3) are unit."""
        return self.ray_exit(self.centroid, directions)

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance of points and the outward normal of the nearest surface.

        Args:
            points: in the shape's frame [m], shape (..., 3).

        Returns:
            Distances [m], negative inside, shape (...); unit normals, shape (..., 3).
        """
        points = np.asarray(points, float)
        surface = sys.modules[type(self).__module__].surface
        distance, *normal = surface(self.numbers, points[..., 0], points[..., 1], points[..., 2])
        return np.asarray(distance), np.stack(np.broadcast_arrays(*normal), axis=-1)

    def primitives(self) -> list[Primitive]:
        """The shapes with a distance function of their own that this one is the union of."""
        return [Primitive(self, np.zeros(3), np.eye(3))]

    @functools.cached_property
    def digest(self) -> str:
        """Equal for equal shapes, 16 hexadecimal digits."""
        return hashlib.sha256(self.kind.encode() + np.asarray(self.numbers, "<f8").tobytes()).hexdigest()[:16]


def unknown_entries(entries: Mapping[str, Any], allowed: Any, kind: str) -> None:
    """Refuse entries that a shape does not have.

    Raises:
        ShapeError: naming the entry and all allowed ones.
    """
    for name in entries:
        if name not in allowed:
            raise ShapeError(f"a {kind} has no entry {str(name)[:60]!r}; it has: {', '.join(allowed)}")


def interval_exit(enter: np.ndarray, leave: np.ndarray) -> np.ndarray:
    """Where rays leave a convex body that they are in from ``enter`` to ``leave``; 0 where they miss it."""
    return np.where((enter <= leave) & (leave > 0.0), leave, 0.0)


def slab(position: np.ndarray, direction: np.ndarray, half: float) -> tuple[np.ndarray, np.ndarray]:
    """Where rays enter and leave |coordinate| <= half, from the coordinate of origin and direction."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (-half - position) / direction, (half - position) / direction
    parallel = direction == 0.0
    inside = np.abs(position) <= half
    enter = np.where(parallel, np.where(inside, -np.inf, np.inf), np.minimum(a, b))
    leave = np.where(parallel, np.where(inside, np.inf, -np.inf), np.maximum(a, b))
    return enter, leave


def quadratic(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where a t^2 + 2 b t + c is not above 0, for a not below 0: from, to; from above to where it never is."""
    parallel = a <= 1e-300
    safe = np.where(parallel, 1.0, a)
    inner = b * b - a * c
    spread = np.sqrt(np.maximum(inner, 0.0))
    missed = np.where(parallel, c > 0.0, inner < 0.0)
    enter = np.where(parallel, -np.inf, (-b - spread) / safe)
    leave = np.where(parallel, np.inf, (-b + spread) / safe)
    return np.where(missed, np.inf, enter), np.where(missed, -np.inf, leave)


def times(vectors: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """``vectors @ matrix`` for vectors (..., 3), to the same bits however many there are: not as BLAS."""
    return vectors[..., 0:1] * matrix[0] + vectors[..., 1:2] * matrix[1] + vectors[..., 2:3] * matrix[2]


def principal(x: float, y: float, z: float) -> np.ndarray:
    """A diagonal tensor, shape (3, 3)."""
    return np.diag([x, y, z])


def _has_default(field: dataclasses.Field[Any]) -> bool:
    return field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING


def norm(*components: float) -> float:
    """Length of a vector."""
    return math.hypot(*components)
