"""What a validation case is, and what it comes to."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Quantity:
    """A number that the engine gives, beside the one that it should."""

    name: str
    unit: str
    measured: float
    reference: float | None = None
    """None where there is nothing to compare with: reported only."""
    tolerance: float = 0.0
    """Largest difference that is allowed, in the quantity's unit."""

    @property
    def difference(self) -> float | None:
        """Measured less reference."""
        return None if self.reference is None else self.measured - self.reference

    @property
    def passed(self) -> bool:
        """Whether it is within its tolerance; a number that is not finite never is."""
        if self.reference is None:
            return math.isfinite(self.measured)
        return abs(self.measured - self.reference) <= self.tolerance

    def record(self) -> dict[str, Any]:
        """Ready for JSON; NaN and infinity become None."""
        return {
            "name": self.name,
            "unit": self.unit,
            "measured": self.measured if math.isfinite(self.measured) else None,
            "reference": self.reference,
            "tolerance": None if self.reference is None else self.tolerance,
            "passed": self.passed,
        }


def relative(name: str, unit: str, measured: float, reference: float, share: float) -> Quantity:
    """A quantity that may differ by a share of its reference."""
    return Quantity(name, unit, float(measured), float(reference), share * abs(float(reference)))


@dataclass(frozen=True)
class Result:
    """What a case came to."""

    quantities: tuple[Quantity, ...]
    draw: Callable[[Any], None]
    """Draws it into an empty matplotlib figure."""

    @property
    def passed(self) -> bool:
        """Whether every quantity is within its tolerance."""
        return all(quantity.passed for quantity in self.quantities)


Physics = Mapping[str, Any]
"""Physical parameters by name, in the place of the default ones."""


@dataclass(frozen=True)
class Case:
    """A validation case."""

    title: str
    """In a line."""
    reference: str
    """Where the reference comes from."""
    run: Callable[[Physics], Result]
    """Flies it. What it is given replaces the case's own physical parameters, for instance another contact."""
