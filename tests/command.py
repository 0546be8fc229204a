"""The command ``tethernet`` in tests: called in this process, or started as one of its own."""

from __future__ import annotations

import sys
from pathlib import Path

from tethernet_bringup.cli.main import main

COMMAND = (sys.executable, "-P", "-m", "tethernet_bringup.cli")
"""Starts it as a process, as the set-up does."""

SCRIPT = Path(sys.executable).with_name("tethernet")
"""The console script."""


def tethernet(*words: object) -> int:
    """Do what the words say, in this process; gives the exit status."""
    return main([str(word) for word in words])
