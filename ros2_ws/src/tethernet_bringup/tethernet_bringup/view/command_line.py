"""``view_mission.py`` after the set-up: shows a recorded mission as ``run_mission.py --view`` shows one in flight."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import command_start

    command_start()

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tethernet_bringup.bags.errors import BagError
from tethernet_bringup.view import arguments
from tethernet_bringup.view.arguments import FILE, WEB
from tethernet_core.command import FAULT, USAGE, command, complain
from tethernet_core.errors import FaultError, InputError

if TYPE_CHECKING:
    from tethernet_bringup.bags.reader import BagReader
    from tethernet_core.system import System


@command
def main(argv: Sequence[str] | None = None) -> int:
    """Show a recorded mission.

    Args:
        argv: the words after the program's name; default: this process'.

    Returns:
        Exit status: 0 done, 1 no bag or one that cannot be shown, 2 bad usage.
    """
    try:
        options = arguments.parse(sys.argv[1:] if argv is None else argv)
    except SystemExit as exit_:
        return int(exit_.code or 0)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a name may hold what the terminal cannot show
            stream.reconfigure(errors="backslashreplace")
    try:
        run(options)
    except InputError as error:
        complain(f"error: {error}", arguments.PROGRAM)
        return USAGE
    except (FaultError, BagError) as error:
        complain(f"fault: {error}", arguments.PROGRAM)
        return FAULT
    return 0


def run(options: Namespace) -> None:
    """Show a bag where the options say.

    Args:
        options: see :mod:`.arguments`.

    Raises:
        FaultError: when Rerun is not installed, or what it shows cannot be written.
        InputError: for a window without a display, or a bag that does not say what was flown.
        BagError: when there is no bag, or none of a mission.
    """
    from tethernet_bringup.bags.reader import open_bag
    from tethernet_bringup.view import application
    from tethernet_core.parameters import load

    target = options.view
    application.check(target)
    bag = open_bag(options.bag)
    system = _system(bag, options)
    if target.kind == FILE:
        print(_show(bag, system, options.bag, str(target.path)))
        return
    from tethernet_bringup.view.settings import ViewerParameters

    shown = application.Application(target.kind, load(ViewerParameters).memory_mb)
    try:
        shown.await_start()
        print(_show(bag, system, options.bag, shown.address), flush=True)
    except BaseException:
        shown.stop()
        raise
    if target.kind == WEB:
        try:
            print(f"stays at {shown.page} until Ctrl-C", flush=True)
            shown.stay(lambda: False)
        except KeyboardInterrupt:
            pass  # as told
        finally:
            shown.stop()


def _system(bag: BagReader, options: Namespace) -> System:
    """What was flown: as the bag says, or else the user."""
    from tethernet_bringup.analysis.mission_data import load
    from tethernet_core.system import load_system

    if options.system is not None:
        return load_system(options.system)
    data = load(bag)
    if data.system is None:
        raise InputError(
            f"{options.bag} does not say what was flown{''.join(f'; {problem}' for problem in data.problems[-1:])}; "
            "give it: --system NAME|FILE"
        )
    return data.system


def _show(bag: BagReader, system: System, path: Path, output: str) -> str:
    """Draw all of it; what was done, for the user."""
    from tethernet_bringup.view.bag_source import BagSource
    from tethernet_bringup.view.drawing import Drawing
    from tethernet_bringup.view.recording import close, open_recording

    recording = open_recording(output, f"{system.name}, {path.absolute().name}")
    drawing, source, count, end_s = Drawing(recording, system), BagSource(bag, system), 0, 0.0
    for snapshot in source.snapshots():
        drawing.draw(snapshot)
        count, end_s = count + 1, snapshot.time_ns * 1e-9
    close(recording, output)
    unused = f"; {source.unused} messages could not be used" if source.unused else ""
    return f"{system.name}: {count} pictures of {end_s:.1f} s shown in {output}{unused}"


if __name__ == "__main__":
    sys.exit(main())
