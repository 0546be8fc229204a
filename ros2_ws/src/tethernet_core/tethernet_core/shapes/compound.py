"""The union of shapes: a bus with its panel, a stage with its nozzle."""

from __future__ import annotations

import functools
import hashlib
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ..rotation import matrix
from ..unit_norm import is_unit
from .registry import shape_from
from .shape import (
    LARGEST_M,
    Primitive,
    Shape,
    ShapeError,
    checked_number,
    checked_vector,
    entry_error,
    times,
    unknown_entries,
)
from .union_measure import exposed_share, own_share

MOST_PARTS = 64
"""Parts of one compound, nested ones counted by themselves."""
_SHARES_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Part:
    """A shape in its place in a compound."""

    shape: Shape
    position_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Of the part's origin in the compound's frame [m]."""
    attitude: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
    """Unit quaternion x y z w, part to compound."""
    mass_share: float | None = None
    """Of the compound's mass [-]; None: by its volume."""

    def __post_init__(self) -> None:
        """Check place and share.

        Raises:
            ShapeError: naming the entry.
        """
        if not isinstance(self.shape, Shape):
            raise entry_error("shape", self.shape, "no shape", "a shape")
        position = checked_vector("position_m", self.position_m, 3, -LARGEST_M, LARGEST_M, "m")
        attitude = checked_vector("attitude", self.attitude, 4, -1.0, 1.0, "")
        norm = math.sqrt(sum(q * q for q in attitude))
        if not is_unit(norm):
            raise entry_error(
                "attitude", self.attitude, f"of norm {norm:g}", "a unit quaternion x y z w, part to compound"
            )
        object.__setattr__(self, "position_m", position)
        object.__setattr__(self, "attitude", tuple(q / norm for q in attitude))
        if self.mass_share is not None:
            object.__setattr__(self, "mass_share", checked_number("mass_share", self.mass_share, 0.0, 1.0, ""))

    @functools.cached_property
    def position(self) -> np.ndarray:
        """Of the part's origin in the compound's frame [m], shape (3,)."""
        return np.array(self.position_m)

    @functools.cached_property
    def matrix(self) -> np.ndarray:
        """Part to compound, shape (3, 3)."""
        return matrix(self.attitude)

    def to_part(self, points: np.ndarray) -> np.ndarray:
        """Points of the compound's frame in the part's [m], shape (..., 3)."""
        return times(points - self.position, self.matrix)

    def to_compound(self, points: np.ndarray) -> np.ndarray:
        """Points of the part's frame in the compound's [m], shape (..., 3)."""
        return times(points, self.matrix.T) + self.position


