"""The debris of a description, built and checked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..shapes import ShapeError, shape_from
from .entries import finite, read_section
from .errors import DescriptionError, Place
from .parts import Debris, frozen
from .sections import DebrisSection, QualitySection

_INERTIA_FORM = (
    "three principal moments or a symmetric 3 x 3 matrix in kg m^2, positive, none above the sum of the others"
)


def build_debris(content: Any, folder: Path, place: Place) -> Debris:
    """The debris of a description.

    Args:
        content: the section ``debris``.
        folder: where a mesh's file is, if its name is relative.
        place: for errors.

    Raises:
        DescriptionError: for a shape that is none, or an inertia that no body has.
    """
    section = read_section(DebrisSection, content, place)
    try:
        shape = shape_from(section.shape, folder=folder, where=(place / "shape").path)
    except ShapeError as error:
        raise DescriptionError(f"system {place.system}: {error}") from error
    center = shape.centroid if section.center_of_mass_m is None else np.array(section.center_of_mass_m)
    if section.inertia_kg_m2 is not None:
        inertia = _inertia(section.inertia_kg_m2, place / "inertia_kg_m2")
    elif section.center_of_mass_m is None:
        inertia = section.mass_kg * shape.inertia_per_mass
    else:
        raise (place / "inertia_kg_m2").problem(
            "is missing: a body with a centre of mass of its own is not homogeneous", _INERTIA_FORM
        )
    quality = read_section(QualitySection, {} if section.cqi is None else section.cqi, place / "cqi")
    return Debris(
        shape=shape,
        center_of_mass=frozen(np.array(center, float)),
        mass_kg=section.mass_kg,
        inertia=frozen(np.array(inertia, float)),
        given_volume_m3=quality.volume_m3,
        given_area_m2=quality.area_m2,
        given_length_m=quality.length_m,
    )


def _inertia(content: Any, place: Place) -> np.ndarray:
    allowed = _INERTIA_FORM
    if not isinstance(content, list | tuple) or len(content) != 3:
        raise place.error(content, "not three rows or moments", allowed)
    rows = []
    for i, row in enumerate(content):
        if isinstance(row, list | tuple):
            if len(row) != 3:
                raise place[i].error(row, "not three numbers", allowed)
            rows.append([finite(value, place[i][j], allowed) for j, value in enumerate(row)])
        else:
            moment = finite(row, place[i], allowed)
            rows.append([moment if i == j else 0.0 for j in range(3)])
    inertia = np.array(rows)
    scale = float(np.abs(inertia).max())
    if np.abs(inertia - inertia.T).max() > 1e-9 * scale:
        raise place.error(content, "not symmetric", allowed)
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] <= 0.0:
        raise place.error(content, f"has a principal moment of {moments[0]:.4g} kg m^2", allowed)
    if moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
        raise place.error(
            content,
            f"no body has the principal moments {moments[0]:.4g}, {moments[1]:.4g} and {moments[2]:.4g}",
            allowed,
        )
    return inertia
