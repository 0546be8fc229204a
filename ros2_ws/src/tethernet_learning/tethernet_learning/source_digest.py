"""The sources that decide what a flight comes to, in one number."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path

import tethernet_control
import tethernet_core
import tethernet_planner
import tethernet_sim

FLOWN_BY = (tethernet_core, tethernet_control, tethernet_planner, tethernet_sim)
"""The packages whose code decides what comes out."""


@functools.cache
def source_digest() -> str:
    """Digest of all modules of FLOWN_BY, as this process found them."""
    parts = []
    for package in FLOWN_BY:
        folder = Path(package.__path__[0])
        for path in sorted(folder.rglob("*.py")):
            parts += [f"{package.__name__}/{path.relative_to(folder)}".encode(), path.read_bytes()]
    return digest(parts)


def digest(parts: Iterable[bytes]) -> str:
    """One digest of several pieces, that tells where each ends."""
    made = hashlib.sha256()
    for part in parts:
        made.update(len(part).to_bytes(8, "little") + part)
    return made.hexdigest()
