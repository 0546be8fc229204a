"""A campaign's outcomes as a table for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from tethernet_learning.campaigns import tables
from tethernet_learning.campaigns.cases import outcome_columns
from tethernet_learning.campaigns.columns import SYSTEM, Row, Value, in_words, rebuild, units_in
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.flown_systems import FlownSystems
from tethernet_learning.campaigns.statistics import Estimate, Summary, summarise
from tethernet_sim.scenario import Outcome

GROUPED_BY = ("system", "policy", "group")
NEEDED = ("mus", "policy", "group", "captured", "locked_pairs", "cqi")
"""Without these it is no outcomes file."""
HEAD = (
    "missions", "captured %", "held %", "enclosed %", "fuel per MU, g", "to the trigger, g", "CQI", "CQI, MUs counted",
    "MCQI", "largest load, % of strength", "errors", "locked pairs: missions",
)  # fmt: skip


def read(paths: Iterable[Path]) -> list[Row]:
    """The rows of outcomes files.

    Raises:
        CampaignError: when one cannot be read, is no outcomes file, or there is no row at all.
    """
    rows = []
    for path in paths:
        lacks = [name for name in NEEDED if name not in tables.header(path)]
        if lacks:
            raise CampaignError(f"{path} is no outcomes file: it has no column {', '.join(lacks)}")
        units = units_in(tables.header(path))
        for row in tables.read(path, outcome_columns(units)):
            if row.get(SYSTEM) is None:  # older than the column
                row[SYSTEM] = FlownSystems().of_row(row).name
            rows.append(row)
    if not rows:
        raise CampaignError("there is no mission in it")
    return rows


def table(rows: Sequence[Row], by: Sequence[str] = GROUPED_BY) -> list[str]:
    """Statistics of each group of missions, one line each.

    Args:
        rows: of outcomes.
        by: columns; missions that are equal in all of these are a group.

    Raises:
        CampaignError: for a column that there is not.
    """
    lines = [(*by, *HEAD), *groups(rows, by)]
    widths = [max(len(line[place]) for line in lines) for place in range(len(lines[0]))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines]


def groups(rows: Sequence[Row], by: Sequence[str] = GROUPED_BY) -> list[tuple[str, ...]]:
    """Statistics of each group of missions: what it has in common, then a cell for each of :data:`HEAD`.

    Raises:
        CampaignError: for a column that there is not.
    """
    for name in by:
        known = outcome_columns(units_in(rows[0]))
        if name not in known:
            raise CampaignError(f"no column {name!r} to group by; allowed: {in_words(known)}")
    alike: dict[tuple[Value, ...], list[Outcome]] = {}
    for row in rows:
        alike.setdefault(tuple(row.get(name) for name in by), []).append(rebuild(Outcome, row))
    return [
        (*("-" if cell is None else str(cell) for cell in key), *_cells(summarise(outcomes)))
        for key, outcomes in alike.items()
    ]


def _cells(summary: Summary) -> tuple[str, ...]:
    return (
        str(summary.count),
        _between(summary.success, 100.0, 1),
        _between(summary.held, 100.0, 1),
        _between(summary.enclosed, 100.0, 1),
        _between(summary.fuel_kg, 1e3, 2),
        _between(summary.fuel_at_trigger_kg, 1e3, 2),
        *("-" if value is None else f"{value:.2f}" for value in (summary.cqi, summary.cqi_all, summary.mcqi)),
        "-" if summary.load_share is None else f"{100.0 * summary.load_share:.1f}",
        str(summary.errors),
        ", ".join(f"{pairs}: {count}" for pairs, count in summary.locked_pairs.items()),
    )


def _between(estimate: Estimate | None, scale: float, digits: int) -> str:
    if estimate is None:
        return "-"
    value, low, high = (scale * x for x in (estimate.value, estimate.low, estimate.high))
    if math.isnan(low):
        return f"{value:.{digits}f}"
    return f"{value:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"
