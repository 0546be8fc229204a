"""The table of a mission: as text for people, as a mapping for programs."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from tethernet_bringup.analysis.metrics import (
    SETTLED_S,
    Curve,
    error_source,
    missing,
    net_distance,
    nonfinite,
    phase_spans,
    quality,
    report,
    topic_report,
)
from tethernet_bringup.analysis.mission_data import Assessment, MissionData
from tethernet_bringup.analysis.punctuality import ClosingStart, closing_start, delay_text, late_decisions
from tethernet_core.hold import conditions
from tethernet_core.mission import Phase
from tethernet_core.unknown import answer

_MU_TOPIC = re.compile(r"/mu(\d+)/(\w+)$")


def summary(data: MissionData, bag: Path) -> dict[str, Any]:
    """All numbers; None where something is not recorded or not finite.

    Args:
        data: the mission.
        bag: where it was read from.
    """
    topics = [topic_report(name, topic) for name, topic in sorted(data.topics.items())]
    cqi, pairs = quality(data)
    distance = net_distance(data)
    system = data.system
    start = closing_start(data)
    decisions, late = late_decisions(data)
    return _finite(
        {
            "bag": str(bag),
            "system": data.facts.get("system") or (system.name if system else None),
            "mus": data.mu_count,
            **{key: data.facts.get(key) for key in ("policy", "seed", "pace", "commit")},
            "verdict": verdict(data),
            "captured": bool(data.final.message.captured) if data.final else None,
            "cqi": _told(data.final, "cqi") if data.hold else _last(cqi),
            **{name: _told(data.final, name) for name in ("cqi_all", "mcqi")},
            "enclosed": answer(data.final.message, "enclosed") if data.final else None,
            "hold_cqi": _told(data.hold, "cqi"),
            "hold_cqi_all": _told(data.hold, "cqi_all"),
            "hold_mcqi": _told(data.hold, "mcqi"),
            "hold_enclosed": answer(data.hold.message, "enclosed") if data.hold else None,
            "hold_net_debris_distance_m": _told(data.hold, "net_debris_distance"),
            "held": answer(data.hold.message, "held") if data.hold else None,
            "hold_verdict": data.hold.message.hold_verdict if data.hold else None,
            "hold_s": float(getattr(data.states[-1], "hold_duration", 0.0)) if data.states else 0.0,
            "tow_n": float(getattr(data.states[-1], "tow", 0.0)) if data.states else 0.0,
            "max_load_share": _told(data.hold or data.final, "max_load_share"),
            "max_contact_force_n": _told(data.hold or data.final, "max_contact_force"),
            "locked_pairs": int(pairs.value[-1]) if len(pairs.value) else None,
            "max_locked_pairs": system.closing.max_locked_pairs if system else None,
            "required_locked_pairs": system.capture.required_locked_pairs if system else None,
            "mouth_area_m2": float(data.trigger.message.mouth_area) if data.trigger else None,
            "net_debris_distance_m": _told(data.final, "net_debris_distance") if data.hold else _last(distance),
            "smallest_net_debris_distance_m": float(distance.value.min()) if len(distance.value) else None,
            "trigger_s": start.trigger_s if start else None,
            "closing_began_ticks_after_trigger": start.ticks if start else None,
            "decisions_taken_over": decisions,
            "late_decisions": [
                {
                    "sequence": each.sequence,
                    "decided_s": float(data.seconds(each.decided_ns)),
                    "mu": each.mu,
                    "ticks": each.ticks,
                }
                for each in late
            ],
            "phases": [
                {"phase": phase.name, "from_s": begin, "to_s": end, "reason": reason}
                for phase, begin, end, reason in phase_spans(data)
            ],
            "error_source": error_source(data),
            "per_mu": [vars(report(data, mu)) for mu in sorted(data.mus)],
            "messages": sum(topic.messages for topic in topics),
            "never_arrived": _sum_of_known(topic.never_arrived for topic in topics),
            "topics": {
                topic.name: {key: value for key, value in vars(topic).items() if key != "name"} for topic in topics
            },
            "problems": remarks(data),
        }
    )


def verdict(data: MissionData) -> str:
    """One sentence on how it ended."""
    if data.final:
        return data.final.message.verdict
    last = data.phases[-1] if data.phases else None
    if last and last.phase in (Phase.MISSED, Phase.ABORTED):
        return f"{last.phase.name.lower()}: {last.reason or 'no reason given'}"
    return "no verdict in this bag" + (f": it ends in phase {last.phase.name}" if last else "")


def _last(values: Curve) -> float | None:
    return float(values.value[-1]) if len(values.value) else None


def _told(assessment: Assessment | None, name: str) -> float | None:
    """A number of an assessment, NaN where it is not known."""
    return None if assessment is None else float(getattr(assessment.message, name))


def remarks(data: MissionData) -> list[str]:
    """What is wrong with the bag, what is missing, what was left out."""
    bad = [f"{topic}: {count} messages do not fit their type" for topic, count in sorted(data.undecodable.items())]
    torn = [f"the bag is damaged: {problem}" for problem in data.problems]
    return torn + bad + nonfinite(data) + missing(data)


def text(content: dict[str, Any]) -> str:
    """The table as text.

    Args:
        content: from :func:`summary`.
    """
    facts = [f"system {content['system']}"] if content["system"] else []
    facts += [f"{content['mus']} units"]
    facts += [f"{name} {content[name]}" for name in ("policy", "seed", "pace") if content[name]]
    facts += [f"commit {content['commit'][:12]}"] if content["commit"] else []
    lines = [content["bag"], ", ".join(facts), "", content["verdict"]]
    if content["hold_verdict"] is not None:
        flown = any(phase["phase"] == Phase.HOLDING.name for phase in content["phases"])
        how = f" ({conditions(content['hold_s'], content['tow_n'])})" if flown else ""
        lines.append(content["hold_verdict"] + how)
    lines += [
        f"  {name:<28}{value}"
        for name, value in (
            ("CQI", _number(content["cqi"], 2) + _later(content, "hold_cqi", 2)),
            ("CQI with the units counted", _number(content["cqi_all"], 2) + _later(content, "hold_cqi_all", 2)),
            ("MCQI", _number(content["mcqi"], 2) + _later(content, "hold_mcqi", 2)),
            ("enclosed", _yes(content["enclosed"]) + _later(content, "hold_enclosed")),
            ("held", _yes(content["held"])),
            ("largest load of a thread", _percent(content["max_load_share"], " of its strength")),
            ("largest contact force", _number(content["max_contact_force_n"], 0, " N")),
            ("locked pairs", pairs_text(content)),
            ("trigger", _number(content["trigger_s"], 2, " s after launch")),
            ("closing began", began(content)),
            ("decisions while closing", decisions(content)),
            ("mouth area at the trigger", _number(content["mouth_area_m2"], 1, " m2")),
            (
                "net to debris at the end",
                _number(content["net_debris_distance_m"], 2, " m")
                + _later(content, "hold_net_debris_distance_m", 2, " m"),
            ),
        )
    ]
    lines += ["", "phase        from [s]    to [s]"]
    for phase in content["phases"]:
        lines.append(
            f"{phase['phase'].lower():<11}{phase['from_s']:>10.2f}{phase['to_s']:>10.2f}  {phase['reason']}".rstrip()
        )
    if content["per_mu"]:
        lines += ["", *_mu_table(content)]
    lines += ["", *_topic_table(content)]
    if content["problems"]:
        lines += ["", *(f"note: {remark}" for remark in content["problems"])]
    return "\n".join(lines)


def _mu_table(content: dict[str, Any]) -> list[str]:
    lines = [
        " MU   fuel [kg]  at trigger   max error [m]   rms error   while closing   saturated   impulse [N s]",
    ]
    for row in content["per_mu"]:
        share = row["saturated_share"]
        cells = (
            _number(row["fuel_kg"], 4), _number(row["fuel_at_trigger_kg"], 4), _number(row["max_error_m"], 3),
            _number(row["rms_error_m"], 3), _number(row["max_closing_error_m"], 2),
            "-" if share is None else f"{100.0 * share:.1f} %", _number(row["impulse_n_s"], 1),
        )  # fmt: skip
        widths = (12, 12, 16, 12, 16, 12, 16)
        lines.append(f"{row['mu']:>3}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True)))
    fuels = [row["fuel_kg"] for row in content["per_mu"]]
    if fuels and None not in fuels:
        lines.append(f"all{sum(fuels):>12.4f}")
    lines.append(
        f"errors: {content['error_source']}, from {SETTLED_S:g} s after launch to the trigger; then while closing"
    )
    return lines


def _topic_table(content: dict[str, Any]) -> list[str]:
    lost = content["never_arrived"]
    losses = "what was lost on the way is not counted" if lost is None else f"{lost or 'none'} lost on the way"
    lines = [
        f"{content['messages']} messages on {len(content['topics'])} topics, {losses}",
        f"{'topic':<24}{'messages':>18}{'Hz':>7}{'longest gap [s]':>18}{'gaps':>7}{'lost':>7}",
    ]
    for name, row in _grouped(content["topics"]).items():
        lines.append(f"{name:<24}{row['messages']:>18}{row['rate']:>7}{row['gap']:>18}{row['gaps']:>7}{row['lost']:>7}")
    return lines


def _grouped(topics: dict[str, dict[str, Any]]) -> dict[str, dict[str, str]]:
    """What stands in each line; the MUs' topics of one kind share a line, from the smallest to the largest number."""
    kinds: dict[str, list[dict[str, Any]]] = {}
    numbers: dict[str, list[int]] = {}
    for name, row in topics.items():
        found = _MU_TOPIC.match(name)
        kind = f"/muN/{found[2]}" if found else name
        kinds.setdefault(kind, []).append(row)
        if found:
            numbers.setdefault(kind, []).append(int(found[1]))
    result = {}
    for kind, rows in kinds.items():
        mus = sorted(numbers.get(kind, []))
        label = kind.replace("muN", f"mu{mus[0]}..{mus[-1]}" if len(mus) > 1 else f"mu{mus[0]}") if mus else kind
        counts = [row["messages"] for row in rows]
        few, many = min(counts), max(counts)
        result[label] = {
            "messages": (str(few) if few == many else f"{few} to {many}") + (" each" if len(rows) > 1 else ""),
            "rate": _number(_extreme(min, rows, "rate_hz"), 1),
            "gap": _number(_extreme(max, rows, "longest_gap_s"), 2),
            "gaps": str(sum(row["gaps"] for row in rows) or "-"),
            "lost": str(_sum_of_known(row["never_arrived"] for row in rows) or "-"),
        }
    return result


