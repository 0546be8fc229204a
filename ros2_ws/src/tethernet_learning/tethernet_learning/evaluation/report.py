"""The evaluation for people: a table beside the paper's figures, and box plots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tethernet_core.aiming import FALLBACK
from tethernet_core.capture_quality import tight
from tethernet_learning.campaigns import pictures
from tethernet_learning.campaigns.comparison import Comparison
from tethernet_learning.campaigns.statistics import Estimate, summarise
from tethernet_learning.evaluation.policy_scores import Evaluated
from tethernet_learning.paper_figures import PAPER, PaperFigures
from tethernet_planner import policies
from tethernet_planner.inference import shipped_models

_G = 1e3


def label(policy: str) -> str:
    """A policy's name for tables and plots: of a file the last two parts of its path."""
    return "/".join(Path(policy).parts[-2:]) if shipped_models.means_file(policy) else policy


def table(evaluated: Sequence[Evaluated]) -> str:
    """Markdown, one table for each system; in brackets 95 % intervals."""
    return "\n".join(line for e in evaluated for line in (*_system(e), ""))


def _system(e: Evaluated) -> list[str]:
    paper, compared = PAPER.get(e.system.name), e.compared()
    names = list(e.outcomes)
    count = len(e.outcomes[policies.NOMINAL])
    lines = [
        " | ".join(
            [
                f"| {e.system.name}, {count} scenarios",
                *map(label, names),
                *(["the paper's trained policy"] if paper else []),
            ]
        )
        + " |",
        "|---" * (len(names) + (2 if paper else 1)) + "|",
    ]
    columns = [_column(e, name, compared.get(name)) for name in names] + ([_paper(paper)] if paper else [])
    lines += [f"| {row} | " + " | ".join(column[row] for column in columns) + " |" for row in columns[0]]
    misses = [
        f"- {label(name)} at {case.scenario.debris_position}: {outcome.verdict}"
        for name in names
        for case, outcome in zip(e.cases[name], e.outcomes[name], strict=True)
        if not outcome.captured
    ]
    return [*lines, *(["", f"Not captured with {e.system.name}:", "", *misses] if misses else [])]


def _column(e: Evaluated, name: str, against: Comparison | None) -> dict[str, str]:
    summary = summarise(e.outcomes[name])
    fallen_back = sum(case.policy == FALLBACK for case in e.cases[name])
    column = {
        "captured, %": _text(summary.success, 100.0, 1),
        "held, %": _text(summary.held, 100.0, 1),
        "the closed net goes round all of the debris at the verdict, %": _text(summary.enclosed, 100.0, 1),
        "fuel per MU, g": _text(summary.fuel_kg, _G, 2),
        "of it until the trigger, g": _text(summary.fuel_at_trigger_kg, _G, 2),
        "less fuel than nominal, mean of pairs, %": "-",
        "the same where both captured, %": "-",
        "captured by both / nominal only / this only / neither": "-",
        "CQI, mean; below the threshold": _quality(e, name, "cqi"),
        "CQI with the MUs counted, mean; below the threshold": _quality(e, name, "cqi_all"),
        "MCQI, mean": "-" if summary.mcqi is None else f"{summary.mcqi:.2f}",
        "largest load, % of strength": "-" if summary.load_share is None else f"{100.0 * summary.load_share:.1f}",
        "locked pairs: missions": ", ".join(f"{pairs}: {n}" for pairs, n in summary.locked_pairs.items()),
        "in error; nominal points instead": f"{summary.errors}; {fallen_back}",
    }
    if against is not None:
        column["less fuel than nominal, mean of pairs, %"] = _text(against.reduction, 100.0, 2)
        column["the same where both captured, %"] = _text(against.reduction_where_captured, 100.0, 2)
        counts = (against.both, against.only_nominal, against.only_policy, against.neither)
        column["captured by both / nominal only / this only / neither"] = " / ".join(map(str, counts))
    return column


def _quality(e: Evaluated, name: str, kind: str) -> str:
    """Mean of one of the two indices, and in how many missions it is below the threshold."""
    known = [value for outcome in e.outcomes[name] if math.isfinite(value := getattr(outcome, kind))]
    if not known:
        return "-"
    below = sum(tight(value, e.system) for value in known)
    return f"{sum(known) / len(known):.2f}; {below} of {len(e.outcomes[name])}"


def _paper(paper: PaperFigures) -> dict[str, str]:
    told = {
        "captured, %": f"{100.0 * paper.success:.0f}",
        "fuel per MU, g": f"{_G * paper.fuel_per_mu_kg:.0f}",
        "less fuel than nominal, mean of pairs, %": f"{100.0 * paper.reduction:g}",
    }
    return _Told(told)


class _Told(dict[str, str]):
    """What the paper does not tell is a dash."""

    def __missing__(self, _key: str) -> str:
        return "-"


def _text(estimate: Estimate | None, scale: float, digits: int) -> str:
    if estimate is None:
        return "-"
    value, low, high = (f"{scale * x:.{digits}f}" for x in (estimate.value, estimate.low, estimate.high))
    return value if low == "nan" else f"{value} ({low} to {high})"


def figure(evaluated: Sequence[Evaluated]) -> Any:
    """Box plots: fuel of all policies, and what each saves against the nominal points, a row for each system."""
    made = pictures.new_figure(10.0, 3.8 * len(evaluated))
    axes = made.subplots(len(evaluated), 2, squeeze=False)
    for (fuel, saved), e in zip(axes, evaluated, strict=True):
        units = max(e.system.unit_count, 1)
        good = {
            label(n): [_G * sum(o.fuel_kg) / units for o in flown if not o.error] for n, flown in e.outcomes.items()
        }
        title, paper = f"{e.system.name}: fuel per unit [g]", PAPER.get(e.system.name)
        if paper is not None:
            told = _G * paper.fuel_per_mu_kg
            title += f"\n(dashed: mean of the paper's trained policy, {told:.0f} g)"
            fuel.axhline(told, color="0.5", linestyle="--")
        _boxes(fuel, good, title)
        pairs = {label(name): [_G * kg for kg in against.saved_kg] for name, against in e.compared().items()}
        _boxes(saved, pairs, f"{e.system.name}: less fuel than nominal, all units [g]\n(triangles: means)")
        saved.axhline(0.0, color="0.5", linewidth=0.8)
    return made


def _boxes(axes: Any, values: dict[str, list[float]], title: str) -> None:
    axes.set_title(title)
    shown = {name: numbers for name, numbers in values.items() if numbers}
    if not shown:
        axes.text(0.5, 0.5, "nothing to compare", ha="center", va="center", transform=axes.transAxes)
        return
    axes.boxplot(list(shown.values()), tick_labels=list(shown), showmeans=True)
