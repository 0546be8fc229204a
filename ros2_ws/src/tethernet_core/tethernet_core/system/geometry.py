"""Geometry of flat nets that more than one derived number needs."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence

import numpy as np


def flat_length(dx: float, dy: float) -> float:
    """Length of a flat vector [m], exactly sqrt 2 times its side on a diagonal."""
    long, short = max(abs(dx), abs(dy)), min(abs(dx), abs(dy))
    return long * float(np.sqrt(1.0 + (short / long) ** 2)) if long > 0.0 else 0.0


def hull(points: np.ndarray, tolerance: float) -> list[int]:
    """Points on the border of the flat convex hull, counter-clockwise, those within its sides too.

    Args:
        points: [m], shape (N, 2).
        tolerance: how far beside the border a point still counts [m].
    """
    order = np.lexsort((points[:, 1], points[:, 0]))

    def chain(indices: Iterable[int]) -> list[int]:
        line: list[int] = []
        for i in indices:
            while len(line) >= 2:
                a, b = points[line[-2]], points[line[-1]]
                along, to = b - a, points[i] - a
                if along[0] * to[1] - along[1] * to[0] >= -tolerance * max(float(np.hypot(*to)), tolerance):
                    break
                line.pop()
            line.append(int(i))
        return line

    lower, upper = chain(order.tolist()), chain(order[::-1].tolist())
    ring = lower[:-1] + upper[:-1]
    return list(dict.fromkeys(ring))


def around(points: np.ndarray, center: np.ndarray, first: int = 0) -> list[int]:
    """Indices of points in their order round a centre, counter-clockwise from point ``first``; at equal angles the
    nearer one comes first.

    Args:
        points: [m], shape (M, 2).
        center: [m], shape (2,).
        first: where to begin.
    """
    from_center = points - center
    angles = np.arctan2(from_center[:, 1], from_center[:, 0])
    turn = np.mod(angles - angles[first], 2.0 * np.pi)
    turn[turn > 2.0 * np.pi - 1e-9] = 0.0
    distance = (from_center**2).sum(axis=1)
    return [int(i) for i in np.lexsort((distance, np.round(turn, 9)))]


def windings(points: np.ndarray, center: np.ndarray) -> tuple[float, bool]:
    """How often a closed polygon goes round a centre, and whether it does so without turning back.

    Args:
        points: [m], shape (R, 2).
        center: [m], shape (2,).
    """
    from_center = points - center
    following = np.roll(from_center, -1, axis=0)
    turns = np.arctan2(
        from_center[:, 0] * following[:, 1] - from_center[:, 1] * following[:, 0], (from_center * following).sum(axis=1)
    )
    steady = bool((turns > 1e-9).all() or (turns < -1e-9).all())
    return float(turns.sum() / (2.0 * np.pi)), steady


def pieces(count: int, threads: np.ndarray) -> np.ndarray:
    """Smallest node of the connected piece that each node is part of, shape (N,)."""
    label = np.arange(count)
    a, b = threads[:, 0], threads[:, 1]
    while True:
        least = np.minimum(label[a], label[b])
        new = label.copy()
        np.minimum.at(new, label[a], least)
        np.minimum.at(new, label[b], least)
        new = np.minimum(new, new[new])
        while not np.array_equal(new, new[new]):
            new = new[new]
        if np.array_equal(new, label):
            return label
        label = new


def shortest_ways(
    count: int, threads: np.ndarray, lengths: np.ndarray, source: int, targets: Sequence[int]
) -> dict[int, float]:
    """Length of the shortest way through threads from a node to others [m] (Dijkstra).

    Args:
        count: nodes.
        threads: shape (T, 2).
        lengths: [m], shape (T,).
        source: where all ways begin.
        targets: where they end.
    """
    # Neighbours of node i: other[start[i]:start[i + 1]].
    both = np.concatenate([threads, threads[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    other, length = both[order, 1].tolist(), np.tile(lengths, 2)[order].tolist()
    start = np.searchsorted(both[order, 0], np.arange(count + 1)).tolist()
    found: dict[int, float] = {}
    wanted = set(targets)
    settled = [False] * count
    queue = [(0.0, source)]
    while queue and not wanted <= found.keys():
        way, node = heapq.heappop(queue)
        if settled[node]:
            continue
        settled[node] = True
        if node in wanted:
            found[node] = way
        for i in range(start[node], start[node + 1]):
            if not settled[other[i]]:
                heapq.heappush(queue, (way + length[i], other[i]))
    return found
