"""Signed distances of a triangle mesh on a grid: built once for each mesh and kept in the environment."""

from __future__ import annotations

import os
import sys
import zipfile
from pathlib import Path

import numpy as np

from ..atomic_file import write_whole

MOST_NODES = 2**20
"""8 MiB; a cube's grid has 100 nodes along its side: a spacing of 0.1 m for a body of 10 m, which rounds its edges off
by some 2 cm, as little as the knots are thick."""
FINEST = 200
"""Nodes along the longest side at the most."""
BAND = 6.0
"""Spacings round the surface in which distances are exact; further away they may be too large by a
spacing."""
MARGIN = 7.0
"""Spacings of the grid beyond the mesh on each side."""
VERSION = 2
"""Of the method: part of the file's name."""
_CHUNK = 400_000


def distance_grid(vertices: np.ndarray, faces: np.ndarray, digest: str) -> tuple[np.ndarray, float, np.ndarray]:
    """The grid of a mesh, from the cache or built.

    Args:
        vertices: [m], shape (V, 3).
        faces: of a closed surface, counter-clockwise from outside, shape (F, 3).
        digest: of the mesh.

    Returns:
        Origin [m], shape (3,); spacing [m]; signed distances [m], shape (X, Y, Z).
    """
    path = cache_folder() / f"{digest}-{VERSION}.npz"
    try:
        with np.load(path) as stored:
            return stored["origin"], float(stored["spacing"]), stored["values"]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        pass  # not there, or damaged
    origin, spacing, values = build_grid(vertices, faces)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda to: np.savez(to, origin=origin, spacing=spacing, values=values), durable=False)
    except OSError:
        pass  # a folder that cannot be written costs the next run the time once more
    return origin, spacing, values


def cache_folder() -> Path:
    """Where grids are kept: in the environment, or the user's cache where that cannot be written."""
    in_environment = sys.prefix != sys.base_prefix and os.access(sys.prefix, os.W_OK)
    base = Path(sys.prefix) / "share" if in_environment else Path.home() / ".cache"
    return base / "tethernet" / "distance_grids"


