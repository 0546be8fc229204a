"""``make report-libraries``: build the libraries of a page anew from the packages that requirements/report/ pins.

Needs npm. three.js is published as modules of two megabytes; esbuild keeps what ``three_entry.js`` names.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from tethernet_bringup.report.libraries import PINS, digest

_FOLDER = Path(__file__).parent
_PACKAGES = Path("requirements", "report")
_ENTRY = "three_entry.js"
_BUILT = {"three": ["three.min.js"], "uplot": ["uPlot.iife.min.js", "uPlot.min.css"]}
_BUNDLE = ("--bundle", "--minify", "--format=esm", "--legal-comments=inline", "--target=es2022")


def main() -> None:
    """Write the files and their checksums."""
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for file in ("package.json", "package-lock.json"):
            shutil.copy(_PACKAGES / file, work)
        shutil.copy(_FOLDER / _ENTRY, work)
        subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=work, check=True)
        modules = work / "node_modules"
        to = f"--outfile={_FOLDER / 'three.min.js'}"
        subprocess.run([str(modules / ".bin" / "esbuild"), _ENTRY, *_BUNDLE, to], cwd=work, check=True)
        for file in _BUILT["uplot"]:
            shutil.copy(modules / "uplot" / "dist" / file, _FOLDER)
        pins = [_pin(package, modules) for package in _BUILT]
    PINS.write_text(json.dumps(pins, indent=2) + "\n", encoding="utf-8")
    print(f"{PINS}: {', '.join(pin['name'] + ' ' + pin['version'] for pin in pins)}", file=sys.stderr)


def _pin(package: str, modules: Path) -> dict[str, Any]:
    licence = f"{package}.LICENSE"
    shutil.copy(modules / package / "LICENSE", _FOLDER / licence)
    version = json.loads((modules / package / "package.json").read_text(encoding="utf-8"))["version"]
    return {"name": package, "version": version, "files": {name: digest(name) for name in (*_BUILT[package], licence)}}


if __name__ == "__main__":
    main()
