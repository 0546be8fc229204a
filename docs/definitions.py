"""Hook of the site's generator: puts the definitions of messages and services into their page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

MARK = "<!-- definitions -->"
MESSAGES = Path(__file__).parents[1] / "ros2_ws" / "src" / "tethernet_msgs"


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Called by mkdocs for every page."""
    return markdown.replace(MARK, definitions()) if MARK in markdown else markdown


def definitions() -> str:
    """Every definition under its name, as it is in its file."""
    files = [*sorted(MESSAGES.glob("msg/*.msg")), *sorted(MESSAGES.glob("srv/*.srv"))]
    return "\n\n".join(f"## {file.stem}\n\n```\n{file.read_text(encoding='utf-8').rstrip()}\n```" for file in files)
