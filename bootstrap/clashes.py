"""Which packages do not fit together, of those that the set-up has installed: what else a user installs is his own."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from .places import PYTHON_PACKAGES

_PIN = re.compile(r"([A-Za-z0-9._-]+)==", re.MULTILINE)


def normal(name: str) -> str:
    """A package's name as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def own_packages(requirements: Iterable[Path]) -> set[str]:
    """Names of all packages that requirement files pin, and of the project's own."""
    pinned = {name for path in requirements if path.exists() for name in _PIN.findall(path.read_text())}
    return {normal(name) for name in (*pinned, *PYTHON_PACKAGES)}


def clashes(checked: str, own: set[str]) -> list[str]:
    """The complaints of ``pip check`` that are about own packages.

    Args:
        checked: its output, one complaint a line, each beginning with the name of the package that is not content.
        own: from :func:`own_packages`.
    """
    return [line for line in checked.splitlines() if " " in line and normal(line.split()[0]) in own]
