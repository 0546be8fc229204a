"""The closed surface that a net and a cap over its mouth make.

A net is a graph whose flat layout has an inside: the meshes are the faces of that layout, and its outer face is the
mouth. Meshes and cap together are a closed, oriented surface, however the net is folded, twisted or crossed in space:
each thread is passed once in either direction. That is what :mod:`.enclosure` rests on.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tethernet_core.system import System

_LARGEST_FLAT = 4
"""Meshes of more corners than this are a fan round their middle instead of round a corner, so that none is long."""


@dataclass(frozen=True, eq=False)
class NetSurface:
    """Triangles of meshes and cap. Points are the particles (nodes, then units), then the means of some of them."""

    triangles: np.ndarray
    """Points of each triangle, all oriented alike, shape (F, 3), int."""
    mean_of: np.ndarray
    """Particles that the means are of, one group after the other, shape (G,), int."""
    mean_from: np.ndarray
    """Where the group of each mean begins in ``mean_of``, shape (A,), int; none is empty."""
    rim: np.ndarray
    """Nodes round the outer boundary in order, shape (L,), int."""
    flat_opening_m2: float
    """Area of the mouth of the flat net [m^2]."""

    def corners(self, particles: np.ndarray) -> np.ndarray:
        """Corners of all triangles [m], shape (F, 3, 3), of the particles' positions [m], shape (N + M, 3)."""
        points = np.asarray(particles, float)
        if len(self.mean_from):
            sizes = np.diff(np.append(self.mean_from, len(self.mean_of)))
            means = np.add.reduceat(points[self.mean_of], self.mean_from, axis=0) / sizes[:, None]
            points = np.concatenate([points, means])
        return points[self.triangles]

    def opening_m2(self, particles: np.ndarray) -> float:
        """Vector area of the net's outer boundary [m^2]: of the flat net its area, 0 where the boundary is drawn
        together to a point or a line.
        """
        rim = np.asarray(particles, float)[self.rim]
        return _vector_area(rim)


@functools.lru_cache(maxsize=32)
def net_surface(system: System) -> NetSurface:
    """The closed surface of a system's net.

    Meshes come from the flat layout, x and y: a net that crosses itself there still gives a closed surface, whose
    meshes are then not those that one sees.

    The cap closes the mouth along what ties it: between two units that are neighbours round the boundary a panel from
    the net's boundary to the line between them, unit threads included, and a polygon of all units. Where units have
    docked, their line is a point and the panel the loop of net that hangs on it. Without units on the boundary the cap
    is a fan round the boundary's middle.
    """
    net = system.net
    faces = _faces(net.nodes[:, :2], net.threads)
    areas = [_signed_area(net.nodes[face, :2]) for face in faces]
    outer = int(np.argmin(areas))
    rim = faces[outer]
    triangles: list[tuple[int, int, int]] = []
    groups: list[list[int]] = []
    first_mean = system.particle_count

    def mean(group: list[int]) -> int:
        groups.append(group)
        return first_mean + len(groups) - 1

    def fan(apex: int, path: list[int]) -> None:
        triangles.extend((apex, a, b) for a, b in itertools.pairwise(path) if apex not in (a, b) and a != b)

    for number, face in enumerate(faces):
        if number != outer and len(face) >= 3:
            if len(face) > _LARGEST_FLAT:
                fan(mean(face), [*face, face[0]])
            else:
                fan(face[0], face)
    _cap(system, rim, mean, fan)
    sizes = [len(group) for group in groups]
    return NetSurface(
        triangles=np.array(triangles, np.int64).reshape(-1, 3),
        mean_of=np.array([particle for group in groups for particle in group], np.int64),
        mean_from=np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64) if sizes else np.zeros(0, np.int64),
        rim=np.array(rim, np.int64),
        flat_opening_m2=_vector_area(net.nodes[rim]),
    )


def _cap(
    system: System, rim: list[int], mean: Callable[[list[int]], int], fan: Callable[[int, list[int]], None]
) -> None:
    """Close the mouth: ``mean`` makes a point of the mean of particles, ``fan`` triangles from a point to a path."""
    nodes = system.net.node_count
    place = {node: index for index, node in reversed(list(enumerate(rim)))}
    tied = sorted((place[unit.node], nodes + number) for number, unit in enumerate(system.units) if unit.node in place)
    if not tied:
        fan(mean(rim), [*rim, rim[0]])
        return
    for (begin, unit), (end, other) in zip(tied, tied[1:] + tied[:1], strict=True):
        span = (end - begin) % len(rim) or (len(rim) if len(tied) == 1 else 0)
        chain = [rim[(begin + i) % len(rim)] for i in range(span + 1)]
        fan(unit if unit == other else mean([unit, other]), [unit, *chain, other])
    units = [unit for _, unit in tied]
    if len(units) >= 3:
        fan(mean(units), [*units, units[0]])


def _faces(flat: np.ndarray, threads: np.ndarray) -> list[list[int]]:
    """Faces of a net laid flat, as nodes in order: counter-clockwise, the outer one clockwise.

    Each thread is two half-threads, one in either direction. A face goes on from the end of a half-thread along the
    next one clockwise from the way back.
    """
    count = len(threads)
    begin, end = np.concatenate([threads[:, 0], threads[:, 1]]), np.concatenate([threads[:, 1], threads[:, 0]])
    way = flat[end] - flat[begin]
    order = np.lexsort((np.arctan2(way[:, 1], way[:, 0]), begin))
    rank = np.empty(2 * count, np.int64)
    rank[order] = np.arange(2 * count)
    starts = np.searchsorted(begin[order], np.arange(len(flat)), side="left")
    ends = np.searchsorted(begin[order], np.arange(len(flat)), side="right")
    back = np.concatenate([np.arange(count, 2 * count), np.arange(count)])
    behind = rank[back] - 1
    following = order[np.where(behind < starts[end], ends[end] - 1, behind)].tolist()
    origin = begin.tolist()
    faces, seen = [], bytearray(2 * count)
    for half in range(2 * count):
        face = []
        while not seen[half]:
            seen[half] = 1
            face.append(origin[half])
            half = following[half]  # noqa: PLW2901  # walks round the face that it begins
        if face:
            faces.append(face)
    return faces


def _signed_area(corners: np.ndarray) -> float:
    x, y = corners[:, 0], corners[:, 1]
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _vector_area(corners: np.ndarray) -> float:
    around = corners - corners.mean(axis=0)
    return float(0.5 * np.linalg.norm(np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)))
