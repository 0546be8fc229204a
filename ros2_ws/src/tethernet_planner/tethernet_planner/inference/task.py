"""What is learned for a system: where the debris may be, which offsets may be chosen, and how both are scaled (paper,
Table I).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tethernet_core.errors import InputError
from tethernet_core.mission import Point
from tethernet_core.parameters import load
from tethernet_core.settings import MissionParameters
from tethernet_core.system import System
from tethernet_planner.inference.symmetry import Symmetry, canonical, identity

SYMMETRIES = ("none", "system")
"""none: a policy sees every debris position as it is [P]; system: it sees the one image that stands for all under the
reflections and rotations that map the system onto itself, see :mod:`.symmetry`."""

_LIMIT_SHARE = 5.0 / 12.0
"""Largest offset as a share of the largest nominal one: 5 m of 12 m [P]."""

_LEAST_STEPS = 30.0
"""The grid's step is the largest power of ten [m] that divides the largest offset at least so often: 0.1 m for the
paper's 5 m [P]."""


class TaskError(InputError):
    """There is nothing to be learned: why."""


@dataclass(frozen=True)
class Task:
    """Bounds and grid of one system's aiming."""

    unit_count: int
    debris_low_m: Point
    """Lowest x, y, z of the debris at launch [m]."""
    debris_high_m: Point
    """Highest x, y, z of the debris at launch [m]: the mission's own bounds."""
    offset_limit_m: float
    """Largest offset of an aiming point from the nominal one, in x and in y [m]."""
    step_m: float
    """Debris positions and offsets are multiples of this [m]."""
    images: tuple[Symmetry, ...]
    """Maps under which one debris position stands for others; the identity alone: each stands for itself."""

    def with_images(self, images: Sequence[Symmetry]) -> Task:
        """The same with other images; the identity must be among them."""
        return replace(self, images=tuple(images))

    def on_grid(self, values: Any) -> np.ndarray:
        """Values [m] rounded to the grid, any shape."""
        steps = np.round(np.asarray(values, float) / self.step_m)
        return np.round(steps * self.step_m, 6) + 0.0  # no negative zeros

    def inside(self, debris_position: Sequence[float]) -> bool:
        """Whether the debris is where policies are trained; rounding to the grid is forgiven."""
        position, margin = np.asarray(debris_position, float), self.step_m / 2
        low, high = np.subtract(self.debris_low_m, margin), np.add(self.debris_high_m, margin)
        return bool((position >= low).all() and (position <= high).all())

    def scale_observation(self, debris_position: Sequence[float]) -> tuple[np.ndarray, Symmetry]:
        """What a policy sees.

        Args:
            debris_position: at launch [m].

        Returns:
            The position scaled to [-1, 1], float32, shape (3,), and the map that leads from its answer to the real one.
        """
        position, image = canonical(debris_position, self.images)
        low, high = np.array(self.debris_low_m), np.array(self.debris_high_m)
        scaled = np.clip(2.0 * (position - low) / (high - low) - 1.0, -1.0, 1.0)
        return scaled.astype(np.float32), image.inverse

    def offsets_from_action(self, action: Any, image: Symmetry | None = None) -> np.ndarray:
        """The offsets that a policy's answer stands for.

        Args:
            action: (dx, dy) of each unit scaled to [-1, 1], shape (2 M,), clipped here.
            image: as :meth:`scale_observation` gave it; None for none.

        Returns:
            Offsets on the grid [m], shape (M, 2).
        """
        offsets = self.offset_limit_m * np.clip(np.asarray(action, float), -1.0, 1.0).reshape(-1, 2)
        return self.on_grid(offsets if image is None else image.offsets(offsets))

    def random_debris_position(self, random: np.random.Generator) -> Point:
        """Uniform within the bounds, on the grid [m]."""
        x, y, z = self.on_grid(random.uniform(self.debris_low_m, self.debris_high_m)).tolist()
        return x, y, z

    def bounds_text(self) -> str:
        """Where the debris may be, for people."""
        low, high = self.debris_low_m, self.debris_high_m
        return f"x and y from {low[0]:g} to {high[0]:g}, z from {low[2]:g} to {high[2]:g} m"

    def as_json(self) -> dict[str, Any]:
        """What JSON can hold, the number of units aside."""
        return {
            "debris_low_m": list(self.debris_low_m),
            "debris_high_m": list(self.debris_high_m),
            "offset_limit_m": self.offset_limit_m,
            "step_m": self.step_m,
            "images": [image.as_json() for image in self.images],
        }

    @classmethod
    def from_json(cls, unit_count: int, content: Mapping[str, Any]) -> Task:
        """What :meth:`as_json` gave.

        Raises:
            ValueError, TypeError, KeyError: when it is something else.
        """
        low, high = ([float(x) for x in content[name]] for name in ("debris_low_m", "debris_high_m"))
        images = tuple(Symmetry.from_json(image) for image in content["images"])
        limit, step = float(content["offset_limit_m"]), float(content["step_m"])
        if len(low) != 3 or len(high) != 3 or not all(a < b for a, b in zip(low, high, strict=True)):
            raise ValueError(f"debris from {low} to {high}; allowed: three coordinates each, the first ones lower")
        if not (0.0 < step <= limit < math.inf):
            raise ValueError(f"offsets to {limit} in steps of {step}; allowed: a step above 0, at most the limit")
        if not images or any(len(image.units) != unit_count for image in images):
            raise ValueError(f"images of another number of units than {unit_count}")
        return cls(unit_count, (low[0], low[1], low[2]), (high[0], high[1], high[2]), limit, step, images)


def task_of(system: System) -> Task:
    """What is learned for a system, without images.

    The bounds of the debris are those of the mission's parameters that the system is flown with.
    """
    rules = load(MissionParameters, system.parameters.get("mission"))
    bound = rules.debris_bound_xy_m
    largest = float(np.abs(system.aiming.offsets).max(initial=0.0)) or float(np.abs(system.net.nodes[:, :2]).max())
    step = 10.0 ** math.floor(math.log10(_LIMIT_SHARE * largest / _LEAST_STEPS))
    limit = round(round(_LIMIT_SHARE * largest / step) * step, 6)
    return Task(
        system.unit_count,
        (-bound, -bound, -rules.debris_far_m),
        (bound, bound, -rules.debris_near_m),
        limit,
        step,
        (identity(system.unit_count),),
    )


def aimed_task_of(system: System) -> Task:
    """The same for what aims.

    Raises:
        TaskError: for a system without units.
    """
    if not system.unit_count:
        raise TaskError(f"system {system.name} has no units: there is nothing to aim; allowed: systems with units")
    return task_of(system)
