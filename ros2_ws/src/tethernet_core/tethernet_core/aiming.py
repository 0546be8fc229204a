"""Nominal aiming points of a system's units."""

from __future__ import annotations

from collections.abc import Sequence

from tethernet_core.mission import Point
from tethernet_core.system import System

FALLBACK = "nominal (fallback)"
"""Source of nominal aiming points that stand in for those of a policy which could not be had."""


def nominal_aiming_points(system: System, debris_position: Sequence[float]) -> list[Point]:
    """Nominal aiming points of all units.

    Args:
        system: gives their offsets.
        debris_position: the debris' centre of mass, x y z [m], frame launch.

    Returns:
        One (x, y, z) [m] per unit, unit 1 first, in the plane z = z_D (paper, Table II).
    """
    x, y, z = (float(value) for value in debris_position)
    return [(x + dx, y + dy, z) for dx, dy in system.aiming.offsets.tolist()]
