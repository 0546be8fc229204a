"""``tethernet validate``: run validation cases, show how far the engine is from their references."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tethernet_core.atomic_file import write_text
from tethernet_core.errors import InputError
from tethernet_core.near_match import near_match
from tethernet_core.parameters import load
from tethernet_core.subcommand import Parser, Subcommand
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.validation import report
from tethernet_sim.validation.cases import CASES

MISSED = 1
METAVAR = "physics.NAME=VALUE"


def run(options: argparse.Namespace) -> int:
    """Run the cases that are named, or all; gives 1 when one misses its tolerance."""
    if options.list:
        width = max(map(len, CASES))
        print("\n".join(f"{name:<{width}}  {case.title} ({case.reference})" for name, case in CASES.items()))
        return 0
    names = list(dict.fromkeys(options.cases)) or list(CASES)
    for name in names:
        if name not in CASES:
            raise InputError(
                f"{name}: no such case{near_match(name, CASES)}; allowed: {', '.join(CASES)}, or convergence"
            )
    physics = replaced(options.set)
    folder: Path | None = options.output
    if folder is not None:
        _make(folder)
    cells: list[tuple[str, ...]] = []
    lines: list[str] = []
    missed: list[str] = []
    for number, name in enumerate(names, start=1):
        case = CASES[name]
        print(f"{number} of {len(names)}: {name}, {case.title}", file=sys.stderr, flush=True)
        began = time.monotonic()
        result = case.run(physics)
        lines.append(report.json_line(name, case, result, time.monotonic() - began))
        cells += report.rows(name, result)
        if not result.passed:
            missed.append(name)
        if options.json:
            print(lines[-1], flush=True)
        if folder is not None:
            report.draw(result, folder / f"{name}.png")
            write_text(folder / report.RESULTS, "\n".join(lines) + "\n")
            write_text(folder / report.TABLE, "\n".join(report.table(cells)) + "\n")
    if not options.json:
        print("\n".join(report.table(cells)))
    if missed:
        print(f"{len(missed)} of {len(names)} cases miss a tolerance: {', '.join(missed)}", file=sys.stderr)
        return MISSED
    return 0


def replaced(words: Sequence[str]) -> dict[str, Any]:
    """Physical parameters from words, each physics.NAME=VALUE.

    Raises:
        InputError: for a word of another form.
        ParameterError: for an unknown name, a wrong type or a value out of range.
    """
    import yaml

    values: dict[str, Any] = {}
    for word in words:
        name, equals, value = word.partition("=")
        part, dot, key = name.partition(".")
        if not (equals and dot and part == "physics"):
            raise InputError(f"--set {word}: allowed: {METAVAR}")
        try:
            values[key] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            raise InputError(f"--set {word}: {value!r} is no value: {error}") from error
    load(PhysicsParameters, values)
    return values


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--output {folder}: cannot be made ({error}); name another folder") from error


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}; default all")
    add(
        "--output", type=Path, metavar="FOLDER",
        help=f"for {report.TABLE}, {report.RESULTS} (a line each case) and a picture each case",
    )  # fmt: skip
    add(
        "--set", nargs="+", action="extend", default=[], metavar=METAVAR,
        help="physical parameters in the place of the cases' own: physics.friction_coefficient=0.1",
    )  # fmt: skip
    add("--json", action="store_true", help="print a line of JSON for each case in the place of the table")
    add("--list", action="store_true", help="only say which cases there are")


COMMAND = Subcommand(
    "Compare the engine with analytic solutions, a published set-up and the figures of the literature. Each case is "
    "described in docs/validation.",
    ("", "sag swing --output validation", "--list"), run, _add_arguments,
    notes="How far captures depend on time step, contact, friction, threads: tethernet validate convergence.",
    exit_status="exit status: 0 all within their tolerances, 1 some not, or a fault, 2 bad usage, 130 interrupted",
)  # fmt: skip
