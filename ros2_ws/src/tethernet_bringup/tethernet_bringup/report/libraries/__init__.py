"""Libraries of others that a page carries, as they were built from pinned packages, and their licences.

``pinned.json`` names package, version, file and SHA-256 of each; ``make report-libraries`` writes them anew.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

_FOLDER = Path(__file__).parent
PINS = _FOLDER / "pinned.json"


@dataclass(frozen=True)
class Library:
    """One library."""

    name: str
    version: str
    files: dict[str, str]
    """SHA-256 of each of its files, the licence's among them, by name."""

    @property
    def licence(self) -> str:
        """Its licence, the whole text."""
        return read(f"{self.name}.LICENSE")


def libraries() -> list[Library]:
    """All of them."""
    return [Library(**entry) for entry in json.loads(PINS.read_text(encoding="utf-8"))]


def read(name: str) -> str:
    """A file of a library."""
    return (_FOLDER / name).read_text(encoding="utf-8")


def digest(name: str) -> str:
    """SHA-256 of a file as it lies here."""
    return hashlib.sha256((_FOLDER / name).read_bytes()).hexdigest()
