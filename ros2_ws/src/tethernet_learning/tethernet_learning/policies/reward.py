"""The reward of an episode, term by term (paper, Eq. 5)."""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.capture_quality import tight
from tethernet_core.layout import design
from tethernet_learning.flown import Flown

VARIANTS = ("threshold", "printed", "lean")
"""``printed``: the penalty on locked pairs ends and the bonus begins at N_L,max, as in the paper's equation;
``threshold``: at N_D, as in its text, which calls that captured; ``lean``: like ``threshold``, without the bonus for
the mouth's area, which is worth more than the fuel that a wider mouth costs and so teaches to burn more."""

WEIGHT = {4: 1.0, 8: 1.5}
"""w of the paper: weight of the fuel bonus."""

TERMS = ("mouth", "cqi", "locked_pairs", "fuel")
"""Names of the terms: b_mouth, p_CQI, p_NL, b_end."""

REFERENCES_FILE = Path(__file__).parent / "config" / "references.json"
"""m_fmax and A_max, written by ``tethernet train references``."""


@dataclass(frozen=True)
class Reward:
    """The paper's reward with its constants."""

    mus: int
    fuel_max_kg: float
    """m_fmax: total fuel of all MUs at which the fuel bonus is 0 [kg]; more gives a malus."""
    mouth_max_m2: float
    """A_max: mouth area at which the mouth's bonus is 1 [m^2]."""
    variant: str = "threshold"
    """One of VARIANTS."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: for an unknown variant or design.
        """
        design(self.mus)
        if self.variant not in VARIANTS:
            raise ValueError(f"reward variant {self.variant!r}; allowed: {', '.join(VARIANTS)}")

    @classmethod
    def load(cls, mus: int, variant: str = "threshold") -> Reward:
        """With the constants measured on nominal missions.

        Raises:
            ValueError: for an unknown variant or design.
        """
        measured = references()[str(design(mus).mu_count)]
        return cls(mus, measured["fuel_max_kg"], measured["mouth_max_m2"], variant)

    def terms(self, flown: Flown) -> dict[str, np.ndarray]:
        """Every term of the reward by its name; their sum is the reward.

        Args:
            flown: E episodes.

        Returns:
            One array of shape (E,) for each of TERMS.
        """
        layout = design(self.mus)
        least = layout.max_locked_pairs if self.variant == "printed" else layout.required_locked_pairs
        loose = ~tight(flown.cqi, flown.system)
        open_ = flown.locked_pairs < least
        short = flown.locked_pairs - layout.required_locked_pairs
        fuel = WEIGHT[self.mus] * (1.0 - flown.fuel_kg / self.fuel_max_kg)
        mouth = 0.0 if self.variant == "lean" else 1.0
        return {
            "mouth": mouth * flown.mouth_area_m2 / self.mouth_max_m2,
            "cqi": np.where(loose, -np.log((flown.cqi - flown.system.capture.cqi_threshold) ** 2 + 1.0), 0.0),
            "locked_pairs": np.where(open_, -np.log(short**2 + 1.0), 0.0),
            "fuel": np.where(loose | open_, 0.0, fuel),
        }

    def __call__(self, flown: Flown) -> np.ndarray:
        """The rewards, shape (E,)."""
        return np.sum(list(self.terms(flown).values()), axis=0)


@functools.cache
def references() -> dict[str, Any]:
    """Contents of REFERENCES_FILE."""
    return json.loads(REFERENCES_FILE.read_text(encoding="utf-8"))
