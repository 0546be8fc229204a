"""How far the net lets the mouth open: aiming points farther apart than the net is long are not reached by anybody."""

from __future__ import annotations

import functools

import numpy as np

from .layout import design

_SWEEPS = 50
"""Rounds over the pairs of neighbours at the most; for the largest offsets (5 m) far fewer are needed."""


@functools.cache
def _neighbours(mu_count: int) -> list[tuple[int, int, float]]:
    """Indices of neighbours round the mouth, and the length of rim and threads between them [m]."""
    of = design(mu_count)
    corners = np.array(of.nominal_offsets)
    ring = np.argsort(np.arctan2(corners[:, 1], corners[:, 0]))
    pairs = []
    for a, b in zip(ring.tolist(), np.roll(ring, -1).tolist(), strict=True):
        rim = sum(abs(x - y) for x, y in zip(of.knots[a], of.knots[b], strict=True))
        pairs.append((a, b, float(rim + of.thread_lengths[a] + of.thread_lengths[b])))
    return pairs


def spanned(aiming_points) -> np.ndarray:
    """Where MUs come to that pull with equal force towards points between which the net is too short.

    Neighbours whose points are farther apart than the rim and their two threads are long are moved together by equal
    parts, round after round.

    Args:
        aiming_points: [m], shape (M, 3), MU 1 first; M = 4 or 8.

    Returns:
        The same points where the net is long enough [m], shape (M, 3).
    """
    points = np.array(aiming_points, float)
    for _ in range(_SWEEPS):
        moved = False
        for a, b, length in _neighbours(len(points)):
            apart = points[b] - points[a]
            distance = float(np.sqrt(apart @ apart))
            if distance > length:
                step = 0.5 * (1.0 - length / distance) * apart
                points[a] += step
                points[b] -= step
                moved = True
        if not moved:
            break
    return points
