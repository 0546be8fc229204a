"""How far the net lets the mouth open: aiming points farther apart than the net is long are not reached by anybody."""

from __future__ import annotations

import functools
import itertools

import numpy as np
import numpy.typing as npt

from tethernet_core.layout import design

_SWEEPS = 50
"""Rounds over all pairs at the most."""


@functools.cache
def _tethers(mu_count: int) -> list[tuple[int, int, float]]:
    """Indices of all pairs of MUs, and the length of the shortest way through threads between them [m]."""
    of, pairs = design(mu_count), []
    for a, b in itertools.combinations(range(mu_count), 2):
        threads = sum(abs(x - y) for x, y in zip(of.knots[a], of.knots[b], strict=True))
        pairs.append((a, b, float(threads + of.thread_lengths[a] + of.thread_lengths[b])))
    return pairs


def project_to_reachable(aiming_points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Where MUs come to that pull with equal force towards points between which the net is too short.

    Points that are farther apart than the shortest way through threads between their MUs is long are moved together by
    equal parts, pair by pair, round after round.

    Args:
        aiming_points: [m], shape (M, 3), MU 1 first; M = 4 or 8.

    Returns:
        The same points where the net is long enough [m], shape (M, 3).
    """
    points = np.array(aiming_points, float)
    for _ in range(_SWEEPS):
        moved = False
        for a, b, length in _tethers(len(points)):
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
