"""What the paper reports of its trained policies (its section on results): the figures that ours stand beside."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperFigures:
    """On 100 unseen random scenarios, full simulation to the end of capture."""

    success: float
    """Share captured, with the trained policy."""
    reduction: float
    """Mean fuel saved against the nominal aiming points [-]."""
    fuel_per_mu_kg: float
    """Mean over units and scenarios [kg]."""
    train_scenarios: int
    """Flown for its surrogate."""


PAPER = {"zenit_4mu": PaperFigures(1.0, 0.11, 0.028, 2540), "zenit_8mu": PaperFigures(1.0, 0.018, 0.021, 2790)}
"""By name of the system."""
