"""Scenarios from a CSV or Parquet file: one row each, with the columns of an outcomes file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tethernet_core.system import System
from tethernet_learning.campaigns import tables
from tethernet_learning.campaigns.cases import LABELS, Case, outcome_columns
from tethernet_learning.campaigns.columns import MUS, columns, in_words, rebuild_given, units_in
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.flown_systems import FlownSystems
from tethernet_sim.scenario import Scenario

GROUP = "file"
"""Group of rows that name none."""


def read(path: Path, given: Sequence[System] = ()) -> list[Case]:
    """Read scenarios.

    Any column of a scenario may be missing or empty: the default scenario's value is taken. Columns of outcomes are
    left aside, so that an outcomes file, or a part of it, can be flown again. Rows with aiming points keep them.

    The column ``system`` holds the name of a shipped system, of one of those given, or the path of a description; where
    it lacks, the number of units tells which shipped system was flown.

    Args:
        path: .csv or .parquet.
        given: systems that rows may name.

    Raises:
        CampaignError: when the file cannot be read, has a column that nobody knows, or a row is no scenario.
    """
    header = tables.header(path)
    units = units_in(header)
    known = outcome_columns(units)
    unknown = [name for name in header if name not in known]
    if unknown:
        raise CampaignError(
            f"{path} has unknown columns: {', '.join(unknown)}; allowed: group, policy, "
            f"{in_words(columns(Scenario, max(units, 1)))}"
        )
    systems = FlownSystems(given, [path])
    cases = []
    for number, row in enumerate(tables.read(path, {**LABELS, MUS: int, **columns(Scenario, units)}), start=1):
        try:
            scenario = rebuild_given(Scenario, row, systems.of)
        except ValueError as error:
            raise CampaignError(f"{path}, row {number}: {error}") from error
        aimed_by = row.get("policy") if scenario.aiming_offsets is not None else None
        cases.append(Case(scenario, str(row.get("group") or GROUP), str(aimed_by or GROUP)))
    if not cases:
        raise CampaignError(f"{path} has no rows; allowed: one scenario or more")
    return cases
