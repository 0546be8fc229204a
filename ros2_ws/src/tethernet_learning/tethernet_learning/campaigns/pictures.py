"""What the maps have in common."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_learning.campaigns.columns import Row
from tethernet_learning.campaigns.errors import CampaignError

SUFFIXES = (".png", ".svg", ".pdf")
CAPTURED, HELD = "captured", "held"
"""Columns of outcomes that maps show."""
COLOURS = "viridis"
"""Legible in grey and to the colour-blind."""


def new_figure(width: float, height: float) -> Any:
    """A figure that needs no display.

    Args:
        width: [inch]
        height: [inch]
    """
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def save(figure: Any, path: Path) -> None:
    """Write a picture.

    Raises:
        CampaignError: for a suffix that is none of SUFFIXES.
        OSError: when it cannot be written.
    """
    check_suffix(path)
    figure.savefig(path, dpi=150)


def check_suffix(path: Path) -> None:
    """Make sure that a picture's kind is known.

    Raises:
        CampaignError: when it is not.
    """
    if path.suffix not in SUFFIXES:
        raise CampaignError(f"{path}: unknown kind of picture; allowed: names that end in {', '.join(SUFFIXES)}")


def by_system(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows by name of the system, those with fewer units first."""
    units = {str(row["system"]): int(row["mus"] or 0) for row in rows}
    names = sorted(units, key=lambda name: (units[name], name))
    return {name: [row for row in rows if row["system"] == name] for name in names}


def tested(rows: Sequence[Row]) -> bool:
    """Whether a hold test was flown: then it is known of each mission whether it held."""
    return any(row.get("held") not in (None, "") for row in rows)


def judged(rows: Sequence[Row], what: str) -> np.ndarray:
    """Which missions were captured, or held; one that is not said to be held is not.

    Args:
        rows: of outcomes.
        what: captured or held.
    """
    return np.array([row.get(what) is True for row in rows])


def counts_text(rows: Sequence[Row]) -> str:
    """How many missions, captured, held where that was tested, and in error, in words."""
    counts = {what: int(judged(rows, what).sum()) for what in (CAPTURED, *((HELD,) if tested(rows) else ()))}
    parts = [f"{good} of {len(rows)} {what} ({100.0 * good / len(rows):.1f} %)" for what, good in counts.items()]
    errors = sum(row.get("error") not in (None, "") for row in rows)
    return ", ".join(parts + ([f"{errors} in error"] if errors else []))
