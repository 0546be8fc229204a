"""The tutorials' commands and code are run as they stand in docs/tutorials, page by page, in a folder of their own.

A fence says what becomes of it: ``run`` runs it, ``write=FILE`` writes it, anything else is only shown.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from bootstrap.places import ROOT

PAGES = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
FENCE = re.compile(r"^```(\w+) (run|write=(\S+))\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LONGEST_S = 240.0

pytestmark = [pytest.mark.ros, pytest.mark.timeout(600)]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """As the repository's folder looks to a reader: the commands of the first page are typed there."""
    for name in ("run_mission.py", "analyse_mission.py", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if FENCE.search(page.read_text())], ids=lambda page: page.stem)
def test_what_a_tutorial_shows_works(page, folder, domain_id):
    search = f"{sys.prefix}/bin{os.pathsep}{os.environ['PATH']}"
    environment = dict(os.environ) | {"PATH": search, "TETHERNET_VENV": sys.prefix}
    for number, fence in enumerate(FENCE.finditer(page.read_text())):
        language, _, file, text = fence.groups()
        if file:
            (folder / file).write_text(text)
            continue
        script = folder / f"block_{number}"
        script.write_text(text)
        command = {"sh": ["sh", "-e", script], "python": [sys.executable, script]}[language]
        log = folder / f"block_{number}.log"  # not a pipe: what runs in the background would hold it open
        with log.open("w") as output:
            block = subprocess.Popen(
                command, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
            )
        try:
            status = block.wait(LONGEST_S)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(block.pid, signal.SIGKILL)  # what it has started, where it failed
            block.wait()
        assert status == 0, f"{page.name}:\n{text}\n{log.read_text()[-5000:]}"


def test_every_page_has_a_fence_of_each_kind_it_needs():
    for page in PAGES:
        written = [fence[3] for fence in FENCE.finditer(page.read_text()) if fence[3]]
        for name in written:
            assert page.read_text().count(name) > 1, f"{page.name} writes {name} and does not use it"
