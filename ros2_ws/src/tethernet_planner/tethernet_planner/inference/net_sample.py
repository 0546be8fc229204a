"""The net and the debris at one control tick, as the assessor sees them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

FROM_NET = "net_state"
FROM_MUS = "mu_odometry"


def _nothing() -> np.ndarray:
    return np.zeros((0, 3), np.float32)


@dataclass(frozen=True)
class NetSample:
    """One control tick; all positions and velocities in frame launch."""

    stamp_ns: int
    """[ns]."""
    center: tuple[float, float, float]
    """The net's centre of mass, knots without MUs [m]; the MUs' centroid where nothing measures the net."""
    debris_position: tuple[float, float, float]
    """The debris' centre of mass [m]."""
    locked_pairs: int
    """At this tick."""
    mu_positions: np.ndarray
    """[m], float32 as published, shape (M, 3), MU 1 first."""
    knot_positions: np.ndarray = field(default_factory=_nothing)
    """[m], float32 as published, shape (N, 3), row-major; empty where nothing measures the net."""
    knot_velocities: np.ndarray = field(default_factory=_nothing)
    """[m/s], as the positions."""
    mu_velocities: np.ndarray = field(default_factory=_nothing)
    """[m/s], as the positions."""
    debris_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of the debris' centre of mass [m/s]."""
    center_all: tuple[float, float, float] | None = None
    """The centre of mass of knots and MUs [m]; None where it is not known."""
    debris_attitude: tuple[float, float, float, float] | None = None
    """Unit quaternion x y z w, debris body to launch; None where it is not known."""
    locked: tuple[bool, ...] = ()
    """Which closing pairs are locked, in their order round the mouth; empty where that is not known."""
    max_load_share: float = math.nan
    """Largest tension of any thread over its strength since launch [-]; NaN where it is not known."""
    max_contact_force_n: float = math.nan
    """Largest force of contact on the debris since launch [N]; likewise."""

    @property
    def source(self) -> str:
        """What measured it: the word in the assessment's message."""
        return FROM_NET if len(self.knot_positions) else FROM_MUS
