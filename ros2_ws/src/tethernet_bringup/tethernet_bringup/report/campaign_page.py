"""The page of a campaign: statistics, maps, all missions, and the flights of some."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tethernet_bringup.report import markup, page
from tethernet_bringup.report.campaign_flights import Flown
from tethernet_bringup.report.campaign_maps import maps
from tethernet_bringup.report.flight import size_of
from tethernet_bringup.report.geometry import coarse_knots, geometry
from tethernet_core.shown import shown
from tethernet_core.system import System
from tethernet_learning.campaigns import pictures, report
from tethernet_learning.campaigns.columns import Row

FINEST_M = 0.01
"""Positions are rounded to this [m]."""
MOST_LISTED = 4000
"""Missions on one page; of more, those that went wrong come first."""
MOST_GROUPS = 16
"""Lines of the table of statistics that count groups of scenarios apart."""


def write(
    rows: Sequence[Row],
    systems: Sequence[System],
    flights: Iterable[tuple[int, Flown]],
    files: Sequence[Path],
    path: Path,
) -> int:
    """Write the page.

    Args:
        rows: of outcomes, of all files.
        systems: of each row.
        flights: some missions by their places among the rows; taken as long as they fit.
        files: where the rows are from.
        path: of the page.

    Returns:
        How many flights are in it.

    Raises:
        OSError: when it cannot be written.
    """
    kept = listed(rows)
    packed, remarks = _packed(flights)
    place_of = {number: place for place, number in enumerate(packed)}
    content = {
        "systems": {
            system.digest: geometry(system, coarse_knots(system))
            for system in {systems[number] for number in packed}
        },
        "flights": list(packed.values()),
        "missions": [_mission(number, rows[number], place_of, remarks, files) for number in kept],
        "maps": maps([rows[number] for number in kept], [systems[number] for number in kept]),
    }  # fmt: skip
    notes = [f"{len(kept)} of {len(rows)} missions are listed"] if len(kept) < len(rows) else []
    page.write(
        page.Page(
            title=f"Campaign {', '.join(shown(file.stem, 60) for file in files)}",
            verdicts=[(name, pictures.counts_text(of), "") for name, of in pictures.by_system(rows).items()],
            facts=f"{len(rows)} missions, {len(packed)} of them with their flight in this page",
            body=_body(rows, files, notes),
            content=content,
        ),
        path,
    )
    return len(packed)


def listed(rows: Sequence[Row]) -> list[int]:
    """Places of the missions that a page lists: all, or those that went wrong first and then an even choice."""
    if len(rows) <= MOST_LISTED:
        return list(range(len(rows)))
    wrong = [number for number, row in enumerate(rows) if went_wrong(row)][: MOST_LISTED // 2]
    rest = sorted(set(range(len(rows))) - set(wrong))
    chosen = np.linspace(0, len(rest) - 1, MOST_LISTED - len(wrong)).astype(int)
    return sorted({*wrong, *(rest[place] for place in chosen)})


def went_wrong(row: Row) -> bool:
    """Whether a mission is worth a look: in error, not captured, or not held."""
    return bool(row.get("error")) or row.get("captured") is not True or row.get("held") is False


def interesting(rows: Sequence[Row], count: int) -> list[int]:
    """Places of missions to be shown: up to half of them went wrong, the others are spread over the campaign."""
    wrong = [number for number, row in enumerate(rows) if went_wrong(row) and not row.get("error")]
    right = [number for number, row in enumerate(rows) if not went_wrong(row)]
    most = min(count, len(wrong) + len(right))
    from_wrong = min(len(wrong), max(most // 2, most - len(right)))
    return sorted([*_evenly(wrong, from_wrong), *_evenly(right, most - from_wrong)])


def _evenly(places: Sequence[int], count: int) -> list[int]:
    return [places[int(place)] for place in np.linspace(0, len(places) - 1, count).round()] if count else []


def _packed(flights: Iterable[tuple[int, Flown]]) -> tuple[dict[int, Any], dict[int, str]]:
    """Flights by the number of the mission, as many as fit; and what they came to where that is to be said."""
    packed: dict[int, Any] = {}
    ends: dict[int, Any] = {}
    room = page.FLIGHTS_BYTES
    for number, flown in flights:
        content = flown.flight.content(FINEST_M)
        if size_of(content) > room:
            break
        room -= size_of(content)
        packed[number], ends[number] = content, flown.outcome
    return packed, ends


def _mission(
    number: int, row: Row, place_of: Mapping[int, int], ends: Mapping[int, Any], files: Sequence[Path]
) -> dict[str, Any]:
    fuels = [float(value) for name, value in row.items() if name.startswith("fuel_kg_mu") and value is not None]
    named = " ".join(shlex.quote(str(file)) for file in files)
    verdict = page.said_once("captured" if row.get("captured") else "not captured", str(row.get("verdict") or ""))
    verdict += f"; {row['hold_verdict']}" if row.get("hold_verdict") else ""
    again = ends.get(number)
    if again is not None and (again.captured, again.locked_pairs) != (row.get("captured"), row.get("locked_pairs")):
        verdict += f"; flown again for this page, with other code than then: {again.verdict}"
    return {
        "number": number + 1,
        "flight": place_of.get(number),
        "system": shown(row.get("system"), 60),
        "group": shown(row.get("group") or "", 60),
        "policy": shown(row.get("policy") or "", 60),
        "captured": row.get("captured") is True,
        "held": row.get("held"),
        "error": shown(row["error"]) if row.get("error") else "",
        "verdict": shown(verdict),
        "pairs": row.get("locked_pairs"),
        "cqi": row.get("cqi"),
        "fuel": 1e3 * sum(fuels) / len(fuels) if fuels else None,
        "trigger": row.get("trigger_time_s"),
        "command": f"tethernet campaign report {named} --missions {number + 1}",
    }


def _body(rows: Sequence[Row], files: Sequence[Path], notes: Sequence[str]) -> str:
    names: Sequence[str] = report.GROUPED_BY
    lines = report.groups(rows, names)
    if len(lines) > MOST_GROUPS:
        names = names[:-1]
        lines = report.groups(rows, names)
    statistics = markup.table((*names, *report.HEAD), lines, name="Statistics")
    note = "<p class=\"note\">With 95 % intervals: Wilson's for shares, Student's for means.</p>"
    return "\n".join(
        (
            markup.section("Statistics", statistics + note + markup.items(notes), name="statistics"),
            markup.section("Parameters", "\n".join(_described(file) for file in files), name="parameters"),
        )
    )


def _described(file: Path) -> str:
    """What lies beside an outcomes file and says how it was made."""
    beside = file.with_name(file.name + ".json")
    try:
        content = json.loads(beside.read_text(encoding="utf-8"))
        text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=110)
    except (OSError, ValueError, yaml.YAMLError):
        return f'<p class="note">{markup.text(file.name)}: nothing beside it says how it was flown.</p>'
    return markup.details(f"How {file.name} was flown", markup.block(text))
