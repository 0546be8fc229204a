"""How well the debris is held: Capture Quality Index, mouth area, verdict (paper, section II.D)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, TypeVar, overload

import numpy as np
import numpy.typing as npt

from tethernet_core.layout import design
from tethernet_core.parameters import parameter

_CONFIG = Path(__file__).parent / "config"

Numbers = TypeVar("Numbers")  # a number or an array of them

KNOTS, ALL = "knots", "all"
"""What the net's centre of mass may be of: the knots without the MUs, or both."""


@dataclass(frozen=True)
class QualityParameters:
    """Numbers of the CQI.

    The paper's V_D = 159.9 m^3 and S_D = 59.9 m^2 look swapped (159.9 m^2 is the cylinder's surface, its volume is
    132.6 m^3); the default keeps them, so that the threshold of 2.5 means what it meant there.

    The index asks how far "the net's" centre of mass is from the debris', and the paper does not say whether its MUs
    count: they are 20 of the 21 kg with 8 MUs. Both indices are always computed, ``cqi`` with the knots alone and
    ``cqi_all`` with the MUs too; one of them decides.
    """

    FILE: ClassVar[Path] = _CONFIG / "quality.yaml"

    debris_volume_m3: float = parameter(
        "V_D as printed in the paper; 132.6 is geometric", unit="m^3", low=0.01, high=1e6
    )
    debris_area_m2: float = parameter("S_D as printed in the paper; 159.9 is geometric", unit="m^2", low=0.01, high=1e6)
    characteristic_length_m: float = parameter("L_c of the debris", unit="m", low=0.01, high=1e3)
    cqi_threshold: float = parameter("Captured when the settled CQI is below", low=0.0, high=100.0)
    center_of_mass: str = parameter(
        "Whose centre of mass the CQI that decides is computed with: knots (the centre that brings the trigger at the "
        "paper's 25 s) or all, MUs counted",
        choices=(KNOTS, ALL),
    )

    def deciding(self, cqi: Numbers, cqi_all: Numbers) -> Numbers:
        """The CQI that decides: one of the two, as they are (numbers or arrays)."""
        return cqi_all if self.center_of_mass == ALL else cqi


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
    parameters: QualityParameters,
    net_center_all: Iterable[float] | None = None,
) -> HullQuality:
    """The Capture Quality Index of a net (paper, Eq. 4).

    Args:
        knots: positions of the knots [m], shape (N, 3), as published (float32).
        mus: positions of the MUs [m], shape (M, 3), as published (float32).
        net_center: centre of mass of the knots [m].
        debris_position: the debris' centre of mass [m].
        parameters: V_D, S_D, L_c.
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
    p = parameters
    shape = (
        0.1 * abs(volume - p.debris_volume_m3) / p.debris_volume_m3
        + 0.1 * abs(area - p.debris_area_m2) / p.debris_area_m2
    )

    def index(distance: float) -> float:
        return shape + 0.8 * distance / p.characteristic_length_m

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


@overload
def tight(cqi: float, parameters: QualityParameters) -> bool: ...


@overload
def tight(cqi: np.ndarray, parameters: QualityParameters) -> npt.NDArray[np.bool_]: ...


def tight(cqi: float | np.ndarray, parameters: QualityParameters) -> bool | npt.NDArray[np.bool_]:
    """Whether the net lies tight: the CQI that decides is below the threshold. Numbers or arrays."""
    return cqi < parameters.cqi_threshold


@overload
def captured(cqi: float, locked_pairs: float, mu_count: int, parameters: QualityParameters) -> bool: ...


@overload
def captured(
    cqi: np.ndarray, locked_pairs: np.ndarray, mu_count: int, parameters: QualityParameters
) -> npt.NDArray[np.bool_]: ...


def captured(
    cqi: float | np.ndarray, locked_pairs: float | np.ndarray, mu_count: int, parameters: QualityParameters
) -> bool | npt.NDArray[np.bool_]:
    """The paper's test of success: settled CQI below the threshold and enough locked pairs.

    Args:
        cqi: the one that decides, see :meth:`QualityParameters.deciding`; a number or an array.
        locked_pairs: at the end, likewise.
        mu_count: 4 or 8.
        parameters: gives the threshold.

    Returns:
        True or false, or an array of them.
    """
    return tight(cqi, parameters) & (locked_pairs >= design(mu_count).required_locked_pairs)


def verdict(cqi: float, locked_pairs: int, mu_count: int, parameters: QualityParameters, missed: str = "") -> str:
    """One sentence on the outcome.

    Args:
        cqi: settled index that decides; NaN where it could not be measured.
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
    which = "CQI with the MUs counted" if parameters.center_of_mass == ALL else "CQI"
    quality = f"{which} {cqi:.2f} ({'below' if tight(cqi, parameters) else 'not below'} {parameters.cqi_threshold:g})"
    return f"{'captured' if good else 'not captured'}: {quality}, {pairs}"
