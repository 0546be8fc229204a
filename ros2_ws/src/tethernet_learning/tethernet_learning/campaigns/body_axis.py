"""The axis of a body whose direction campaigns vary and maps show: the long one, where it has one."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from tethernet_core import sphere_directions
from tethernet_core.system import System

_CLEARLY = 0.9
"""A moment of inertia this much below the others marks the long axis."""
_SAME_SHARE = 1e-3
"""Surfaces that differ by less than this share of the body's size are the same."""


class BodyAxis(NamedTuple):
    """An axis of the debris."""

    direction: tuple[float, float, float]
    """Unit vector in the body's frame."""
    name: str
    """For people."""
    ends_alike: bool
    """Whether the body looks the same from both ends."""


@functools.lru_cache(maxsize=64)
def body_axis(system: System) -> BodyAxis:
    """The axis of a system's debris: that of its least moment of inertia, if that is clearly the least; else z."""
    moments, axes = np.linalg.eigh(system.debris.inertia)
    is_long = bool(moments[0] < _CLEARLY * moments[1])
    axis = axes[:, 0] if is_long else np.array([0.0, 0.0, 1.0])
    axis = axis * np.sign(axis[np.abs(axis).argmax()])
    nearest = np.eye(3)[np.abs(axis).argmax()]
    if axis @ nearest > 1.0 - 1e-12:
        axis = nearest
    x, y, z = axis.tolist()
    name = "long axis" if is_long else "body axis z"
    return BodyAxis((x, y, z), name, _ends_alike(system, axis))


def _ends_alike(system: System, axis: np.ndarray) -> bool:
    debris = system.debris
    size, center = debris.shape.extent_m, np.asarray(debris.center_of_mass)
    places = 0.4 * size * sphere_directions.directions(200)
    mirrored = places - 2.0 * (places @ axis)[:, None] * axis
    here, there = (debris.shape.distance(center + p)[0] for p in (places, mirrored))
    return bool((np.abs(here - there) < _SAME_SHARE * size).all())
