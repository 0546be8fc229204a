"""Files that are written as a whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path


def write_whole(path: Path, write_to: Callable[[Path], object], durable: bool = True) -> None:
    """Let something write a file beside its place, then move it there.

    A reader, a kill or a full disk finds the old file or the new one, never half of it.

    Args:
        path: the file.
        write_to: writes a file of the path that it is given; its name ends like that of ``path``.
        durable: wait until the new one is on the disk, for what must outlive a loss of power; not for what is written
            again every second.

    Raises:
        OSError: when it cannot be written; what was there before stays.
    """
    partial = path.with_name(f".{os.getpid()}.partial.{path.name}")
    try:
        write_to(partial)
        if durable:
            with partial.open("rb") as file:
                os.fsync(file.fileno())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: Path, text: str, durable: bool = True) -> None:
    """:func:`write_whole` of a text, encoded in UTF-8.

    Raises:
        OSError: likewise.
    """
    write_whole(path, lambda partial: partial.write_text(text, encoding="utf-8"), durable)
