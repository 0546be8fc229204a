"""``analyse_mission.py`` after the set-up: reads a bag, prints a table, makes pictures and a report."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import command_start

    command_start()

import json
import os
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tethernet_bringup.analysis import arguments
from tethernet_bringup.bags.errors import BagError
from tethernet_core.command import command

DONE, FAULT = 0, 1


@command
def main(argv: Sequence[str] | None = None) -> int:
    """Analyse a mission.

    Args:
        argv: the words after the program's name; default: this process'.

    Returns:
        Exit status: 0 done, 1 no bag or one that cannot be analysed, 2 bad usage.
    """
    try:
        options = arguments.parse(sys.argv[1:] if argv is None else argv)
    except SystemExit as exit_:
        return int(exit_.code or 0)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a name may hold what the terminal cannot show
            stream.reconfigure(errors="backslashreplace")
    try:
        if options.salvage:
            from tethernet_bringup.bags import salvage

            salvage.run(options.bag, options.output)
        else:
            run(options)
    except BagError as error:
        print(f"{arguments.PROGRAM}: {error}", file=sys.stderr)
        return FAULT
    except BrokenPipeError:  # the reader of our output has seen enough, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return DONE


def run(options: Namespace) -> None:
    """Print the table and write the pictures.

    Args:
        options: see :mod:`.arguments`.

    Raises:
        BagError: when there is no bag, or one that cannot be analysed.
    """
    from tethernet_bringup.analysis.mission_data import load
    from tethernet_bringup.analysis.table import summary, text
    from tethernet_bringup.bags.reader import open_bag

    bag = open_bag(options.bag)
    data = load(bag)
    content = summary(data, options.bag)
    print(text(content), flush=True)
    folder = options.output or default_output(options.bag)
    files = []
    if options.json:
        files.append(_write_json(content, folder / "analysis.json"))
    if not options.no_plots:
        from tethernet_bringup.analysis import pictures, report_page

        files += pictures.make(data, bag, folder, options.format)
        if files or data.states:
            files.append(report_page.write(data, bag, options.bag, folder))
    if files:
        print(f"\nwritten to {folder}: {', '.join(path.name for path in files)}")
    elif not options.no_plots:
        print("\nnothing was flown: no pictures")


def default_output(bag: Path) -> Path:
    """The folder ``analysis`` in the run's folder, or beside a bag that lies alone.

    Args:
        bag: as the user gave it.
    """
    folder = bag.absolute()
    if folder.is_file():
        folder = folder.parent
    if folder.name == "bag" or folder.name.startswith("bag_"):
        folder = folder.parent
    return folder / "analysis"


def _write_json(content: dict[str, Any], path: Path) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise BagError(f"cannot write {path}: {error.strerror}; give another folder with --output") from error
    return path


if __name__ == "__main__":
    sys.exit(main())
