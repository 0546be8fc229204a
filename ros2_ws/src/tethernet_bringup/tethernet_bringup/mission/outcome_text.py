"""What became of a mission, as a person reads it: the block of lines that ends it on the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tethernet_bringup.mission.outcome import FILE_NAME, ExitStatus, FlightRecord, exit_status
from tethernet_core.aiming import FALLBACK
from tethernet_core.hold import conditions

_HELD = {True: "HELD", False: "NOT HELD", None: "HOLD UNKNOWN"}


def describe(record: FlightRecord, content: dict[str, Any], folder: Path, analyse_command: str) -> list[str]:
    """The block of lines that ends the mission on the terminal."""
    lines = ["", f"  {_headline(record)}   {content['verdict']}"]
    if record.hold is not None:
        # A mission that was missed never got to its hold test.
        how = f" ({conditions(record.hold_s, record.tow_n)})" if content["hold_end_time_s"] is not None else ""
        lines.append(f"  {_HELD[content['held']]}   {content['hold_verdict']}{how}")
    lines.append("")
    lines += [f"    {name:<18} {text}" for name, text in _rows(record, content)]
    for title, entries in (("faults", record.faults[1:]), ("warnings", record.warnings)):
        if entries:
            lines.append(f"    {title}")
            lines += [f"      {entry}" for entry in entries]
    lines += ["", f"    {'recording':<18} {folder / 'bag'}", f"    {'outcome':<18} {folder / FILE_NAME}"]
    lines += [f"    {'logs':<18} {folder / 'logs'}", f"    {'look at it with':<18} {analyse_command}", ""]
    return lines


def _headline(record: FlightRecord) -> str:
    status, final = exit_status(record), record.final
    if status == ExitStatus.NOT_CAPTURED and final is not None and not math.isfinite(final.cqi):
        return "DOCKED" if final.locked_pairs >= final.required_locked_pairs else "NOT DOCKED"
    words = {ExitStatus.CAPTURED: "CAPTURED", ExitStatus.NOT_CAPTURED: "NOT CAPTURED", ExitStatus.FAULT: "FAULT"}
    return words.get(status, "ENDED EARLY")


def _rows(record: FlightRecord, content: dict[str, Any]) -> Iterable[tuple[str, str]]:
    final = record.final
    if final is not None:
        if final.max_locked_pairs:
            need = f"{final.locked_pairs} of {final.max_locked_pairs} ({final.required_locked_pairs} needed)"
            yield "locked pairs", need
        yield "CQI", f"{content['cqi']:.3f}" if content["cqi"] is not None else "could not be measured"
        if content["cqi_all"] is not None:
            yield "with units counted", f"{content['cqi_all']:.3f}"
        if content["mcqi"] is not None:
            yield "MCQI", f"{content['mcqi']:.3f}"
        if content["enclosed"] is not None:
            yield "enclosed", "the closed net goes round the whole debris" if content["enclosed"] else "no"
        if loads := _loads(content):
            yield "largest loads", loads
    expected = content["prediction"]
    if expected is not None:
        likely = f"captured with {100.0 * expected['capture_probability']:.0f} %"
        yield "predicted", f"{expected['locked_pairs']:.1f} pairs, CQI {expected['cqi']:.2f}, {likely}"
    fallen_back = [mu for mu, source in enumerate(content["aiming_sources"], 1) if source == FALLBACK]
    if fallen_back:
        yield "nominal points", "in the place of the policy's: " + ", ".join(f"MU {mu}" for mu in fallen_back)
    yield "trigger", _seconds(content["trigger_time_s"], "after launch")
    yield "end", _seconds(content["end_time_s"] or content["flown_s"], "after launch")
    if content["hold_end_time_s"] is not None:
        yield "end of hold test", _seconds(content["hold_end_time_s"], "after launch")
    fuel = {mu: value for mu, value in enumerate(content["fuel_kg"], 1) if value is not None}
    if fuel:
        worst = max(fuel, key=fuel.__getitem__)
        yield "fuel", f"{sum(fuel.values()):.3f} kg in all, most by MU {worst}: {fuel[worst]:.3f} kg"
    if content["max_tracking_error_m"] is not None:
        yield "tracking error", f"{content['max_tracking_error_m']:.2f} m at most"
    if content["mouth_area_m2"] is not None:
        yield "mouth at trigger", f"{content['mouth_area_m2']:.0f} m^2"
    if content["wall_time_s"] is not None and content["real_time_factor"] is not None:
        yield "wall time", f"{content['wall_time_s']:.1f} s ({content['real_time_factor']:.2f} x real time)"
    yield "deadlines missed", str(content["deadline_misses"])
    if content["messages"]:
        yield "recorded", f"{sum(content['messages'].values())} messages on {len(content['messages'])} topics"
    if record.lost_controllers:
        yield "lost controllers", ", ".join(f"MU {mu}" for mu in sorted(record.lost_controllers))


def _loads(content: dict[str, Any]) -> str:
    share, force = content["max_load_share"], content["max_contact_force_n"]
    parts = [] if share is None else [f"{100.0 * share:.1f} % of a thread's strength"]
    return ", ".join(parts + ([] if force is None else [f"{force:.0f} N of contact on the debris"]))


def _seconds(value: float | None, what: str) -> str:
    return "did not come" if value is None else f"{value:.2f} s {what}"
