"""What ``--view`` takes, and the command line of ``view_mission.py``: standard library only, as it is read before any
set-up.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from tethernet_core.shown import SHORT, shown
from tethernet_core.subcommand import Parser

PROGRAM = "view_mission.py"
WINDOW, WEB, FILE = "window", "web", "file"
SUFFIX = ".rrd"
ALLOWED = f"{WINDOW}, {WEB}, or the name of a file that ends in {SUFFIX}"

EXIT_STATUS = (
    "exit status: 0 done, 1 no bag, or one that cannot be shown (the reason is printed), 2 bad usage, 130 interrupted"
)
HELP = (
    f"{WINDOW}: in Rerun's window, which stays open; {WEB}: for a browser on this machine, until Ctrl-C; "
    f"FILE{SUFFIX}: recorded"
)


class Target(NamedTuple):
    """Where a mission is shown."""

    kind: str
    """WINDOW, WEB or FILE."""
    path: Path | None = None
    """The file, absolute."""


def view_target(word: str) -> Target:
    """Where ``--view WORD`` shows a mission.

    Raises:
        ValueError: what was given, and what is allowed.
    """
    if word in (WINDOW, WEB):
        return Target(word)
    given = shown(word, SHORT)
    if not word.endswith(SUFFIX) or Path(word).name == SUFFIX:
        raise ValueError(f"{given}: cannot be meant; allowed: {ALLOWED}")
    path = Path(word).expanduser().absolute()
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        pass
    except (OSError, ValueError):  # such as a name that is too long, or with a NUL in it
        raise ValueError(f"{given}: can be no file's name; allowed: {ALLOWED}") from None
    if path.is_dir():
        raise ValueError(f"{given}: is a folder; allowed: {ALLOWED}")
    if not path.parent.is_dir():
        raise ValueError(f"{given}: its folder does not exist; allowed: a file in a folder that is there")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise ValueError(f"{given}: cannot be written; allowed: a file in a folder that you may write to")
    return Target(FILE, path)


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """Read the command line of ``view_mission.py``.

    Args:
        argv: the words after the program's name.

    Raises:
        SystemExit: status 2 for bad usage, with a message on stderr; 0 for --help.
    """
    description = "Show the bag of a mission in three dimensions and as time series."
    parser = Parser(PROGRAM, description, EXIT_STATUS, wrapped=True)
    add_arguments(parser)
    return parser.parse_args(argv)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    add("bag", type=Path, metavar="BAG", help="a run's folder, a bag's folder, a .mcap or .db3 file; it is only read")
    add("--view", type=_target, default=Target(WINDOW), metavar="window|web|FILE.rrd", help=HELP)
    add("--system", metavar="NAME|FILE", help="what was flown, where the bag does not say so")


def _target(word: str) -> Target:
    try:
        return view_target(word)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