def began(content: dict[str, Any]) -> str:
    """When closing began, in words."""
    ticks = content["closing_began_ticks_after_trigger"]
    if not ticks:
        return "-"
    start = ClosingStart(content["trigger_s"], ticks)
    last = ", ".join(str(mu) for mu, count in ticks.items() if count == start.most)
    return f"{delay_text(start)} after the trigger" + ("" if start.least == start.most else f", last MU {last}")


def decisions(content: dict[str, Any]) -> str:
    """How many of the decisions while closing came late, in words."""
    count, late = content["decisions_taken_over"], content["late_decisions"]
    if not count:
        return "-"
    most = max((row["ticks"] for row in late), default=0)
    return f"{len(late)} of {count} late, by {most} ticks at most" if late else "all in time"


def _sum_of_known(counts: Iterable[int | None]) -> int | None:
    known = [count for count in counts if count is not None]
    return sum(known) if known else None


def _extreme(which: Callable[..., float | None], rows: list[dict[str, Any]], key: str) -> float | None:
    return which((row[key] for row in rows if row[key] is not None), default=None)


def pairs_text(content: dict[str, Any]) -> str:
    """Locked pairs, of how many, and what is needed."""
    if content["locked_pairs"] is None:
        return "-"
    if content["max_locked_pairs"] is None:
        return str(content["locked_pairs"])
    needed = content["required_locked_pairs"]
    return f"{content['locked_pairs']} of {content['max_locked_pairs']}, at least {needed} needed"


def _later(content: dict[str, Any], key: str, digits: int = 0, unit: str = "") -> str:
    """What has become of it at the end of the hold test; empty without one."""
    value = content[key]
    if value is None:
        return ""
    return f", after the hold test {_yes(value) if isinstance(value, bool) else _number(value, digits, unit)}"


def _yes(value: bool | None) -> str:
    return "-" if value is None else "yes" if value else "no"


def _percent(share: float | None, of: str) -> str:
    return "-" if share is None else f"{100.0 * share:.1f} %{of}"


def _number(value: float | None, digits: int, unit: str = "") -> str:
    return "-" if value is None else f"{value:.{digits}f}{unit}"


def _finite(value: Any) -> Any:
    """JSON knows no NaN."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
