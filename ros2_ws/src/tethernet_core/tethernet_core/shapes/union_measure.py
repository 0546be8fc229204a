"""How much of a part's volume and surface belongs to a union of overlapping parts."""

from __future__ import annotations

import numpy as np

from .shape import Primitive

POINTS = 2**16
"""Of a low-discrepancy sequence in each part: shares to about a part in a thousand."""
_TOUCHING = 1e-6
"""Surfaces nearer than this share of a part's extent are one."""
_PLASTIC_2 = 1.32471795724474602596
_PLASTIC_3 = 1.22074408460575947536


def _sequence(count: int, dimensions: int) -> np.ndarray:
    """Points of the additive recurrence with the plastic numbers, in the unit cube, shape (count, dimensions).

    Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018).
    """
    root = _PLASTIC_2 if dimensions == 2 else _PLASTIC_3
    steps = root ** -np.arange(1.0, dimensions + 1.0)
    return (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0


def _overlapping(parts: list[Primitive], index: int) -> list[int]:
    """Other parts whose bounding sphere meets that of a part."""
    spheres = [(p.position + p.matrix @ p.shape.centroid, p.shape.reach_m) for p in parts]
    center, radius = spheres[index]
    return [
        i
        for i, (other, reach) in enumerate(spheres)
        if i != index and np.linalg.norm(other - center) < (radius + reach) * (1.0 + _TOUCHING)
    ]


def _depths(part: Primitive, points: np.ndarray) -> np.ndarray:
    """Signed distance of points of the union's frame from a part [m]."""
    return part.shape.distance((points - part.position) @ part.matrix)[0]


def own_share(parts: list[Primitive], index: int) -> float:
    """Share of a part's volume that is in no earlier part."""
    earlier = [i for i in _overlapping(parts, index) if i < index]
    if not earlier:
        return 1.0
    part = parts[index]
    corners = part.shape.triangles()[0]
    low, high = corners.min(axis=0), corners.max(axis=0)
    low, high = low - 0.01 * (high - low), high + 0.01 * (high - low)  # polygons stand for circles
    points = low + _sequence(POINTS, 3) * (high - low)
    points = points[part.shape.distance(points)[0] < 0.0] @ part.matrix.T + part.position
    own = np.ones(len(points), bool)
    for i in earlier:
        own &= _depths(parts[i], points) >= 0.0
    return float(own.mean())


def exposed_share(parts: list[Primitive], index: int) -> float:
    """Share of a part's surface that is the union's; where surfaces coincide it is the first part's."""
    others = _overlapping(parts, index)
    if not others:
        return 1.0
    part = parts[index]
    corners, faces = part.shape.triangles()
    a, b, c = (corners[faces[:, k]] for k in range(3))
    crossed = np.cross(b - a, c - a)
    length = np.linalg.norm(crossed, axis=1)
    chosen = np.searchsorted(np.cumsum(length), (np.arange(POINTS) + 0.5) / POINTS * length.sum())
    u, v = _sequence(POINTS, 2).T
    flip = u + v > 1.0
    u, v = np.where(flip, 1.0 - u, u), np.where(flip, 1.0 - v, v)
    at = a[chosen] + u[:, None] * (b - a)[chosen] + v[:, None] * (c - a)[chosen]
    # From the triangles to the true surface.
    distance, normal = part.shape.distance(at)
    at = (at - distance[:, None] * normal) @ part.matrix.T + part.position
    step = _TOUCHING * part.shape.extent_m
    outward = at + step * (normal @ part.matrix.T)
    exposed = np.ones(POINTS, bool)
    for i in others:
        exposed &= _depths(parts[i], outward) > 0.0
        if i < index:
            exposed &= np.abs(_depths(parts[i], at)) > 0.5 * step
    return float(exposed.mean())
