"""Results of validation cases as a table, as JSON, and as pictures."""

from __future__ import annotations

import json
from pathlib import Path

from tethernet_sim.validation.case import Case, Result

RESULTS, TABLE = "results.jsonl", "results.md"
_HEAD = ("case", "quantity", "unit", "engine", "reference", "difference", "allowed", "")


def rows(name: str, result: Result) -> list[tuple[str, ...]]:
    """The cells of a case's quantities."""
    cells: list[tuple[str, ...]] = []
    for quantity in result.quantities:
        compared = quantity.reference is not None
        cells.append(
            (
                name,
                quantity.name,
                quantity.unit,
                f"{quantity.measured:.6g}",
                f"{quantity.reference:.6g}" if compared else "-",
                f"{quantity.difference:.2g}" if compared else "-",
                f"{quantity.tolerance:.2g}" if compared else "-",
                "reported" if not compared and quantity.passed else "ok" if quantity.passed else "MISSED",
            )
        )
    return cells


def table(cells: list[tuple[str, ...]]) -> list[str]:
    """Lines of a Markdown table that is aligned for reading too."""
    widths = [max(map(len, column)) for column in zip(_HEAD, *cells, strict=True)]
    lines = ["| " + " | ".join(f"{c:<{w}}" for c, w in zip(row, widths, strict=True)) + " |" for row in (_HEAD, *cells)]
    return [lines[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *lines[1:]]


def json_line(name: str, case: Case, result: Result, seconds: float) -> str:
    """A case as a line of JSON; ``seconds`` is what it took."""
    return json.dumps(
        {
            "case": name,
            "title": case.title,
            "reference": case.reference,
            "passed": result.passed,
            "quantities": [quantity.record() for quantity in result.quantities],
            "seconds": round(seconds, 2),
        },
        allow_nan=False,
    )


def draw(result: Result, path: Path) -> None:
    """Write the picture of a case.

    Raises:
        OSError: when it cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    result.draw(figure)
    figure.savefig(path, dpi=110)
