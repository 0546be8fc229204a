"""Fingerprints of what a step depends on. They are taken at every start: everything here is small and fast."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path


def of_contents(paths: Iterable[Path], *words: str) -> str:
    """Fingerprint of files by name and contents; a missing file counts as empty."""
    digest = hashlib.sha256("\0".join(words).encode())
    for path in paths:
        try:
            content = path.read_bytes()
        except OSError:
            content = b""
        digest.update(f"\0{path.name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()


def of_times(paths: Iterable[Path], *words: str) -> str:
    """Fingerprint of files by name, size and time of change, which is how numba's cache knows them too."""
    digest = hashlib.sha256("\0".join(words).encode())
    for path in paths:
        status = path.stat()
        digest.update(f"\0{path.name}\0{status.st_size}\0{status.st_mtime_ns}".encode())
    return digest.hexdigest()
