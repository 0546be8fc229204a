"""Images of a mission: reflections and rotations of the net's plane that map a system onto itself.

Numbering of nodes and units aside, a mission and its image have the same statistics (the sensor noise is isotropic).
Which images a system has is found where models are trained; models carry theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

TOLERANCE = 1e-9
"""Points this near to each other, relative to the farthest one, are the same."""

_EQUAL_M = 1e-9  # [m]: of two images of a position


class NotMappedError(ValueError):
    """Points are not mapped onto each other."""


@dataclass(frozen=True)
class Symmetry:
    """An orthogonal map of x and y; z stays."""

    matrix: tuple[tuple[float, float], tuple[float, float]]
    """Rows of the matrix."""
    units: tuple[int, ...]
    """Which unit comes to lie on each unit's place, from 0, M of them."""

    def vectors(self, vectors: np.ndarray) -> np.ndarray:
        """Images of vectors, shape (..., 2 or more): x and y first, the rest stays."""
        (a, b), (c, d) = self.matrix
        x, y = vectors[..., 0], vectors[..., 1]
        image = np.array(vectors)
        image[..., 0] = a * x + b * y
        image[..., 1] = c * x + d * y
        return image

    def permutation(self, places: np.ndarray) -> np.ndarray:
        """Which point comes to lie on each place.

        Args:
            places: points in the net's plane that are mapped onto each other [m], shape (P, 2).

        Returns:
            ``source``, shape (P,): the image of point ``source[i]`` is point ``i``.

        Raises:
            NotMappedError: when an image falls on no place.
        """
        images = self.vectors(places)
        limit = TOLERANCE * max(float(np.abs(places).max(initial=0.0)), 1.0)
        source = np.empty(len(places), np.int64)
        for i, place in enumerate(places):
            distance = np.hypot(*(images - place).T)
            source[i] = distance.argmin()
            if distance[source[i]] > limit:
                raise NotMappedError("these points are not mapped onto each other")
        return source

    def offsets(self, offsets: np.ndarray) -> np.ndarray:
        """Offsets of the units' aiming points [m], shape (M, 2), in the image."""
        return self.vectors(offsets)[list(self.units)]

    @property
    def inverse(self) -> Symmetry:
        """What leads back."""
        (a, b), (c, d) = self.matrix
        return Symmetry(((a, c), (b, d)), tuple(int(i) for i in np.argsort(self.units)))

    def as_json(self) -> dict[str, Any]:
        """What JSON can hold."""
        return {"matrix": [list(row) for row in self.matrix], "units": list(self.units)}

    @classmethod
    def from_json(cls, content: Any) -> Symmetry:
        """What :meth:`as_json` gave.

        Raises:
            ValueError, TypeError, KeyError: when it is something else.
        """
        (a, b), (c, d) = content["matrix"]
        units = tuple(int(unit) for unit in content["units"])
        made = cls(((float(a), float(b)), (float(c), float(d))), units)
        matrix = np.array(made.matrix)
        if not np.allclose(matrix @ matrix.T, np.eye(2)) or sorted(units) != list(range(len(units))):
            raise ValueError(f"{content} is no reflection or rotation with a permutation of units")
        return made


def identity(unit_count: int) -> Symmetry:
    """The map that leaves everything where it is."""
    return Symmetry(((1.0, 0.0), (0.0, 1.0)), tuple(range(unit_count)))


def canonical(position: Sequence[float], images: Sequence[Symmetry]) -> tuple[np.ndarray, Symmetry]:
    """The image of a position that stands for all: the one with the largest x, and of these the largest y.

    Args:
        position: [m], shape (3,).
        images: all maps, the identity included.

    Returns:
        The image [m], shape (3,), and the first map that leads to it.

    Raises:
        ValueError: for a position that is not finite.
    """
    place = np.asarray(position, float)
    if not np.isfinite(place).all():
        raise ValueError(f"position {position}: allowed: finite numbers")
    moved = np.array([image.vectors(place) for image in images])
    near = moved[:, 0] >= moved[:, 0].max() - _EQUAL_M
    near &= moved[:, 1] >= moved[near, 1].max() - _EQUAL_M
    first = int(np.argmax(near))
    return moved[first], images[first]
