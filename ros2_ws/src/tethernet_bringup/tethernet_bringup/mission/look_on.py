"""How to look on while a mission flies: with the ``ros2`` command that exists on this machine."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

SET_UP = "setup.json"
"""Lies in an environment that the project's set-up has made."""


def look_on(topic: str, domain: int) -> str:
    """What the mission's banner says.

    Args:
        topic: an example.
        domain: the mission's DDS domain; the stock command is told of another than 0 by its variable.
    """
    prefix = f"ROS_DOMAIN_ID={domain} " if domain else ""
    own = Path(sys.prefix, "bin", "ros2")
    name, after = "ros2", ""
    if own.exists():
        name = _shown(own)
    elif shutil.which("ros2") is None and Path(sys.prefix, SET_UP).exists():
        name, after = _shown(own), "  (`make ros2cli` installs it)"
    return f"look on with  {prefix}{name} topic echo {topic}{after}"


def _shown(path: Path) -> str:
    """As it is typed from the working folder."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (OSError, ValueError):  # elsewhere, or the working folder is gone
        return str(path)
