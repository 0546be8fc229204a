"""The command line of ``analyse_mission.py``: standard library only, so that bad usage is refused before any set-up."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from tethernet_core.subcommand import Parser

PROGRAM = "analyse_mission.py"
FORMATS = ("png", "svg", "pdf")

EXIT_STATUS = "exit status: 0 done, 1 no bag, or one that cannot be analysed (the reason is printed), 2 bad usage"


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """Read the command line.

    Args:
        argv: the words after the program's name.

    Raises:
        SystemExit: status 2 for bad usage, with a message on stderr; 0 for --help.
    """
    description = "Make a table, pictures and a report (one HTML file) from the bag of a mission, whole or torn."
    parser = Parser(PROGRAM, description, EXIT_STATUS, wrapped=True)
    add_arguments(parser)
    parser.add_argument(
        "--salvage",
        action="store_true",
        help="rewrite a torn bag into a whole one in DIR (default: BAG_salvaged), and do nothing else",
    )
    return parser.parse_args(argv)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    what = "a run's folder, a bag's folder, a .mcap or .db3 file, split or compressed too; it is only read"
    add("bag", type=Path, metavar="BAG", help=what)
    add("--output", type=Path, metavar="DIR", help="folder for all files; default: analysis in the run's folder")
    add("--format", choices=FORMATS, default="png", help="of the pictures; default png")
    add("--json", action="store_true", help="write the table to DIR/analysis.json, too")
    add("--no-plots", action="store_true", help="the table only: no pictures, no report")
