"""``--view web`` in a browser: what Rerun's page draws is the flight."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from io import BytesIO

import numpy as np
import pytest

from bootstrap.places import ROOT
from tests import browser, toy_mission
from tethernet_bringup.analysis.scene import mu_color

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("rerun") is None, reason="needs rerun"),
    pytest.mark.skipif(browser.found() is None, reason="NOT TESTED: no browser here; Debian: chromium-headless-shell"),
]

PAGE = re.compile(r"http://127\.0\.0\.1:\d+/\?url=\S+")
PATIENCE_S = 200.0
MUS = 8
BEFORE_CONTACT = (500.0, 786.0)
"""On the page's time line [px]."""


def test_a_browser_shows_the_flight_of_a_bag(tmp_path):
    toy_mission.write_bag(tmp_path / "bag")
    words = [sys.executable, ROOT / "view_mission.py", tmp_path, "--view", "web"]
    with (
        subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as command,
        browser.browser(browser.found(), tmp_path / "profile") as page,
    ):
        try:
            address = next(
                found[0] for line in command.stdout if "until Ctrl-C" in line and (found := PAGE.search(line))
            )
            page.resize(1200, 800)
            page.call("Page.navigate", url=address)
            end = time.monotonic() + PATIENCE_S
            while len(seen := units_seen(page.picture(tmp_path / "page.png"))) < 5:  # the page has two of their colours
                assert time.monotonic() < end, f"MUs in the picture: {seen}; {page.logged}"
                page.click(*BEFORE_CONTACT)  # at the end, where it rests, the net hides most of them
                time.sleep(0.5)
        finally:
            command.send_signal(signal.SIGINT)
        assert command.wait(30.0) == 0


def units_seen(png: bytes) -> list[int]:
    """The MUs whose colour is in the part of the page that shows the scene."""
    import matplotlib.image
    from matplotlib.colors import to_rgb

    scene = matplotlib.image.imread(BytesIO(png))[50:, :600, :3]
    near = {mu: (np.abs(scene - to_rgb(mu_color(mu))).max(axis=2) < 0.06).sum() for mu in range(1, MUS + 1)}
    return [mu for mu, count in near.items() if count >= 8]
