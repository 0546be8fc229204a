"""``report.html``: a mission as one file that anybody can open."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tethernet_bringup.analysis import report_plots
from tethernet_bringup.analysis.mission_data import MissionData
from tethernet_bringup.analysis.recorded_flight import recorded_flight
from tethernet_bringup.analysis.table import began, decisions, pairs_text, summary
from tethernet_bringup.bags.errors import BagError
from tethernet_bringup.bags.reader import BagReader
from tethernet_bringup.bags.run_info import DESCRIPTION, PARAMETERS
from tethernet_bringup.report import markup, page
from tethernet_bringup.report.flight import Flight, size_of
from tethernet_bringup.report.geometry import geometry
from tethernet_core.hold import conditions
from tethernet_core.mission import Phase

NAME = "report.html"
_LONGEST_TEXT = 200_000
"""Of parameters and description on the page [characters]."""


def write(data: MissionData, bag: BagReader, source: Path, folder: Path) -> Path:
    """Write the report.

    Args:
        data: the mission.
        bag: where it was read from; read again for the net.
        source: the same as the user gave it.
        folder: for the file; made if need be.

    Returns:
        The file.

    Raises:
        BagError: when the file cannot be written or the bag cannot be read.
    """
    path = folder / NAME
    try:
        page.write(_page(data, bag, source), path)
    except OSError as error:
        raise BagError(f"cannot write {path}: {error.strerror}; give another folder with --output") from error
    return path


def _page(data: MissionData, bag: BagReader, source: Path) -> page.Page:
    content = summary(data, source)
    flight = recorded_flight(data, bag)
    name = content["system"] or "Mission"
    facts = [f"{content['mus']} units"]
    facts += [f"{key} {content[key]}" for key in ("policy", "seed", "pace") if content[key]]
    facts += [f"commit {content['commit'][:12]}"] if content["commit"] else []
    return page.Page(
        title=f"Capture mission {name}" if data.states else f"Recording of {name}",
        verdicts=_verdicts(content),
        facts=", ".join(facts),
        body=_body(data, content),
        content=_content(data, flight),
    )


def _content(data: MissionData, flight: Flight | None) -> dict[str, Any]:
    """What the viewer shows, small enough."""
    if flight is None:
        return {"systems": {}, "flights": []}
    packed = flight.content()
    while size_of(packed) > page.FLIGHTS_BYTES and flight.count > 2:
        flight = flight.thinned()
        packed = flight.content()
    packed["plots"] = report_plots.plots(data, flight.start_s + flight.step_s * (flight.count - 1))
    system = data.system
    return {"systems": {} if system is None else {flight.system: geometry(system)}, "flights": [packed]}


def _verdicts(content: dict[str, Any]) -> list[tuple[str, str, str]]:
    captured, held = content["captured"], content["held"]
    word, kind = {True: ("Captured", "good"), False: ("Not captured", "bad"), None: ("No verdict", "open")}[captured]
    verdicts = [(word, content["verdict"], kind)]
    if content["hold_verdict"] is not None:
        word, kind = {True: ("Held", "good"), False: ("Not held", "bad"), None: ("Not known", "open")}[held]
        flown = any(phase["phase"] == Phase.HOLDING.name for phase in content["phases"])
        how = f" ({conditions(content['hold_s'], content['tow_n'])})" if flown else ""
        verdicts.append((word, content["hold_verdict"] + how, kind))
    return verdicts


def _body(data: MissionData, content: dict[str, Any]) -> str:
    problems = markup.section("What is missing or wrong", markup.items(content["problems"]), name="notes")
    capture = f"<div>{_capture(content)}</div><div>{_flown(content)}</div>"
    numbers = markup.section("Numbers", f'<div class="columns">{capture}</div>', name="numbers")
    phases = markup.table(("phase", "from", "to", "reason"), _phases(content), name="Phases", numeric=False)
    return "\n".join(
        (
            problems,
            numbers,
            markup.section("Units", _units(content) if content["per_mu"] else "", name="units"),
            markup.section("Phases", phases if content["phases"] else "", name="phases"),
            markup.section("Parameters", _parameters(data, content), name="parameters"),
        )
    )


def _phases(content: dict[str, Any]) -> list[tuple[str, str, str, str]]:
    """Each phase once, however often the mission's state changed in it; those before the launch have no length."""
    rows: list[dict[str, Any]] = []
    for phase in content["phases"]:
        if rows and (rows[-1]["phase"], rows[-1]["reason"]) == (phase["phase"], phase["reason"]):
            rows[-1] = rows[-1] | {"to_s": phase["to_s"]}
        elif phase["reason"] or phase["to_s"] > phase["from_s"] or phase is content["phases"][-1]:
            rows.append(phase)
    return [
        (
            row["phase"].lower(), markup.number(row["from_s"], 2, " s"), markup.number(row["to_s"], 2, " s"),
            row["reason"],
        )
        for row in rows
    ]  # fmt: skip


