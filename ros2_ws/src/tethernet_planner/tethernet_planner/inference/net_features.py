"""What a surrogate sees of the net at the start of closing (paper, section II.E).

Nodes in this order: the knots of the square rings 0 (the rim), 4 and 9, each from its corner at row and column 0 along
the columns and round, 88 + 56 + 16 knots [A; three loops are P]; the central knot; the MUs, MU 1 first. That makes
165 or 169 nodes and, six numbers each, 990 or 1014 inputs [P].
"""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt

from tethernet_core.layout import KNOT_ROWS, design
from tethernet_planner.inference.symmetry import Symmetry

RINGS = (0, 4, 9)
"""Square rings of knots, 0 the rim."""

RING_KNOTS = tuple(4 * (KNOT_ROWS - 1 - 2 * ring) for ring in RINGS)
"""Knots in each of RINGS: 88, 56, 16."""

NUMBERS = 6
"""Per node: x y z [m] and their rates [m/s], relative to the debris' centre of mass, axes of frame launch."""

_MIDDLE = KNOT_ROWS // 2


@functools.cache
def knot_places() -> np.ndarray:
    """(row, column) of the ring knots and the central knot, shape (161, 2)."""
    places = []
    for ring in RINGS:
        low, high = ring, KNOT_ROWS - 1 - ring
        places += [(low, c) for c in range(low, high)] + [(r, high) for r in range(low, high)]
        places += [(high, c) for c in range(high, low, -1)] + [(r, low) for r in range(high, low, -1)]
    return np.array([*places, (_MIDDLE, _MIDDLE)])


@functools.cache
def _knot_indices() -> np.ndarray:
    return knot_places() @ np.array([KNOT_ROWS, 1])


def node_count(mu_count: int) -> int:
    """Nodes seen: 165 or 169."""
    return len(knot_places()) + design(mu_count).mu_count


def feature_count(mu_count: int) -> int:
    """Numbers seen: 990 or 1014."""
    return NUMBERS * node_count(mu_count)


def features(
    knot_positions: np.ndarray,
    knot_velocities: np.ndarray,
    mu_positions: np.ndarray,
    mu_velocities: np.ndarray,
    debris_position: npt.ArrayLike,
    debris_velocity: npt.ArrayLike,
) -> npt.NDArray[np.float32]:
    """The inputs of a surrogate.

    Args:
        knot_positions: [m], shape (529, 3), row by row.
        knot_velocities: [m/s], shape (529, 3).
        mu_positions: [m], shape (M, 3).
        mu_velocities: [m/s], shape (M, 3).
        debris_position: centre of mass [m].
        debris_velocity: of the centre of mass [m/s].

    Returns:
        float32, shape (990,) or (1014,): x y z vx vy vz of each node.
    """
    chosen = _knot_indices()
    position = np.concatenate([knot_positions[chosen], mu_positions]) - np.asarray(debris_position, float)
    velocity = np.concatenate([knot_velocities[chosen], mu_velocities]) - np.asarray(debris_velocity, float)
    return np.hstack([position, velocity]).astype(np.float32).ravel()


@functools.cache
def node_permutation(symmetry: Symmetry, mu_count: int) -> np.ndarray:
    """Which node comes to lie on each node's place, shape (nodes,); rows run along y, columns along x."""
    knots = knot_places()[:, ::-1] - _MIDDLE
    return symmetry.permutation(np.vstack([knots, design(mu_count).nominal_offsets]))


def image_of_features(symmetry: Symmetry, rows: np.ndarray, mu_count: int) -> np.ndarray:
    """Features of the mirrored missions, shape (n, 990 or 1014) like ``rows``."""
    nodes = rows.reshape(len(rows), node_count(mu_count), 2, 3)[:, node_permutation(symmetry, mu_count)]
    return symmetry.vectors(nodes).reshape(rows.shape)
