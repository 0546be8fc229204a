"""``make docs``: the documentation site, by a generator in an environment of its own, ``.venv.docs``.

Of its own, because a mission needs none of it, and because the generator reads docstrings without importing anything.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from . import fingerprint
from .places import ROOT

VENV = ROOT / ".venv.docs"
FAULT = 1


def main() -> int:
    """Build the site into ``site/``; every warning, a link that leads nowhere too, is an error."""
    asked, lock = ROOT / "requirements" / "docs.txt", ROOT / "requirements" / "docs-lock.txt"
    wanted, mark = fingerprint.of_contents([asked, lock], sys.version), VENV / "made_of"
    try:
        if not mark.exists() or mark.read_text(encoding="ascii") != wanted:
            shutil.rmtree(VENV, ignore_errors=True)
            subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
            pip: list[str | Path] = [VENV / "bin" / "python", "-m", "pip"]
            subprocess.run([*pip, "install", "-q", "--only-binary", ":all:", "-r", asked, "-c", lock], check=True)
            mark.write_text(wanted, encoding="ascii")
        command: list[str | Path] = [VENV / "bin" / "python", "-m", "mkdocs", "build", "--strict", "--quiet", "--clean"]
        subprocess.run(command, cwd=ROOT, check=True, env=dict(os.environ) | {"NO_MKDOCS_2_WARNING": "1"})
    except subprocess.CalledProcessError as error:
        program = " ".join(Path(str(word)).name for word in error.cmd[:4])
        said = f"make docs: `{program} ...` failed with status {error.returncode}; its lines above say why."
        print(said, "pip must reach a package index the first time.", file=sys.stderr)
        return FAULT
    print(f"The site is built: {ROOT / 'site' / 'index.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
