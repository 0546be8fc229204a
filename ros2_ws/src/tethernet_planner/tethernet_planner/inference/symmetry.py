"""The mirror symmetries that net and debris share.

The square net looks the same after a rotation by 90 degrees or a reflection; the cylinder, its long axis along the
diagonal (1, 1, 0), only after a half turn about z, a reflection at that diagonal, or both. Numbering of knots and MUs
aside, a mission and its image have the same statistics (the sensor noise is isotropic).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tethernet_core.layout import design


@dataclass(frozen=True)
class Symmetry:
    """(x, y) to sign * (y, x) if ``swap``, else to sign * (x, y); z stays."""

    swap: bool
    sign: int

    def vectors(self, vectors: np.ndarray) -> np.ndarray:
        """Images of vectors, shape (..., 2 or more): x and y first, the rest stays."""
        image = np.array(vectors)
        image[..., 0] = self.sign * vectors[..., 1 if self.swap else 0]
        image[..., 1] = self.sign * vectors[..., 0 if self.swap else 1]
        return image

    def permutation(self, places: np.ndarray) -> np.ndarray:
        """Which point comes to lie on each place.

        Args:
            places: points in the net's plane that are mapped onto each other, shape (P, 2).

        Returns:
            ``source``, shape (P,): the image of point ``source[i]`` is point ``i``.

        Raises:
            ValueError: when an image falls on no place.
        """
        distance = np.linalg.norm(self.vectors(places)[None, :, :] - places[:, None, :], axis=-1)
        source = distance.argmin(axis=1)
        if distance[np.arange(len(places)), source].max() > 1e-9:
            raise ValueError("these points are not mapped onto each other")
        return source


IDENTITY = Symmetry(False, 1)
GROUP = (IDENTITY, Symmetry(False, -1), Symmetry(True, 1), Symmetry(True, -1))
"""All four; each is its own inverse."""


@functools.cache
def mu_permutation(symmetry: Symmetry, mu_count: int) -> np.ndarray:
    """Which MU comes to lie on each MU's place, shape (M,)."""
    return symmetry.permutation(np.array(design(mu_count).nominal_offsets))


def canonical(debris_position: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], Symmetry]:
    """The image of a debris position in one quarter of the plane, x >= abs(y).

    Returns:
        The image [m], shape (3,), and the symmetry that leads to it, and from it back.
    """
    position = np.asarray(debris_position, float)
    for symmetry in GROUP:
        image = symmetry.vectors(position)
        if image[0] >= abs(image[1]):
            return image, symmetry
    raise ValueError(f"debris position {position.tolist()}: allowed: finite numbers")


def image_of_offsets(symmetry: Symmetry, offsets: np.ndarray) -> np.ndarray:
    """Offsets of the MUs' aiming points [m], shape (M, 2), in the image."""
    return symmetry.vectors(offsets)[mu_permutation(symmetry, len(offsets))]
