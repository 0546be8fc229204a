"""How well the debris is held: Capture Quality Index, mouth area, verdict (paper, section II.D)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar, overload

import numpy as np
import numpy.typing as npt

from tethernet_core.system import System

Numbers = TypeVar("Numbers")  # a number or an array of them

KNOTS, ALL = "knots", "all"
"""What the net's centre of mass may be of: the knots without the MUs, or both.

The index asks how far "the net's" centre of mass is from the debris', and the paper does not say whether its MUs count:
they are 20 of the 21 kg with 8 MUs. Both indices are always computed, ``cqi`` with the knots alone and ``cqi_all`` with
the MUs too; one of them decides, as the system's description says.
"""


def deciding(cqi: Numbers, cqi_all: Numbers, system: System) -> Numbers:
    """The CQI that decides: one of the two, as they are (numbers or arrays)."""
    return cqi_all if system.capture.center_of_mass == ALL else cqi


@dataclass(frozen=True)
class HullQuality:
    """The CQI and what it is made of."""

    cqi: float
    """Capture Quality Index [-], the net's centre of mass that of its knots."""
    cqi_all: float
    """The same with the MUs counted; NaN where that centre is not known."""
    volume: float
    """Volume of the convex hull [m^3]."""
    area: float
    """Surface of the convex hull [m^2]."""
    distance: float
    """Between the knots' and the debris' centres of mass [m]."""


def hull_quality(
    knots: np.ndarray,
    mus: np.ndarray,
    net_center: Iterable[float],
    debris_position: Iterable[float],
    system: System,
    net_center_all: Iterable[float] | None = None,
) -> HullQuality:
    """The Capture Quality Index of a net (paper, Eq. 4).

    Args:
        knots: positions of the knots [m], shape (N, 3), as published (float32).
        mus: positions of the MUs [m], shape (M, 3), as published (float32).
        net_center: centre of mass of the knots [m].
        debris_position: the debris' centre of mass [m].
        system: gives V_D, S_D and L_c of its debris.
        net_center_all: centre of mass of knots and MUs [m]; None where it is not known.

    Returns:
        The index and its parts; a flat net has a hull of volume 0.
    """
    from scipy.spatial import ConvexHull, QhullError  # heavy, and only the assessor needs it

    points = np.vstack([np.asarray(knots, float).reshape(-1, 3), np.asarray(mus, float).reshape(-1, 3)])
    try:
        hull = ConvexHull(points)
        volume, area = float(hull.volume), float(hull.area)
    except QhullError:
        volume = 0.0
        area = 2.0 * _flat_area(points)
    debris = system.debris
    shape = (
        0.1 * abs(volume - debris.cqi_volume_m3) / debris.cqi_volume_m3
        + 0.1 * abs(area - debris.cqi_area_m2) / debris.cqi_area_m2
    )

    def index(distance: float) -> float:
        return shape + 0.8 * distance / debris.cqi_length_m

    distance = math.dist(net_center, debris_position)
    distance_all = math.nan if net_center_all is None else math.dist(net_center_all, debris_position)
    return HullQuality(index(distance), index(distance_all), volume, area, distance)


def _flat_area(points: np.ndarray) -> float:
    """Area of the hull of points in a plane [m^2]."""
    from scipy.spatial import ConvexHull, QhullError

    centered = points - points.mean(axis=0)
    plane = np.linalg.svd(centered, full_matrices=False)[2][:2]
    try:
        return float(ConvexHull(centered @ plane.T).volume)  # of a 2-D hull: its area
    except QhullError:
        return 0.0


def mouth_ring(system: System) -> tuple[int, ...]:
    """Particles at the corners of the net's mouth, in their order round it: the units; where there are fewer than
    three, the nodes that a winch draws together, or those that are ejected; none where the net has no such.
    """
    nodes = system.net.node_count
    if system.unit_count >= 3:
        return tuple(nodes + unit - 1 for unit in system.mouth_order)
    ring = system.closing.ring or system.launch.particles
    return tuple(ring) if len(ring) >= 3 else ()


def mouth_area(mus: np.ndarray, system: System, knots: np.ndarray | None = None) -> float:
    """Area of the net's mouth [m^2]: of the polygon of :func:`mouth_ring`, as a vector area.

    Args:
        mus: positions of the units [m], shape (M, 3), unit 1 first.
        system: whose mouth it is.
        knots: positions of the net's nodes [m], shape (N, 3); needed where no units span the mouth.

    Returns:
        The area, NaN where nothing spans the mouth or its corners are not known.
    """
    ring, nodes = np.array(mouth_ring(system), int), system.net.node_count
    if not len(ring):
        return math.nan
    if ring.min() >= nodes:
        corners = np.asarray(mus, float).reshape(-1, 3)[ring - nodes]
    elif knots is None or len(knots) != nodes:
        return math.nan
    else:
        corners = np.vstack([np.asarray(knots, float), np.asarray(mus, float).reshape(-1, 3)])[ring]
    around = corners - corners.mean(axis=0)
    return float(0.5 * np.linalg.norm(np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)))


@overload
def tight(cqi: float, system: System) -> bool: ...


@overload
def tight(cqi: np.ndarray, system: System) -> npt.NDArray[np.bool_]: ...


def tight(cqi: float | np.ndarray, system: System) -> bool | npt.NDArray[np.bool_]:
    """Whether the net lies tight: the CQI that decides is below the threshold. Numbers or arrays."""
    return cqi < system.capture.cqi_threshold


@overload
def captured(cqi: float, locked_pairs: float, system: System) -> bool: ...


@overload
def captured(cqi: np.ndarray, locked_pairs: np.ndarray, system: System) -> npt.NDArray[np.bool_]: ...


def captured(cqi: float | np.ndarray, locked_pairs: float | np.ndarray, system: System) -> bool | npt.NDArray[np.bool_]:
    """The paper's test of success: settled CQI below the threshold and enough locked pairs. A net that nothing closes
    needs no pairs: its CQI alone decides.

    Args:
        cqi: the one that decides, see :func:`deciding`; a number or an array.
        locked_pairs: at the end, likewise.
        system: gives the threshold and the pairs needed.

    Returns:
        True or false, or an array of them.
    """
    return tight(cqi, system) & (locked_pairs >= system.capture.required_locked_pairs)


def verdict(cqi: float, locked_pairs: int, system: System, missed: str = "") -> str:
    """One sentence on the outcome, and what it rests on.

    Args:
        cqi: settled index that decides; NaN where it could not be measured.
        locked_pairs: at the end.
        system: gives the threshold and the pairs needed.
        missed: why the mission was missed, if it was.
    """
    if missed:
        return f"missed: {missed}"
    most, needed = system.closing.max_locked_pairs, system.capture.required_locked_pairs
    pairs = f"{locked_pairs} of {most} pairs locked (at least {needed} needed)"
    if not needed:
        pairs = f"{locked_pairs} of {most} pairs locked (none needed)" if most else "nothing closes the net"
        pairs += ": the CQI alone decides"
    if math.isnan(cqi):
        held = "docked" if locked_pairs >= needed else "not docked"
        return f"{held if needed else 'undecided'}: {pairs}; CQI not available: nothing measures the net"
    which = "CQI with the MUs counted" if system.capture.center_of_mass == ALL else "CQI"
    below = "below" if tight(cqi, system) else "not below"
    quality = f"{which} {cqi:.2f} ({below} {system.capture.cqi_threshold:g})"
    return f"{'captured' if captured(cqi, locked_pairs, system) else 'not captured'}: {quality}, {pairs}"
