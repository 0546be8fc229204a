"""What episodes came to, as arrays: what rewards are computed from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tethernet_core.capture_quality import captured, deciding
from tethernet_core.system import System
from tethernet_sim.scenario import Outcome

CQI_LIMIT = 20.0
"""Beyond this the CQI says no more than "missed" (the paper models it below 20); a simulation in error counts as it."""


@dataclass(frozen=True)
class Flown:
    """E episodes; all arrays have shape (E,)."""

    mus: int
    cqi: np.ndarray
    """The settled Capture Quality Index that decides, at most CQI_LIMIT."""
    locked_pairs: np.ndarray
    fuel_kg: np.ndarray
    """Total of all MUs, launch to end [kg]."""
    mouth_area_m2: np.ndarray
    """At the start of closing [m^2]; 0 where that never came."""
    system: System
    """By what a capture is judged."""

    @property
    def captured(self) -> np.ndarray:
        """The test of success, as of every mission."""
        return captured(self.cqi, self.locked_pairs, self.system)


def from_outcomes(outcomes: Sequence[Outcome], system: System) -> Flown:
    """Arrays of outcomes of one design; a mission in error counts as missed by far.

    Args:
        outcomes: at least one.
        system: they were judged by.
    """
    cqi = np.array([deciding(outcome.cqi, outcome.cqi_all, system) for outcome in outcomes], float)
    return Flown(
        outcomes[0].mus,
        np.where(np.isfinite(cqi), np.minimum(cqi, CQI_LIMIT), CQI_LIMIT),
        np.array([0 if outcome.error else outcome.locked_pairs for outcome in outcomes]),
        np.array([sum(outcome.fuel_kg) for outcome in outcomes]),
        np.array([outcome.mouth_area_m2 or 0.0 for outcome in outcomes]),
        system,
    )


def together(parts: Sequence[Flown], order: Sequence[int]) -> Flown:
    """Episodes that were flown in parts.

    Args:
        parts: of one system, at least one.
        order: the place of each of their episodes among all, one part after the other.
    """
    place = np.argsort(np.asarray(order, int))
    arrays = {
        name: np.concatenate([getattr(part, name) for part in parts])[place]
        for name in ("cqi", "locked_pairs", "fuel_kg", "mouth_area_m2")
    }
    return Flown(mus=parts[0].mus, system=parts[0].system, **arrays)
