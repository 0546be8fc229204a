"""What the closing leaves open: the loops of net that are left between units that dock, against the debris' girth.

Debris cannot slip out of a bag through a loop that is shorter than the least girth of its body. A longer loop does not
let it out by itself, but then only friction and how the net happens to lie hold it.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from tethernet_core.shapes import Shape
from tethernet_core.sphere_directions import directions

from .hardware import Hardware

_DIRECTIONS = 400
"""Directions that the body is looked at from for its least girth, besides its axes of inertia."""


def widest_loop_m(system: Hardware, docked: Sequence[bool]) -> float:
    """Length of the longest loop of net and unit threads that is left when some neighbours have docked.

    Units that have docked are one point. The strand from one of them to the next, thread, net's edge and thread, is a
    loop of its own; where two neighbours or more have not docked, the strands between the groups make up one loop.

    Args:
        system: whose units dock.
        docked: one for each pair of neighbours, in their order round the mouth.

    Returns:
        [m]; NaN where units do not dock.

    Raises:
        ValueError: for another number of pairs.
    """
    if system.closing.kind != "docking":
        return float("nan")
    pairs = system.ring_neighbours
    if len(docked) != len(pairs):
        raise ValueError(f"docked has {len(docked)} entries; allowed: {len(pairs)}, one for each pair of neighbours")
    ways = {(a + 1, b + 1): length for a, b, length in system.unit_tethers}
    strands = np.array([ways[min(pair), max(pair)] for pair in pairs])
    apart = ~np.asarray(docked, bool)
    return float(max(strands.max(), strands[apart].sum()))


def widest_loop_of_capture_m(system: Hardware) -> float:
    """The longest loop left by the worst closing that counts as captured [m]; NaN where units do not dock."""
    missing = system.closing.max_locked_pairs - system.capture.required_locked_pairs
    if system.closing.kind != "docking":
        return float("nan")
    pairs = range(len(system.ring_neighbours))
    alone = [widest_loop_m(system, [pair != other for other in pairs]) for pair in pairs]
    worst = sorted(pairs, key=lambda pair: -alone[pair])[:missing]
    return widest_loop_m(system, [pair not in worst for pair in pairs])


@functools.lru_cache(maxsize=32)
def least_girth_m(shape: Shape) -> float:
    """The shortest loop of string that can be drawn along over the whole body [m]: the least, over all directions, of
    the perimeter of its convex outline seen from there.

    Args:
        shape: any; circles are taken as the polygons of its triangles, and directions as a lattice with the axes of
            inertia, which is exact to about 1 %.
    """
    from scipy.spatial import ConvexHull  # heavy, and only who asks needs it

    vertices, _ = shape.triangles()
    corners = vertices[ConvexHull(vertices).vertices]
    axes = np.linalg.eigh(shape.inertia_per_mass)[1].T
    looks = np.concatenate([axes, directions(_DIRECTIONS, hemisphere=True)])
    return min(_outline_m(corners, look) for look in looks)


def _outline_m(corners: np.ndarray, look: np.ndarray) -> float:
    """Perimeter of the convex outline of points (K, 3) seen along a unit vector [m]."""
    from scipy.spatial import ConvexHull

    across = np.linalg.svd(look[None])[2][1:]
    return float(ConvexHull(corners @ across.T).area)  # of a plane hull, scipy's area is the perimeter
