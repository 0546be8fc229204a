"""How far the net lets the mouth open: aiming points farther apart than the net is long are not reached by anybody."""

from __future__ import annotations

import numpy as np

from tethernet_core.system import System

_SWEEPS = 50
"""Rounds over all pairs at the most."""


def project_to_reachable(aiming_points: np.ndarray, system: System) -> np.ndarray:
    """Where units come to that pull with equal force towards points between which the net is too short.

    Points that are farther apart than the shortest way through threads between their units is long are moved together
    by equal parts, pair by pair, round after round.

    Args:
        aiming_points: [m], shape (M, 3), unit 1 first.
        system: gives the lengths.

    Returns:
        The same points where the net is long enough [m], shape (M, 3).
    """
    points = np.array(aiming_points, float)
    for _ in range(_SWEEPS):
        moved = False
        for a, b, length in system.unit_tethers:
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
