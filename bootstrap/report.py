"""What the user sees of a set-up: numbered steps, how far they are, and how long they took."""

from __future__ import annotations

import os
import shutil
import sys
import time
from typing import TextIO

REFRESH_S = 0.1
"""On a terminal the line is redrawn this often at most."""

SIGN_OF_LIFE_S = 15.0
"""Without a terminal one line is written this often while a step runs."""


class Report:
    """Writes to stderr: a script that reads the mission's output is not disturbed."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._live = self._stream.isatty() and os.environ.get("TERM") != "dumb"
        self._step_count = 0
        self._number = 0
        self._title = self._detail = ""
        self._begin = self._last = time.monotonic()

    def say(self, text: str) -> None:
        """Write a line of its own."""
        self._stream.write(("\r\x1b[K" if self._live else "") + text + "\n")
        self._stream.flush()

    def plan(self, step_count: int) -> None:
        """Say how many steps will come."""
        self._step_count, self._number = step_count, 0

    def begin(self, title: str) -> None:
        """The next step begins."""
        self._number += 1
        self._title = f"[{self._number}/{self._step_count}] {title}"
        self._detail = ""
        self._begin = self._last = time.monotonic()
        if self._live:
            self._draw()
        else:
            self.say(self._title)

    def update(self, detail: str) -> None:
        """Tell how far the running step is, "" for no news; cheap enough to be called for every line of a tool."""
        self._detail = detail or self._detail
        now = time.monotonic()
        if now - self._last < (REFRESH_S if self._live else SIGN_OF_LIFE_S):
            return
        self._last = now
        if self._live:
            self._draw()
        else:
            self.say(f"      {now - self._begin:.0f} s  {self._detail}".rstrip())

    def end(self, detail: str = "") -> None:
        """The running step is done."""
        text = f"done in {time.monotonic() - self._begin:.1f} s" + (f" ({detail})" if detail else "")
        self.say(f"{self._title}: {text}" if self._live else f"      {text}")

    def _draw(self) -> None:
        line = f"{self._title}  {time.monotonic() - self._begin:.0f} s  {self._detail}"
        width = shutil.get_terminal_size().columns - 1
        self._stream.write("\r\x1b[K" + line[:width])
        self._stream.flush()
