"""The debris as the kernels take it: shape, mass and inertia."""

from __future__ import annotations

import numpy as np

from tethernet_core.shapes import Cylinder, Shape
from tethernet_sim.kernels.cylinder_body import CylinderBody
from tethernet_sim.kernels.debris_body import Body, surface
from tethernet_sim.kernels.general_body import GeneralBody
from tethernet_sim.kernels.options import entry_point
from tethernet_sim.kernels.shape_formulae import KINDS

THREAD_SPANS = 4
"""Where a shape is not convex, a thread is looked at in so many spans, in each of which its distance passes for convex:
shorter than the hollows of a body that a net of meshes of 1 m closes round."""
_SYMMETRY = 1e-9
"""A tensor is symmetric, or round an axis, to this share of its largest entry."""


def debris_body(
    shape: Shape, mass: float, inertia: np.ndarray | None = None, center_of_mass: np.ndarray | None = None
) -> Body:
    """Compile a rigid body's constants.

    A cylinder whose centre of mass is its middle and whose inertia is round its axis is a
    :class:`~tethernet_sim.kernels.cylinder_body.CylinderBody`, the fast path; all else a
    :class:`~tethernet_sim.kernels.general_body.GeneralBody`. Its body frame is parallel to the shape's, its origin the
    centre of mass.

    Args:
        shape: of the body.
        mass: [kg].
        inertia: about the centre of mass [kg m^2], shape (3, 3); None: of the homogeneous body.
        center_of_mass: in the shape's frame [m], shape (3,); None: the shape's centroid.

    Raises:
        ValueError: for a mass that is not positive, an inertia that no body has, a centre of mass outside the sphere
            round the shape.
    """
    if not (np.isfinite(mass) and mass > 0.0):
        raise ValueError(f"mass_kg = {mass:g}: not positive; allowed: a positive number of kg")
    tensor = mass * shape.inertia_per_mass if inertia is None else np.array(inertia, float)
    moments, axes = checked_inertia(tensor)
    center = shape.centroid if center_of_mass is None else np.asarray(center_of_mass, float)
    if not np.linalg.norm(center - shape.centroid) < shape.reach_m:  # NaN is not
        raise ValueError(
            f"center_of_mass_m = {center.tolist()}: {np.linalg.norm(center - shape.centroid):g} m from the shape's "
            f"centroid; allowed: less than its reach of {shape.reach_m:g} m"
        )
    if isinstance(shape, Cylinder) and not center.any() and _round_z(tensor):
        return CylinderBody(
            mass=float(mass),
            across=float(tensor[0, 0]),
            along=float(tensor[2, 2]),
            radius=shape.radius_m,
            half_length=0.5 * shape.length_m,
        )
    parts = shape.primitives()
    numbers = [np.asarray(part.shape.numbers, float) for part in parts]
    spans = [1 if part.shape.convex else THREAD_SPANS for part in parts]
    return GeneralBody(
        mass=float(mass),
        reach=shape.reach_from(center),
        rates=1.0 / moments,
        axes=axes,
        kinds=np.array([KINDS[part.shape.kind] for part in parts]),
        begins=np.concatenate([[0], np.cumsum([len(n) for n in numbers])]),
        numbers=np.concatenate(numbers),
        positions=np.array([part.position - center for part in parts]),
        matrices=np.array([part.matrix for part in parts]),
        centers=np.array([part.position + part.matrix @ part.shape.centroid - center for part in parts]),
        radii=np.array([part.shape.reach_m for part in parts]),
        span_of=np.repeat(np.arange(len(parts)), spans),
        spans=np.array([(i / n, (i + 1) / n) for n in spans for i in range(n)]),
    )


def inertia_tensor(body: Body) -> np.ndarray:
    """About the centre of mass in the body frame [kg m^2], shape (3, 3)."""
    if isinstance(body, CylinderBody):
        return np.diag([body.across, body.across, body.along])
    return body.axes.T @ np.diag(1.0 / body.rates) @ body.axes


def body_rate(body: Body, momentum: np.ndarray) -> np.ndarray:
    """Angular rate [rad/s] of an angular momentum [N m s], both in the body frame, shape (..., 3)."""
    if isinstance(body, CylinderBody):
        return momentum / np.array([body.across, body.across, body.along])
    return (momentum @ body.axes.T * body.rates) @ body.axes


def body_momentum(body: Body, rate: np.ndarray) -> np.ndarray:
    """Angular momentum [N m s] at an angular rate [rad/s], both in the body frame, shape (..., 3)."""
    if isinstance(body, CylinderBody):
        return rate * np.array([body.across, body.across, body.along])
    return (rate @ body.axes.T / body.rates) @ body.axes


def surface_distance(body: Body, points: np.ndarray) -> np.ndarray:
    """Signed distance of points from the surface [m], shape (N,); points (N, 3) from the centre of mass, body frame."""
    return _distances(body, np.ascontiguousarray(points, float))


@entry_point
def _distances(body: Body, points: np.ndarray) -> np.ndarray:
    distances = np.empty(len(points))
    for i in range(len(points)):
        distances[i] = surface(body, points[i, 0], points[i, 1], points[i, 2])[0]
    return distances


def checked_inertia(tensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal moments of inertia [kg m^2], shape (3,), and the principal axes in rows, right-handed, shape (3, 3).

    Raises:
        ValueError: for a tensor that is not symmetric, not positive, or of which one principal moment exceeds the sum
            of the others.
    """
    allowed = "a symmetric, positive tensor whose principal moments fulfil the triangle inequality"
    if tensor.shape != (3, 3) or not np.isfinite(tensor).all():
        raise ValueError(f"inertia = {tensor.tolist()}: not 3 x 3 finite numbers; allowed: {allowed}")
    if np.abs(tensor - tensor.T).max() > _SYMMETRY * np.abs(tensor).max():
        raise ValueError(f"inertia = {tensor.tolist()}: not symmetric; allowed: {allowed}")
    if not (tensor - np.diag(np.diag(tensor))).any():
        moments, axes = np.diag(tensor).copy(), np.eye(3)  # in the order and the bits of the description
    else:
        moments, columns = np.linalg.eigh(0.5 * (tensor + tensor.T))
        axes = np.ascontiguousarray(columns.T) * np.linalg.det(columns)
    if moments.min() <= 0.0 or 2.0 * moments.max() > moments.sum() * (1.0 + _SYMMETRY):
        shown = ", ".join(f"{moment:g}" for moment in moments)
        raise ValueError(f"inertia has principal moments {shown} kg m^2, which no body has; allowed: {allowed}")
    return moments, axes


def _round_z(tensor: np.ndarray) -> bool:
    return bool(tensor[0, 0] == tensor[1, 1] and not (tensor - np.diag(np.diag(tensor))).any())
