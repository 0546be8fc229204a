"""Whether a triangle mesh bounds a body: closed, turned outward, nowhere through itself, no part inside another."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .shape import ShapeError

_FLAT = 1e-10
"""Smaller than this share of the mesh's size, an offset is none."""
_BLOCK = 512
_PROBES, _INSIDE = 16, 0.75  # vertices that are looked at; of the winding number, 1 inside and 0 outside
_FIX = "repair the mesh (make it watertight, its normals outward)"


def check_surface(name: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Refuse a surface that bounds no body.

    Args:
        name: for errors.
        vertices: [m], shape (V, 3).
        faces: shape (F, 3).

    Raises:
        ShapeError: with what is wrong, where, and what is allowed.
    """
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ShapeError(f"{name}: a face names vertex {int(faces.max())} of {len(vertices)}")
    _check_edges(name, vertices, faces)
    _check_sides(name, vertices, faces)
    _check_crossings(name, vertices, faces)
    _check_nesting(name, vertices, faces)


def _check_edges(name: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    face = np.tile(np.arange(len(faces)), 3)
    _, index, inverse, counts = np.unique(
        np.sort(directed, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    inverse = inverse.reshape(-1)
    wrong = np.flatnonzero(counts != 2)
    if len(wrong):
        edge = wrong[0]
        ends = " to ".join(_place(vertices[v]) for v in directed[index[edge]])
        if counts[edge] == 1:
            open_edges = int((counts == 1).sum())
            problem = f"is open: {open_edges} edges belong to one face only, the first, of face {face[index[edge]]}, "
            problem += f"from {ends}"
        else:
            problem = f"has an edge from {ends} at which {counts[edge]} faces meet"
        raise ShapeError(f"{name} {problem}; allowed: a closed surface, two faces at each edge; {_FIX}")
    forward = np.bincount(inverse, directed[:, 0] < directed[:, 1], len(counts))
    twisted = np.flatnonzero(forward != 1)
    if len(twisted):
        one, other = face[inverse == twisted[0]]
        where = _place(vertices[directed[index[twisted[0]]]].mean(axis=0))
        raise ShapeError(
            f"{name}: faces {one} and {other} at {where} are turned to opposite sides; "
            f"allowed: all faces counter-clockwise seen from outside; {_FIX}"
        )


def _parts(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The connected part that each vertex belongs to: the smallest number of its vertices, shape (V,)."""
    part = np.arange(len(vertices))
    while True:  # the smallest number of a vertex spreads over its part
        least = part.copy()
        lowest = part[faces].min(axis=1)
        for corner in range(3):
            np.minimum.at(least, faces[:, corner], lowest)
        least = least[least]
        if np.array_equal(least, part):
            return part
        part = least


def _check_sides(name: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Each connected part has to enclose a volume that is not negative."""
    part = _parts(vertices, faces)
    middle = vertices.mean(axis=0)
    a, b, c = (vertices[faces[:, corner]] - middle for corner in range(3))
    sixfold = np.einsum("ij,ij->i", a, np.cross(b, c))
    of_part = part[faces[:, 0]]
    for number in np.unique(of_part):
        volume = sixfold[of_part == number].sum() / 6.0
        if volume <= 0.0:
            raise ShapeError(
                f"{name}: the part of {int((of_part == number).sum())} faces at {_place(vertices[number])} is turned "
                f"inside out (volume {volume:.4g} m^3); allowed: all faces counter-clockwise seen from outside; {_FIX}"
                "; the wall of a cavity is left out, and mass and inertia are given"
            )


def _check_nesting(name: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    """No part lies inside another: its volume would count twice, and nothing can touch it.

    The surface does not go through itself (checked before), so that a part is inside as a whole or not at all.
    """
    part = _parts(vertices, faces)
    of_part = part[faces[:, 0]]
    numbers = np.unique(of_part)
    if len(numbers) < 2:
        return
    members = {number: np.flatnonzero(part == number) for number in numbers}
    low = {number: vertices[own].min(axis=0) for number, own in members.items()}
    high = {number: vertices[own].max(axis=0) for number, own in members.items()}
    for outer in numbers:
        triangles = vertices[faces[of_part == outer]]
        for inner in numbers:
            if inner == outer or (low[inner] < low[outer]).any() or (high[inner] > high[outer]).any():
                continue
            own = members[inner]
            some = vertices[own[:: max(1, len(own) // _PROBES)]]  # one may lie on the other's surface, not all
            if max(_winding(point, triangles) for point in some) > _INSIDE:
                raise ShapeError(
                    f"{name}: the part of {int((of_part == inner).sum())} faces at {_place(vertices[inner])} lies "
                    f"inside the part of {len(triangles)} faces at {_place(vertices[outer])}; allowed: bodies beside "
                    "each other; leave the inner one out, nothing can touch it, and give mass and inertia of the whole"
                )


def _winding(point: np.ndarray, triangles: np.ndarray) -> float:
    """How often closed triangles (N, 3, 3) go round a point: 1 inside, 0 outside.

    The solid angle of a triangle is that of A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983).
    """
    a, b, c = (triangles[:, corner] - point for corner in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return float(np.arctan2(above, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2.0 * np.pi))


def _check_crossings(name: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    scale = np.ptp(vertices, axis=0).max()
    for one, other in _close_pairs(vertices, faces, _FLAT * scale):
        for first, second in ((one, other), (other, one)):
            for corner in range(3):
                ends = faces[first][:, [corner, (corner + 1) % 3]]
                # An edge with a vertex of the other face meets it there, as it may.
                shared = (ends[:, :, None] == faces[second][:, None, :]).any(axis=(1, 2))
                crossing = ~shared & _pierces(vertices[ends], vertices[faces[second]], _FLAT)
                if crossing.any():
                    hit = int(np.flatnonzero(crossing)[0])
                    where = _place(vertices[faces[second[hit]]].mean(axis=0))
                    raise ShapeError(
                        f"{name} crosses itself: face {first[hit]} goes through face {second[hit]} at {where}; "
                        f"allowed: a surface that does not; describe bodies that overlap as a compound, or {_FIX}"
                    )
        folded = _folded(vertices, faces, one, other)
        if folded.any():
            hit = int(np.flatnonzero(folded)[0])
            raise ShapeError(
                f"{name} is folded: faces {one[hit]} and {other[hit]} lie on each other at "
                f"{_place(vertices[faces[one[hit]]].mean(axis=0))}; allowed: a surface that encloses a volume; {_FIX}"
            )


def _close_pairs(vertices: np.ndarray, faces: np.ndarray, slack: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of faces whose boxes meet, in blocks."""
    corners = vertices[faces]
    low, high = corners.min(axis=1) - slack, corners.max(axis=1) + slack
    axis = int(np.argmax(np.ptp(vertices, axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    for begin in range(0, len(order), _BLOCK):
        block = np.arange(begin, min(begin + _BLOCK, len(order)))
        end = int(np.searchsorted(low[:, axis], high[block, axis].max(), side="right"))
        rest = np.arange(begin, end)
        meet = rest[None] > block[:, None]
        for k in range(3):
            meet &= (low[rest, k][None] <= high[block, k][:, None]) & (high[rest, k][None] >= low[block, k][:, None])
        first, second = np.nonzero(meet)
        if len(first):
            yield order[block[first]], order[rest[second]]


def _pierces(ends: np.ndarray, triangles: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether segments (N, 2, 3) go through triangles (N, 3, 3)."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    p, q = ends[:, 0], ends[:, 1]
    before = np.einsum("ij,ij->i", normal, p - a)
    behind = np.einsum("ij,ij->i", normal, q - a)
    margin = tolerance * size * np.sqrt(np.maximum(size, 1e-300))
    apart = ((before > margin) & (behind < -margin)) | ((before < -margin) & (behind > margin))
    span = np.where(apart, before - behind, 1.0)
    at = p + (before / span)[:, None] * (q - p)
    inside = apart & (size > 0.0)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(v - u, at - u), normal) > tolerance * size * size
    return inside


def _folded(vertices: np.ndarray, faces: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether neighbours share an edge and lie on each other."""
    same = faces[one][:, :, None] == faces[other][:, None, :]
    neighbours = same.sum(axis=(1, 2)) >= 2
    normals = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]])
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return neighbours & (np.einsum("ij,ij->i", normals[one], normals[other]) < -1.0 + 1e-12)


def _place(point: np.ndarray) -> str:
    return "({:.4g}, {:.4g}, {:.4g}) m".format(*point)