@dataclass(frozen=True)
class Compound(Shape):
    """Parts that may touch and overlap.

    Surface, volume and area are the union's: outside, the distance is exact; inside it is that of the part in which the
    point is deepest, at most the depth in the union. Where bounding spheres overlap, volume and area are integrated
    numerically, to about a part in a thousand.

    Mass is the parts': each has its share of it, homogeneous within the part. Where no shares are given they are the
    parts' volumes, so that an overlap counts in each of its parts.
    """

    kind: ClassVar[str] = "compound"

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        """Check the parts together.

        Raises:
            ShapeError: for no parts, too many, or shares of mass that are given for a few only or do not sum to 1.
        """
        if not self.parts or len(self.primitives()) > MOST_PARTS:
            raise ShapeError(f"parts holds {len(self.primitives())} shapes; allowed: 1 to {MOST_PARTS}")
        given = [i for i, part in enumerate(self.parts) if part.mass_share is not None]
        if given and len(given) < len(self.parts):
            lacking = next(i for i in range(len(self.parts)) if i not in given)
            raise ShapeError(f"parts[{lacking}] lacks mass_share; allowed: mass_share in all parts or in none")
        total = sum(part.mass_share or 0.0 for part in self.parts)
        if given and abs(total - 1.0) > _SHARES_TOLERANCE:
            raise ShapeError(f"parts: their mass_share sum to {total:g}; allowed: 1")

    @classmethod
    def from_entries(cls, entries: Mapping[str, Any], folder: Path | None) -> Compound:
        unknown_entries(entries, ("parts",), cls.kind)
        allowed = "a list of {shape: {kind: ...}, position_m: [x, y, z], attitude: [x, y, z, w], mass_share: number}"
        listed = entries.get("parts")
        if not isinstance(listed, list | tuple) or not listed:
            raise entry_error("parts", listed, "no parts", allowed)
        parts = []
        for i, entry in enumerate(listed):
            name = f"parts[{i}]"
            if not isinstance(entry, Mapping):
                raise entry_error(name, entry, "no part", allowed)
            unknown = [key for key in entry if key not in ("shape", "position_m", "attitude", "mass_share")]
            if unknown:
                raise ShapeError(
                    f"{name} has no entry {str(unknown[0])[:60]!r}; it has: shape, position_m, attitude, mass_share"
                )
            if "shape" not in entry:
                raise ShapeError(f"{name} lacks shape; allowed: {{kind: ...}} and what that kind has")
            shape = shape_from(entry["shape"], folder=folder, where=f"{name}.shape")
            try:
                parts.append(Part(shape, **{key: value for key, value in entry.items() if key != "shape"}))
            except ShapeError as error:
                raise ShapeError(f"{name}.{error}") from error
        return cls(tuple(parts))

    def entries(self) -> dict[str, Any]:
        parts = []
        for part in self.parts:
            entry: dict[str, Any] = {"shape": part.shape.entries(), "position_m": list(part.position_m)}
            entry["attitude"] = list(part.attitude)
            if part.mass_share is not None:
                entry["mass_share"] = part.mass_share
            parts.append(entry)
        return {"kind": self.kind, "parts": parts}

    def primitives(self) -> list[Primitive]:
        return [
            Primitive(inner.shape, part.to_compound(inner.position), part.matrix @ inner.matrix)
            for part in self.parts
            for inner in part.shape.primitives()
        ]

    @property
    def numbers(self) -> np.ndarray:
        rows = []
        for part, share in zip(self.parts, self._shares, strict=True):
            rows += [part.position, part.attitude, [share], part.shape.numbers]
        return np.concatenate([np.asarray(row, float) for row in rows])

    @functools.cached_property
    def digest(self) -> str:
        kinds = " ".join(part.shape.kind + part.shape.digest for part in self.parts)
        return hashlib.sha256(kinds.encode() + self.numbers.astype("<f8").tobytes()).hexdigest()[:16]

    @functools.cached_property
    def _shares(self) -> np.ndarray:
        """Of the mass, shape (P,)."""
        if self.parts[0].mass_share is not None:
            return np.array([part.mass_share for part in self.parts])
        volumes = np.array([part.shape.volume_m3 for part in self.parts])
        return volumes / volumes.sum()

    @functools.cached_property
    def volume_m3(self) -> float:
        return sum(
            primitive.shape.volume_m3 * own_share(self.primitives(), i) for i, primitive in enumerate(self.primitives())
        )

    @functools.cached_property
    def area_m2(self) -> float:
        return sum(
            primitive.shape.area_m2 * exposed_share(self.primitives(), i)
            for i, primitive in enumerate(self.primitives())
        )

    @functools.cached_property
    def centroid(self) -> np.ndarray:
        """Centre of mass [m], shape (3,)."""
        return self._shares @ np.array([part.to_compound(part.shape.centroid) for part in self.parts])

    @functools.cached_property
    def inertia_per_mass(self) -> np.ndarray:
        inertia = np.zeros((3, 3))
        for part, share in zip(self.parts, self._shares, strict=True):
            arm = part.to_compound(part.shape.centroid) - self.centroid
            own = part.matrix @ part.shape.inertia_per_mass @ part.matrix.T
            inertia += share * (own + (arm @ arm) * np.eye(3) - np.outer(arm, arm))
        return 0.5 * (inertia + inertia.T)

    @functools.cached_property
    def extent_m(self) -> float:
        """Largest distance of two of its points [m], of corners of :meth:`triangles`: circles are polygons."""
        inner = max(part.shape.extent_m for part in self.parts)
        corners = [part.to_compound(part.shape.triangles()[0]) for part in self.parts]
        between = 0.0
        for a, b in itertools.combinations(corners, 2):
            for block in np.array_split(a, max(1, len(a) * len(b) // 1_000_000)):
                between = max(between, float(np.linalg.norm(block[:, None] - b[None], axis=-1).max()))
        return max(inner, between)

    def reach_from(self, point: np.ndarray) -> float:
        return max(part.shape.reach_from(part.to_part(np.asarray(point, float))) for part in self.parts)

    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        origin, directions = np.asarray(origin, float), np.asarray(directions, float)
        exits = [part.shape.ray_exit(part.to_part(origin), times(directions, part.matrix)) for part in self.parts]
        return np.max(exits, axis=0)

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """The triangles of all parts, each closed by itself; where parts overlap, some lie inside."""
        vertices, faces, count = [], [], 0
        for part in self.parts:
            corners, triangles = part.shape.triangles()
            vertices.append(part.to_compound(corners))
            faces.append(triangles + count)
            count += len(corners)
        return np.concatenate(vertices), np.concatenate(faces)

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        points = np.asarray(points, float)
        nearest, normals = np.full(points.shape[:-1], np.inf), np.zeros(points.shape)
        for part in self.parts:
            distance, normal = part.shape.distance(part.to_part(points))
            closer = distance < nearest
            nearest = np.where(closer, distance, nearest)
            normals = np.where(closer[..., None], times(normal, part.matrix.T), normals)
        return nearest, normals
