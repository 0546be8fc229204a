"""How well the debris is held: Capture Quality Index, mouth area, verdict (paper, section II.D)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from tethernet_control.layout import design
from tethernet_control.parameters import parameter

_CONFIG = Path(__file__).parent / "config"


@dataclass(frozen=True)
class QualityParameters:
    """Numbers of the CQI.

    The paper's V_D = 159.9 m^3 and S_D = 59.9 m^2 look swapped (159.9 m^2 is the cylinder's surface, its volume is
    132.6 m^3); the default keeps them, so that the threshold of 2.5 means what it meant there.
    """

    FILE: ClassVar[Path] = _CONFIG / "quality.yaml"

    debris_volume_m3: float = parameter(
        "V_D as printed in the paper; 132.6 is geometric", unit="m^3", low=0.01, high=1e6
    )
    debris_area_m2: float = parameter("S_D as printed in the paper; 159.9 is geometric", unit="m^2", low=0.01, high=1e6)
    characteristic_length_m: float = parameter("L_c of the debris", unit="m", low=0.01, high=1e3)
    cqi_threshold: float = parameter("Captured when the settled CQI is below", low=0.0, high=100.0)


@dataclass(frozen=True)
class HullQuality:
    """The CQI and what it is made of."""

    cqi: float
    """Capture Quality Index [-]."""
    volume: float
    """Volume of the convex hull [m^3]."""
    area: float
    """Surface of the convex hull [m^2]."""
    distance: float
    """Between the net's and the debris' centres of mass [m]."""


def hull_quality(
    knots: np.ndarray, mus: np.ndarray, net_center, debris_position, parameters: QualityParameters
) -> HullQuality:
    """The Capture Quality Index of a net (paper, Eq. 4).

    Args:
        knots: positions of the knots [m], shape (N, 3), as published (float32).
        mus: positions of the MUs [m], shape (M, 3), as published (float32).
        net_center: centre of mass of the knots [m].
        debris_position: the debris' centre of mass [m].
        parameters: V_D, S_D, L_c.

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
    distance = math.dist(net_center, debris_position)
    p = parameters
    cqi = (
        0.1 * abs(volume - p.debris_volume_m3) / p.debris_volume_m3
        + 0.1 * abs(area - p.debris_area_m2) / p.debris_area_m2
        + 0.8 * distance / p.characteristic_length_m
    )
    return HullQuality(cqi, volume, area, distance)


def _flat_area(points: np.ndarray) -> float:
    """Area of the hull of points in a plane [m^2]."""
    from scipy.spatial import ConvexHull, QhullError

    centered = points - points.mean(axis=0)
    plane = np.linalg.svd(centered, full_matrices=False)[2][:2]
    try:
        return float(ConvexHull(centered @ plane.T).volume)  # of a 2-D hull: its area
    except QhullError:
        return 0.0


def mouth_area(mus: np.ndarray) -> float:
    """Area of the net's mouth [m^2]: of the polygon spanned by the MUs in their order round the mouth, as a vector
    area.

    Args:
        mus: positions of the MUs [m], shape (4 or 8, 3), MU 1 first.
    """
    points = np.asarray(mus, float).reshape(-1, 3)
    order = np.array(mouth_order(len(points))) - 1
    ring = points[order] - points.mean(axis=0)
    return float(0.5 * np.linalg.norm(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)))


def mouth_order(mu_count: int) -> tuple[int, ...]:
    """The MUs in their order round the mouth, from 1."""
    return design(mu_count).closing_ring or (1, 2, 4, 3)


def captured(cqi: float, locked_pairs: int, mu_count: int, parameters: QualityParameters) -> bool:
    """The paper's test of success: settled CQI below the threshold and enough locked pairs."""
    return cqi < parameters.cqi_threshold and locked_pairs >= design(mu_count).required_locked_pairs


def verdict(cqi: float, locked_pairs: int, mu_count: int, parameters: QualityParameters, missed: str = "") -> str:
    """One sentence on the outcome.

    Args:
        cqi: settled index; NaN where it could not be measured.
        locked_pairs: at the end.
        mu_count: 4 or 8.
        parameters: gives the threshold.
        missed: why the mission was missed, if it was.
    """
    layout = design(mu_count)
    pairs = f"{locked_pairs} of {layout.max_locked_pairs} pairs locked (at least {layout.required_locked_pairs} needed)"
    if missed:
        return f"missed: {missed}"
    if math.isnan(cqi):
        held = "docked" if locked_pairs >= layout.required_locked_pairs else "not docked"
        return f"{held}: {pairs}; CQI not available: nothing measures the net"
    good = captured(cqi, locked_pairs, mu_count, parameters)
    quality = (
        f"CQI {cqi:.2f} ({'below' if cqi < parameters.cqi_threshold else 'not below'} {parameters.cqi_threshold:g})"
    )
    return f"{'captured' if good else 'not captured'}: {quality}, {pairs}"