def build_grid(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Build the grid, see :func:`distance_grid`."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = high - low
    spacing = float(size.max()) / FINEST
    while np.prod(np.ceil(size / spacing) + 2.0 * MARGIN + 1.0) > MOST_NODES:
        spacing *= 1.02
    shape = (np.ceil(size / spacing) + 2.0 * MARGIN + 1.0).astype(int)
    origin = 0.5 * (low + high) - 0.5 * spacing * (shape - 1)
    axes = [origin[axis] + spacing * np.arange(shape[axis]) for axis in range(3)]
    corners = vertices[faces]
    pseudo = _pseudonormals(vertices, faces)
    squared, sign, owner = np.full(shape, np.inf), np.ones(shape, np.int8), np.zeros(shape, np.int32)
    for face in range(len(faces)):
        chosen = _enter_face(corners[face], pseudo[face], axes, origin, spacing, squared, sign)
        owner[chosen] = face
    values = np.sqrt(squared) * sign
    far = ~(squared <= (BAND * spacing) ** 2)
    values[far] = _far_distances(corners, axes, far, owner)
    return origin, spacing, values * _far_signs(far, values)


def _enter_face(
    corners: np.ndarray, pseudo: np.ndarray, axes: list[np.ndarray], origin: np.ndarray, spacing: float,
    squared: np.ndarray, sign: np.ndarray,
) -> tuple[np.ndarray, ...]:  # fmt: skip
    """Lower the squared distances round a face to its own, with the side on which each node is. Returns the indices of
    the nodes that it is nearest to so far.
    """
    reach = BAND * spacing
    begin = np.maximum(np.floor((corners.min(axis=0) - reach - origin) / spacing).astype(int), 0)
    end = np.minimum(np.ceil((corners.max(axis=0) + reach - origin) / spacing).astype(int) + 1, squared.shape)
    x, y, z = (axes[k][begin[k] : end[k]] for k in range(3))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
    level = (x * normal[0])[:, None, None] + (y * normal[1])[:, None] + z * normal[2] - corners[0] @ normal
    index = tuple(part + offset for part, offset in zip(np.nonzero(np.abs(level) <= reach), begin, strict=True))
    points = np.stack([axes[k][index[k]] for k in range(3)], axis=1)
    nearest, feature = closest_on_triangle(points, corners)
    way = points - nearest
    distance = np.einsum("ij,ij->i", way, way)
    closer = distance < squared[index]
    chosen = tuple(part[closer] for part in index)
    squared[chosen] = distance[closer]
    # The side of a face, an edge or a vertex: by its pseudonormal, which is right for every closed surface.
    sign[chosen] = np.where(np.einsum("ij,ij->i", way, pseudo[feature])[closer] < 0.0, -1, 1)
    return chosen


def closest_on_triangle(points: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest point of one triangle, and what it is on: 0 the face, 1 to 3 the edges ab, bc, ca, 4 to 6 a, b, c.

    Ericson, Real-Time Collision Detection (2005), section 5.1.5.

    Args:
        points: shape (N, 3).
        corners: of the triangle, shape (3, 3), or of one for each point, shape (N, 3, 3).
    """
    corners = np.broadcast_to(corners, (len(points), 3, 3))
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ac = b - a, c - a

    def dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.einsum("ij,ij->i", x, y)

    ap, bp, cp = points - a, points - b, points - c
    d1, d2, d3, d4, d5, d6 = dot(ab, ap), dot(ac, ap), dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    with np.errstate(divide="ignore", invalid="ignore"):
        whole = 1.0 / (va + vb + vc)
        nearest = a + ab * (vb * whole)[:, None] + ac * (vc * whole)[:, None]
        feature = np.zeros(len(points), np.int64)
        cases = (
            (2, (va <= 0.0) & (d4 - d3 >= 0.0) & (d5 - d6 >= 0.0), b, c - b, (d4 - d3) / ((d4 - d3) + (d5 - d6))),
            (3, (vb <= 0.0) & (d2 >= 0.0) & (d6 <= 0.0), a, ac, d2 / (d2 - d6)),
            (1, (vc <= 0.0) & (d1 >= 0.0) & (d3 <= 0.0), a, ab, d1 / (d1 - d3)),
        )
        for number, holds, begin, way, share in cases:
            along = np.where(np.isfinite(share), share, 0.0)
            nearest = np.where(holds[:, None], begin + along[:, None] * way, nearest)
            feature = np.where(holds, number, feature)
        for number, holds, corner in (
            (6, (d6 >= 0.0) & (d5 <= d6), c),
            (5, (d3 >= 0.0) & (d4 <= d3), b),
            (4, (d1 <= 0.0) & (d2 <= 0.0), a),
        ):
            nearest = np.where(holds[:, None], corner, nearest)
            feature = np.where(holds, number, feature)
    return nearest, feature


def _pseudonormals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Of each face, its edges and its vertices, shape (F, 7, 3), in the order of :func:`closest_on_triangle`.

    Baerentzen and Aanaes, IEEE Trans. Visualization and Computer Graphics 11 (2005): an edge's is the sum of its faces'
    normals, a vertex' the sum weighted with the faces' angles there.
    """
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    of_vertex = np.zeros_like(vertices)
    edges: dict[tuple[int, int], np.ndarray] = {}
    for corner in range(3):
        one = corners[:, (corner + 1) % 3] - corners[:, corner]
        two = corners[:, (corner + 2) % 3] - corners[:, corner]
        angle = np.arctan2(np.linalg.norm(np.cross(one, two), axis=1), np.einsum("ij,ij->i", one, two))
        np.add.at(of_vertex, faces[:, corner], angle[:, None] * normals)
    directed = np.stack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]], axis=1)
    for face, ends in enumerate(np.sort(directed, axis=2)):
        for one, two in ends:
            edges[(one, two)] = edges.get((one, two), 0.0) + normals[face]
    of_edge = np.array([[edges[(one, two)] for one, two in ends] for ends in np.sort(directed, axis=2)])
    return np.concatenate([normals[:, None], of_edge, of_vertex[faces]], axis=1)


def _far_distances(corners: np.ndarray, axes: list[np.ndarray], far: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """Distances of the nodes beyond the band, unsigned: to the face that is nearest to the nearest node of the band."""
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(far, return_distances=False, return_indices=True)
    index = np.argwhere(far)
    faces = owner[tuple(nearest[axis][far] for axis in range(3))]
    distances = np.empty(len(index))
    for begin in range(0, len(index), _CHUNK):
        part = slice(begin, begin + _CHUNK)
        points = np.stack([axes[axis][index[part, axis]] for axis in range(3)], axis=1)
        foot, _ = closest_on_triangle(points, corners[faces[part]])
        distances[part] = np.linalg.norm(points - foot, axis=1)
    return distances


def _far_signs(far: np.ndarray, values: np.ndarray) -> np.ndarray:
    """-1 for the nodes beyond the band that are inside, 1 for all others: a region has the sign of its border."""
    from scipy.ndimage import binary_dilation, label

    signs = np.ones(far.shape)
    regions, count = label(far)
    for region in range(1, count + 1):
        within = regions == region
        border = binary_dilation(within) & ~far
        signs[within] = -1.0 if np.sum(values[border] < 0.0) > np.sum(values[border] > 0.0) else 1.0
    return signs
