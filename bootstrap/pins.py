"""``python3 -m bootstrap.pins``: pin every package of the environment, the indirect ones too.

Installs what the other requirement files ask for into a temporary environment, without the present constraints, and
writes down in requirements/constraints.txt what came.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import venv
from pathlib import Path

from .places import ROOT
from .steps import INSTALL

HEAD = """\
# Every package of the environment with its version, the indirect ones too: what was tested together.
# Written by `make lock`; run that after a change of the other files here, then the tests.
"""
# view.txt is not among them: it pins itself what it adds, so that another version of a viewer does not make every
# environment anew.
ASKED_FOR = ("run", "build", "test", "bench", "learning", "cluster", "ros2cli")

# A "+cpu" at the end of a version tells who built it, and no package index has it.
# The ROS wheels carry further metadata folders, one for each message package: without INSTALLER, no packages of pip.
LIST = """
import importlib.metadata, re
found = importlib.metadata.distributions()
found = [(d.metadata["Name"], d.version) for d in found if d.read_text("INSTALLER")]
pins = {re.sub(r"[-_.]+", "-", name).lower(): version.partition("+")[0] for name, version in found}
print("\\n".join(f"{name}=={pins[name]}" for name in sorted(pins)))
"""


def main() -> None:
    """Write the file."""
    requirements = ROOT / "requirements"
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = Path(folder, "bin", "python")
        subprocess.run([python, "-m", "pip", "install", "-r", requirements / "installer.txt"], check=True)
        files = [word for name in ASKED_FOR for word in ("-r", requirements / f"{name}.txt")]
        subprocess.run([python, "-m", "pip", *INSTALL, *files], check=True)
        subprocess.run([python, "-m", "pip", "check"], check=True)
        pins = subprocess.run([python, "-c", LIST], check=True, capture_output=True, text=True).stdout
    (requirements / "constraints.txt").write_text(HEAD + pins)
    print(f"{len(pins.splitlines())} packages pinned", file=sys.stderr)


if __name__ == "__main__":
    main()
