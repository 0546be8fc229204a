"""The slot for a surrogate that predicts the capture's outcome at the start of closing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from .net_sample import NetSample


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
        sample: net, MUs and debris at the start of closing.
        """


NONE = "none"

_FACTORIES: dict[str, Callable[[int], Predictor]] = {}


class PredictorError(ValueError):
    """No predictor has this name."""


def register(name: str, factory: Callable[[int], Predictor]) -> None:
    """Make a predictor known by its name.

    Args:
        name: value of the assessor's parameter ``predictor``.
        factory: makes the predictor for a number of MUs.
    """
    _FACTORIES[name] = factory


def make(name: str, mu_count: int) -> Predictor | None:
    """The predictor with this name; None for ``none``.

    Raises:
        PredictorError: naming the allowed ones.
    """
    if name == NONE:
        return None
    if name not in _FACTORIES:
        raise PredictorError(f"no predictor named {name!r}; allowed: {', '.join([NONE, *sorted(_FACTORIES)])}")
    return _FACTORIES[name](mu_count)
