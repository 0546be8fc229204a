"""Aiming offsets for data sets: from the nominal points to what misses the debris, so that a surrogate sees both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tethernet_core.system import System
from tethernet_planner.inference.task import task_of


@dataclass(frozen=True)
class Spread:
    """How offsets are drawn.

    narrow: where a policy that saves fuel will aim; captures that succeed, told apart by their fuel. beside: all units
    aim beside the debris together; most of what fails, because the net's centre of mass must come near the debris' or
    closing never begins. torn: a mouth out of shape, the units' own offsets as large as actions may be.
    """

    narrow_share: float
    """Of all scenarios."""
    beside_share: float
    torn_share: float
    inwards: tuple[float, float]
    """Narrow: least and largest part of the way from the nominal points to the middle."""

    @property
    def shares(self) -> dict[str, float]:
        """By kind."""
        return {"narrow": self.narrow_share, "beside": self.beside_share, "torn": self.torn_share}


DRAWN_SHUT = Spread(0.4, 0.45, 0.15, (0.0, 0.45))
"""Where the net is drawn shut, or not at all: fuel is least at 0.3 of the way."""
DOCKING = Spread(0.3, 0.5, 0.2, (-0.05, 0.25))
"""Where units dock: closing wants a flat net, and fuel is least at the nominal points."""

_NARROW_OWN, _BESIDE, _BESIDE_OWN, _TORN = 0.4, 1.0, 0.7, 0.8
"""As shares of the largest offset. Narrow: largest offset of a unit of its own. Beside: largest common offset (from
half of it on, closing does not begin), and of a unit from the common one. Torn: the units' own go at least so far."""


def spread_of(system: System) -> Spread:
    """How offsets are drawn for a system."""
    return DOCKING if system.closing.kind == "docking" else DRAWN_SHUT


def random_offsets(random: np.random.Generator, system: System) -> np.ndarray:
    """Offsets of the aiming points, of a kind drawn by the shares.

    Args:
        random: source of randomness.
        system: gives units, their nominal points and the largest offset.

    Returns:
        On the grid, within the largest offset [m], shape (M, 2).
    """
    spread, task = spread_of(system), task_of(system)
    limit = task.offset_limit_m
    kind = random.choice(list(spread.shares), p=list(spread.shares.values()))
    if kind == "narrow":
        common = -random.uniform(*spread.inwards) * system.aiming.offsets.reshape(-1, 2)
        own_limit = random.uniform(0.0, _NARROW_OWN * limit)
    elif kind == "beside":
        angle = random.uniform(0.0, 2.0 * np.pi)
        common = random.uniform(0.0, _BESIDE * limit) * np.array([np.cos(angle), np.sin(angle)])
        own_limit = random.uniform(0.0, _BESIDE_OWN * limit)
    else:
        common, own_limit = np.zeros(2), random.uniform(_TORN * limit, limit)
    own = random.uniform(-own_limit, own_limit, (system.unit_count, 2))
    return task.on_grid(np.clip(common + own, -limit, limit))
