"""Scenarios from a CSV or Parquet file: one row each, with the columns of an outcomes file."""

from __future__ import annotations

from pathlib import Path

from tethernet_learning.campaigns import tables
from tethernet_learning.campaigns.cases import LABELS, Case, outcome_columns
from tethernet_learning.campaigns.columns import MUS, columns, in_words, rebuild_given
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_sim.scenario import Scenario

GROUP = "file"
"""Group of rows that name none."""


def read(path: Path) -> list[Case]:
    """Read scenarios.

    Any column of a scenario may be missing or empty: the default scenario's value is taken. Columns of outcomes are
    left aside, so that an outcomes file, or a part of it, can be flown again. Rows with aiming points keep them.

    Raises:
        CampaignError: when the file cannot be read, has a column that nobody knows, or a row is no scenario.
    """
    known = outcome_columns()
    unknown = [name for name in tables.header(path) if name not in known]
    if unknown:
        raise CampaignError(
            f"{path} has unknown columns: {', '.join(unknown)}; allowed: group, policy, {in_words(columns(Scenario))}"
        )
    cases = []
    for number, row in enumerate(tables.read(path, {**LABELS, MUS: int, **columns(Scenario)}), start=1):
        try:
            scenario = rebuild_given(Scenario, row)
        except ValueError as error:
            raise CampaignError(f"{path}, row {number}: {error}") from error
        aimed_by = row.get("policy") if scenario.aiming_offsets is not None else None
        cases.append(Case(scenario, str(row.get("group") or GROUP), str(aimed_by or GROUP)))
    if not cases:
        raise CampaignError(f"{path} has no rows; allowed: one scenario or more")
    return cases
