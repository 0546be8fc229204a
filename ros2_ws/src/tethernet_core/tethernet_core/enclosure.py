"""Whether the debris is inside the closed net, topologically."""

from __future__ import annotations

import functools
import math

import numpy as np

from tethernet_core.net_surface import net_surface
from tethernet_core.rotation import rotate
from tethernet_core.system import System

SLICES = 10
"""Slices of the debris' long axis; the net is looked at from the middles of the outermost two."""


def enclosed(
    knots: np.ndarray, mus: np.ndarray, debris_position: np.ndarray, debris_attitude: np.ndarray, system: System
) -> bool:
    """Whether the closed net goes round the whole debris, from one end of its long axis to the other.

    The net's meshes and a cap over its mouth are a closed surface (:func:`~tethernet_core.net_surface.net_surface`). A
    point is inside where the surface covers the whole sky as seen from there, its solid angle over 4 pi (the winding
    number) not 0: whatever way leads far away passes through it. The number is whole by nature, so 0.5 is no threshold
    that anything depends on but rounding. Folds do not matter: where a surface folds back on itself a way passes it
    three times, forth, back and forth.

    Looked from are the middles of the outermost of :data:`SLICES` equal slices of the debris' axis of least inertia,
    between the points where that axis leaves the body. Both must be inside: debris whose end sticks out of the net
    slips off when it is towed. What lies between them is not looked at, because the cap, which is no thing, may cut
    through the body there, where the mouth is a slit between two bunches of units that lie on either side of the body;
    the net's threads cannot. How wide the mouth is, it does not say: :mod:`.modified_quality` asks that.

    Args:
        knots: positions of the nodes [m], shape (N, 3), as published (float32).
        mus: positions of the units [m], shape (M, 3), as published.
        debris_position: its centre of mass [m], shape (3,).
        debris_attitude: unit quaternion x y z w, body to launch, shape (4,).
        system: whose net and debris they are.

    Returns:
        True where both ends are inside; False for a net that is not a number somewhere.
    """
    points = axis_points(system) @ _to_body_rows(debris_attitude) + np.asarray(debris_position, float)
    return bool((np.abs(winding_numbers(knots, mus, points, system)) > 0.5).all())


def winding_numbers(knots: np.ndarray, mus: np.ndarray, points: np.ndarray, system: System) -> np.ndarray:
    """How often the closed net goes round points: its solid angle over 4 pi.

    The solid angle of a triangle is that of van Oosterom and Strackee (IEEE Trans. Biomed. Eng. BME-30, 1983).

    Args:
        knots: positions of the nodes [m], shape (N, 3).
        mus: positions of the units [m], shape (M, 3).
        points: to look from [m], shape (Q, 3).
        system: whose net it is.

    Returns:
        Winding numbers, whole but for rounding where a point does not lie on the surface, shape (Q,).
    """
    particles = np.vstack([np.asarray(knots, float).reshape(-1, 3), np.asarray(mus, float).reshape(-1, 3)])
    corners = net_surface(system).corners(particles)
    seen = corners[None] - points[:, None, None, :]
    a, b, c = seen[:, :, 0], seen[:, :, 1], seen[:, :, 2]
    la, lb, lc = (np.sqrt(np.einsum("qfx,qfx->qf", v, v)) for v in (a, b, c))
    ab, bc, ca = (np.einsum("qfx,qfx->qf", v, w) for v, w in ((a, b), (b, c), (c, a)))
    volume = np.einsum("qfx,qfx->qf", a, np.cross(b, c))
    angle = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
    return np.asarray(angle.sum(axis=1) / (4.0 * math.pi))


@functools.lru_cache(maxsize=32)
def axis_points(system: System) -> np.ndarray:
    """Middles of the outermost slices of the debris' long axis, that of the least inertia, body frame [m], shape
    (2, 3). On a side on which the axis does not meet the body its centre of mass is the end.
    """
    debris = system.debris
    axis = np.linalg.eigh(debris.inertia)[1][:, 0]
    ends = debris.shape.ray_exit(debris.center_of_mass, np.stack([-axis, axis]))
    low, high = -float(ends[0]), float(ends[1])
    return np.array([[low], [high]]) * axis + np.array([[0.5], [-0.5]]) * (high - low) / SLICES * axis


def _to_body_rows(attitude: np.ndarray) -> np.ndarray:
    """Body axes as rows, launch frame, shape (3, 3): ``local @ rows`` turns points of the body to the launch frame."""
    return np.asarray(rotate(np.asarray(attitude, float), np.eye(3)))
