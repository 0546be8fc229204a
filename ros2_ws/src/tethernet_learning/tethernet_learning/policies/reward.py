"""The reward of an episode, term by term (paper, Eq. 5)."""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.capture_quality import tight
from tethernet_core.errors import InputError
from tethernet_core.system import System
from tethernet_learning.flown import Flown

VARIANTS = ("threshold", "printed", "lean")
"""``printed``: the penalty on locked pairs ends and the bonus begins at N_L,max, as in the paper's equation;
``threshold``: at N_D, as in its text, which calls that captured; ``lean``: like ``threshold``, without the bonus for
the mouth's area, which is worth more than the fuel that a wider mouth costs and so teaches to burn more."""

DOCKING_WEIGHT, WEIGHT = 1.5, 1.0
"""w of the paper, weight of the fuel bonus: where units dock, which takes fuel (its 8 units), and elsewhere (its 4)."""

TERMS = ("mouth", "cqi", "locked_pairs", "fuel")
"""Names of the terms: b_mouth, p_CQI, p_NL, b_end."""

REFERENCES_FILE = Path(__file__).parent / "config" / "references.json"
"""m_fmax and A_max, written by ``tethernet train references``."""


@dataclass(frozen=True)
class Reward:
    """The paper's reward with its constants."""

    system: System
    fuel_max_kg: float
    """m_fmax: total fuel of all MUs at which the fuel bonus is 0 [kg]; more gives a malus."""
    mouth_max_m2: float
    """A_max: mouth area at which the mouth's bonus is 1 [m^2]."""
    variant: str = "threshold"
    """One of VARIANTS."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: for an unknown variant.
        """
        if self.variant not in VARIANTS:
            raise ValueError(f"reward variant {self.variant!r}; allowed: {', '.join(VARIANTS)}")

    @classmethod
    def load(cls, system: System, variant: str = "threshold", file: Path = REFERENCES_FILE) -> Reward:
        """With the constants measured on nominal missions.

        Args:
            system: that is flown.
            variant: one of VARIANTS.
            file: of the constants.

        Raises:
            InputError: when they were not measured for this system: what to do.
            ValueError: for an unknown variant.
        """
        measured = references(file).get(system.name)
        if measured is None or measured.get("system_digest") != system.digest:
            other = "were measured for another system of that name" if measured else "are not there"
            known = ", ".join(references(file)) or "none"
            raise InputError(
                f"the reward's constants for system {system.name} {other} in {file} (there: {known}); measure them: "
                f"tethernet train references --system {system.name} --output FILE.json, then give "
                "--references FILE.json"
            )
        return cls(system, measured["fuel_max_kg"], measured["mouth_max_m2"], variant)

    @property
    def fuel_weight(self) -> float:
        """w of the paper."""
        return DOCKING_WEIGHT if self.system.closing.kind == "docking" else WEIGHT

    def as_json(self) -> dict[str, Any]:
        """All of it as JSON holds it, the system by its name."""
        return {
            "system": self.system.name,
            "fuel_max_kg": self.fuel_max_kg,
            "mouth_max_m2": self.mouth_max_m2,
            "variant": self.variant,
        }

    def terms(self, flown: Flown) -> dict[str, np.ndarray]:
        """Every term of the reward by its name; their sum is the reward.

        Args:
            flown: E episodes.

        Returns:
            One array of shape (E,) for each of TERMS.
        """
        needed = self.system.capture.required_locked_pairs
        least = self.system.closing.max_locked_pairs if self.variant == "printed" else needed
        loose = ~tight(flown.cqi, flown.system)
        open_ = flown.locked_pairs < least
        short = flown.locked_pairs - needed
        fuel = self.fuel_weight * (1.0 - flown.fuel_kg / self.fuel_max_kg)
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
def references(file: Path = REFERENCES_FILE) -> dict[str, dict[str, Any]]:
    """Contents of a file of constants, by name of the system.

    Raises:
        InputError: when it cannot be read.
    """
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file} cannot be read ({error}); tethernet train references writes it") from error
    if not isinstance(content, dict) or not all(isinstance(one, dict) for one in content.values()):
        raise InputError(f"{file} holds no constants of rewards; tethernet train references writes them")
    return content
