"""A modified Capture Quality Index (MCQI), which does not take an open net for a closed one."""

from __future__ import annotations

import functools
import math

import numpy as np

from tethernet_core.net_surface import net_surface
from tethernet_core.rotation import inverse, rotate
from tethernet_core.system import System

_LATTICE = 24
"""Points along each side of the box round the debris by which the overlap is counted: about 1 % of its volume."""


def modified_quality(
    knots: np.ndarray, mus: np.ndarray, debris_position: np.ndarray, debris_attitude: np.ndarray, system: System
) -> float:
    """MCQI, after Y. Endo, H. Kojima and P. M. Trivailo, "New formulation for evaluating status of space debris capture
    using tether-net", Adv. Space Res. 70 (2022) 2976-3002, doi 10.1016/j.asr.2022.09.024.

    **This is a reading of it.** Its authors name three things that it looks at, in the abstract; how they weigh them
    was not available to us, so they are taken here in the plainest form, each without unit, 0 for a net that fits the
    debris like a skin, summed with equal weights::

        MCQI = (V_D - V_O) / V_D  +  d / L_c  +  A / A_0

    - V_D - V_O: the debris' volume outside of the convex hull of nodes and units, V_O being what the hull overlaps;
      counted on a lattice of points in the debris. The CQI compares the volumes of hull and debris instead, whether or
      not one is inside the other.
    - d: mean distance of the debris' vertices (those of the triangles of its shape, :meth:`Shape.triangles`) from the
      hull's surface, inside or outside. Outside of the hull it is the distance from the farthest of its planes, which
      no true distance is below.
    - A / A_0: vector area of the net's outer boundary over that of the flat net, the degree of opening.
    - L_c as of the CQI.

    Numbers of the publication cannot be compared with it, and no threshold is given for it.

    Args:
        knots: positions of the nodes [m], shape (N, 3), as published (float32).
        mus: positions of the units [m], shape (M, 3), as published.
        debris_position: its centre of mass [m], shape (3,).
        debris_attitude: unit quaternion x y z w, body to launch, shape (4,).
        system: whose net and debris they are.

    Returns:
        The index [-]; NaN for a net without volume.
    """
    from scipy.spatial import ConvexHull, QhullError  # heavy, and only who assesses needs it

    particles = np.vstack([np.asarray(knots, float).reshape(-1, 3), np.asarray(mus, float).reshape(-1, 3)])
    local = rotate(inverse(np.asarray(debris_attitude, float))[None], particles - np.asarray(debris_position, float))
    try:
        hull = ConvexHull(local + system.debris.center_of_mass)
    except (QhullError, ValueError):  # flat, or not a number
        return math.nan
    inside, vertices = _samples(system)
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    missing = float(np.mean((inside @ normals.T + offsets).max(axis=1) > 0.0))
    distance = float(np.mean(np.abs((vertices @ normals.T + offsets).max(axis=1))))
    surface = net_surface(system)
    opening = surface.opening_m2(particles) / surface.flat_opening_m2 if surface.flat_opening_m2 > 0.0 else 0.0
    return missing + distance / system.debris.cqi_length_m + opening


@functools.lru_cache(maxsize=32)
def _samples(system: System) -> tuple[np.ndarray, np.ndarray]:
    """Points in the debris and its vertices, frame of its shape [m], shapes (P, 3) and (V, 3)."""
    shape = system.debris.shape
    vertices, _ = shape.triangles()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middles = [a + (b - a) * (np.arange(_LATTICE) + 0.5) / _LATTICE for a, b in zip(low, high, strict=True)]
    lattice = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = lattice[shape.distance(lattice)[0] < 0.0]
    return (inside if len(inside) else shape.centroid[None]), vertices
