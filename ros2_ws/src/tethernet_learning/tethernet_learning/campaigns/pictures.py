"""What the maps have in common."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tethernet_learning.campaigns.columns import Row
from tethernet_learning.campaigns.errors import CampaignError

SUFFIXES = (".png", ".svg", ".pdf")
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


def counts_text(rows: Sequence[Row]) -> str:
    """How many missions, captured and in error, in words."""
    captured = sum(bool(row["captured"]) for row in rows)
    errors = sum(row.get("error") not in (None, "") for row in rows)
    return f"{captured} of {len(rows)} captured ({100.0 * captured / len(rows):.1f} %)" + (
        f", {errors} in error" if errors else ""
    )
