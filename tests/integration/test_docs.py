"""The documentation site: built as ``make docs`` does, where a warning, or a link that leads nowhere, is an error."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from bootstrap.places import ROOT


def test_every_page_is_in_the_navigation():
    listed = set(re.findall(r"([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE))
    there = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    assert listed == there


@pytest.mark.slow
@pytest.mark.network
def test_the_site_builds_without_a_warning():
    command = [sys.executable, "-m", "bootstrap.docs"]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=280, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    messages = (ROOT / "site" / "reference" / "messages" / "index.html").read_text()
    assert "uint8 DEPLOYING=1" in messages, "the definitions are on their page"
    assert "fly_many" in (ROOT / "site" / "reference" / "python" / "index.html").read_text()
