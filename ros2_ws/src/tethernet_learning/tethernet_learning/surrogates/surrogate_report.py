"""Scores of surrogates as tables for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def short(judged: Mapping[str, dict[str, Any]]) -> str:
    """Scores of one surrogate for each system, beside those of a model that always says "captured", as Markdown.

    Args:
        judged: scores by name of the system, see :func:`.surrogate_scores.scores`.
    """
    rows: dict[str, list[str]] = {}
    for r in judged.values():
        every = r["all"]
        cells = {
            "test: not captured; closing began, of these not captured": (
                f"{every['failures']} of {every['scenarios']}; {r['scenarios']}, {r['failures']}"
            ),
            "all: right (95 %), balanced": share(every).replace(" |", ","),
            "the same, always captured": (
                f"{100 * every['always_captured']:.1f} %, {100 * every['always_captured_balanced']:.1f} %"
            ),
            "closing began: right (95 %), balanced": share(r).replace(" |", ","),
            "the same by probability": f"{100 * r['right_by_probability']:.1f} %",
            "the same, always captured, closing began": f"{100 * r['always_captured']:.1f} %",
            "Brier score; calibration error": f"{r['brier']:.3f}; {r['calibration_error']:.3f}",
            "pairs told exactly": f"{100 * r['pairs_right']:.0f} %",
            "error of CQI below 20, of locked pairs": (
                f"{r['cqi_error_mean']:.2f} ± {r['cqi_error_std']:.2f}, "
                f"{r['pairs_error_mean']:.2f} ± {r['pairs_error_std']:.2f}"
            ),
        }
        for name, cell in cells.items():
            rows.setdefault(name, []).append(cell)
    head = [
        "| shipped surrogate | " + " | ".join(judged) + " |",
        "|---" * (len(judged) + 1) + "|",
    ]
    return "\n".join([*head, *(f"| {name} | " + " | ".join(cells) + " |" for name, cells in rows.items()), ""])


def table(results: dict[str, dict[str, Any]], best: str, about: dict[str, Any]) -> str:
    """The comparison as Markdown."""
    first = next(iter(results.values()))
    every = first["all"]
    lines = [
        f"# Surrogates of {about['system']}",
        "",
        f"{about['train_scenarios']} training scenarios, {100 * about['train_failure_share']:.1f} % not captured; "
        f"tested on {every['scenarios']} unseen ones, {every['failures']} of them "
        f"({100 * every['failures'] / every['scenarios']:.1f} %) not captured. In {first['scenarios']} of these "
        f"closing began, {first['failures']} of them were not captured; where it never begins nobody asks the "
        'surrogate. The last line is a model that always says "captured".',
        "",
        "| model | all: right (95 %) | balanced | closing began: right, by CQI and pairs (95 %) | balanced | right, by "
        "probability | balanced | Brier | calibration error | CQI below 20: error, mean ± std | pairs: error, mean ± "
        "std | pairs exactly right | one prediction | members | Brier on what they have not seen | trained in |",
        "|---" * 16 + "|",
    ]
    for name, r in results.items():
        lines.append(
            f"| {name}{' (default)' if name == best else ''} | {share(r['all'])} | {share(r)} | "
            f"{100 * r['right_by_probability']:.1f} % | {100 * r['balanced_by_probability']:.1f} % | {r['brier']:.3f} "
            f"| {r['calibration_error']:.3f} | {r['cqi_error_mean']:.2f} ± {r['cqi_error_std']:.2f} | "
            f"{r['pairs_error_mean']:.2f} ± {r['pairs_error_std']:.2f} | {100 * r['pairs_right']:.1f} % | "
            f"{r['inference_ms']:.2f} ms | {r['members']} | {r['validation_brier']:.4f} | {r['seconds']:.0f} s |"
        )
    lines.append(
        f"| always captured | {100 * every['always_captured']:.1f} % | "
        f"{100 * every['always_captured_balanced']:.1f} % | {100 * first['always_captured']:.1f} % | "
        + f"{'- | ' * 12}".rstrip()
    )
    return "\n".join(
        [
            *lines,
            "",
            f"The default is the best by Brier score on the parts of the data that members have not seen: {best}.",
            "",
        ]
    )


def share(facts: dict[str, Any]) -> str:
    """What was told rightly with its interval, and the balanced share, as two cells."""
    low, high = (100 * bound for bound in facts["right_95"])
    return f"{100 * facts['right']:.1f} % ({low:.1f} to {high:.1f}) | {100 * facts['balanced']:.1f} %"
