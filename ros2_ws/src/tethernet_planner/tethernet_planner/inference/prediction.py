"""What a surrogate expects of a mission, and who may expect it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tethernet_planner.inference.net_sample import NetSample


@dataclass(frozen=True)
class Prediction:
    """What a surrogate expects for the end of the mission."""

    cqi: float
    """Settled Capture Quality Index [-]."""
    locked_pairs: float
    """Number of locked pairs, not rounded."""
    capture_probability: float
    """0 to 1."""


class Predictor(Protocol):
    """Predicts the outcome from the net at the start of closing (paper, section II.E)."""

    def predict(self, sample: NetSample) -> Prediction:
        """Args:
        sample: net, MUs and debris at the start of closing; something has measured the net.
        """