def _capture(content: dict[str, Any]) -> str:
    """What the net came to, at the verdict and after the hold test side by side."""
    tested = content["hold_verdict"] is not None
    number, yes = markup.number, markup.yes
    rows = [
        ("captured", yes(content["captured"]), ""),
        ("held", "", yes(content["held"])),
        ("CQI", number(content["cqi"], 2), number(content["hold_cqi"], 2)),
        ("CQI with the units counted", number(content["cqi_all"], 2), number(content["hold_cqi_all"], 2)),
        ("MCQI", number(content["mcqi"], 2), number(content["hold_mcqi"], 2)),
        ("enclosed", yes(content["enclosed"]), yes(content["hold_enclosed"])),
        (
            "net to debris", number(content["net_debris_distance_m"], 2, " m"),
            number(content["hold_net_debris_distance_m"], 2, " m"),
        ),
    ]  # fmt: skip
    if not tested:
        untested = [row[:2] for row in rows if row[0] != "held"]
        return markup.table(("capture", "at the verdict"), untested, name="Capture")
    return markup.table(("capture", "at the verdict", "after the hold test"), rows, name="Capture and hold test")


def _flown(content: dict[str, Any]) -> str:
    number = markup.number
    fuels = [row["fuel_kg"] for row in content["per_mu"]]
    fuel = sum(fuels) if fuels and None not in fuels else None
    share = content["max_load_share"]
    rows = [
        ("locked pairs", pairs_text(content)),
        ("trigger", number(content["trigger_s"], 2, " s after launch")),
        ("closing began", began(content)),
        ("decisions while closing", decisions(content)),
        ("mouth area at the trigger", number(content["mouth_area_m2"], 1, " m²")),
        ("largest load of a thread", markup.UNKNOWN if share is None else f"{markup.percent(share)} of its strength"),
        ("largest contact force", number(content["max_contact_force_n"], 0, " N")),
        ("fuel of all units", number(fuel, 4, " kg")),
    ]
    return markup.table(("flight", ""), rows, name="Flight")


def _units(content: dict[str, Any]) -> str:
    number = markup.number
    rows = [
        (
            f"MU {row['mu']}", number(row["fuel_kg"], 4, " kg"), number(row["fuel_at_trigger_kg"], 4, " kg"),
            number(row["max_error_m"], 3, " m"), number(row["rms_error_m"], 3, " m"),
            number(row["max_closing_error_m"], 2, " m"), markup.percent(row["saturated_share"]),
            number(row["impulse_n_s"], 1, " N s"),
        )
        for row in content["per_mu"]
    ]  # fmt: skip
    head = (
        "unit", "fuel", "at the trigger", "largest error", "rms error", "error while closing", "saturated", "impulse",
    )  # fmt: skip
    note = f'<p class="note">Errors: {markup.text(content["error_source"])}.</p>'
    return markup.table(head, rows, name="Units") + note


def _parameters(data: MissionData, content: dict[str, Any]) -> str:
    """What it was flown with: the run's facts, its parameters and the system's description."""
    known = {key: value for key, value in data.facts.items() if key not in (PARAMETERS, DESCRIPTION) and value}
    facts = markup.table(("run", ""), [*known.items(), ("recording", content["bag"])], name="Run", numeric=False)
    parts = [facts]
    for name, key in (("Parameters of the run", PARAMETERS), ("Description of the system", DESCRIPTION)):
        if data.facts.get(key):
            parts.append(markup.details(name, markup.block(data.facts[key][:_LONGEST_TEXT])))
    return "\n".join(parts)
