"""A small set-up for the tests of the real one's machinery: steps that write a line each, in a folder of their own.

``python -m tests.unit.setup_steps FOLDER [STEP]`` does it, and lingers in STEP with a tool that runs for a minute.
"""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from bootstrap.environment import ensure
from bootstrap.fingerprint import of_contents
from bootstrap.places import Places
from bootstrap.report import Report
from bootstrap.steps import Step
from bootstrap.tools import run_tool

NAMES = ("venv", "packages", "sources", "messages")
INSTALLING = ("venv", "packages")


def places_in(folder: Path) -> Places:
    """An environment in ``folder`` whose steps depend on files of their names there."""
    return Places(folder, folder / ".venv")


def done(folder: Path) -> list[str]:
    """The steps that have been run, in order."""
    journal = folder / "journal"
    return journal.read_text().split() if journal.exists() else []


def steps(lingering: str = "") -> list[Step]:
    """Steps with the real ones' names, the first two installing."""
    return [_step(name, name == lingering) for name in NAMES]


def _step(name: str, lingers: bool) -> Step:
    def run(places: Places, report: Report) -> None:
        if name == "venv":
            places.python.parent.mkdir()
            places.python.symlink_to(sys.executable)
        if lingers:
            # A child of a child, as with colcon and its compilers.
            linger = "import subprocess, sys; subprocess.run(['sleep', '60']); sys.exit(1)"
            run_tool([sys.executable, "-c", linger], places, advice="")
        with open(places.root / "journal", "a") as journal:
            journal.write(f"{name}\n")

    return Step(name, f"step {name}", lambda p: of_contents([p.root / name]), run, installs=name in INSTALLING)


if __name__ == "__main__":
    # A shell without job control starts what it sends to the background with SIGINT ignored; tests run there too.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    ensure(places_in(Path(sys.argv[1])), steps(*sys.argv[2:]), Report())
