"""``python3 -m bootstrap.pins``: pin every package of the environments, the indirect ones too.

pip resolves what the requirement files ask for, without the present locks, and reports what it would install; that
goes into requirements/constraints.txt, and for the documentation's own environment into requirements/docs-lock.txt.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import venv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .clashes import normal
from .places import ROOT
from .steps import INSTALL

HEAD = """\
# Every package of the environment with its version, the indirect ones too: what was tested together.
# Written by `make lock`; run that after a change of the other files here, then the tests.
"""
DOCS_HEAD = "# Every package of the documentation's environment, the indirect ones too. Written by `make lock`.\n"
# view.txt is not among them: it pins itself what it adds, so that another version of a viewer does not make every
# environment anew.
ASKED_FOR = ("installer", "run", "build", "test", "bench", "learning", "cluster", "ros2cli")


def main() -> None:
    """Write the files."""
    requirements = ROOT / "requirements"
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = Path(folder, "bin", "python")
        # empy has no wheel: pip asks the installed setuptools what it needs.
        subprocess.run([python, "-m", "pip", "install", "-r", requirements / "installer.txt"], check=True)
        for asked, lock, head in ((ASKED_FOR, "constraints", HEAD), (("docs",), "docs-lock", DOCS_HEAD)):
            found = lines(_resolved(python, [requirements / f"{name}.txt" for name in asked]))
            (requirements / f"{lock}.txt").write_text(head + "".join(f"{line}\n" for line in found))
            print(f"{lock}.txt: {len(found)} packages pinned", file=sys.stderr)


def _resolved(python: Path, files: Sequence[Path]) -> dict[str, Any]:
    """What pip would install into an empty environment, as ``pip install --report`` tells it."""
    report = python.with_name("report.json")
    asked = [word for file in files for word in ("-r", file)]
    dry: list[str | Path] = ["--dry-run", "--ignore-installed", "--quiet", "--report", report]
    subprocess.run([python, "-m", "pip", *INSTALL, *dry, *asked], check=True)
    resolved: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    return resolved


def lines(resolved: dict[str, Any]) -> list[str]:
    """A lock's lines.

    Args:
        resolved: pip's installation report, format 1.
    """
    packages = (package["metadata"] for package in resolved["install"])
    # A "+cpu" at the end of a version tells who built it, and no package index has it.
    return sorted(f"{normal(package['name'])}=={package['version'].partition('+')[0]}" for package in packages)


if __name__ == "__main__":
    main()
