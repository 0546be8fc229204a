"""Which shipped systems ``--mus N`` stands for: one net and one debris, flown by different numbers of units.

Standard library only: ``run_mission.py`` reads its command line before anything is installed.
"""

from __future__ import annotations

import re

FAMILY = "zenit_"
"""How their names begin."""


def short_name(units: int) -> str:
    """The name of the system with so many units."""
    return f"{FAMILY}{units}mu"


def units_of(name: str) -> int | None:
    """The number that stands for a system; None where there is none for it."""
    match = re.fullmatch(FAMILY + r"(\d+)mu", name)
    return int(match.group(1)) if match else None
