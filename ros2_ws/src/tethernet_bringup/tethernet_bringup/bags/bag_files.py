"""Which files a bag consists of: parts in their order, compressed or not, and which of them are missing.

rosbag2 splits a bag into ``NAME_0.mcap``, ``NAME_1.mcap`` and so on (``.db3`` for SQLite); with file compression each
part becomes ``NAME_0.mcap.zstd`` once it is full, so that the last one may be left as it is when the recorder is
killed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

SUFFIXES = (".mcap", ".db3")
COMPRESSED_SUFFIXES = (".zstd", ".zst", ".lz4")


def bag_files(folder: Path) -> list[Path]:
    """The files of the bag in a folder, in their order; empty where there is none.

    Of a part that is there compressed and uncompressed, the compressed one is unfinished and left out.
    """
    for suffix in SUFFIXES:
        found = {
            path for end in ("", *COMPRESSED_SUFFIXES) for path in folder.glob(f"*{suffix}{end}") if path.is_file()
        }
        if found:
            names = {path.name for path in found}
            kept = (path for path in found if path.name == plain(path.name) or plain(path.name) not in names)
            return sorted(kept, key=_order)
    return []


def plain(name: str) -> str:
    """The name of a file without what its compression has added."""
    return next((name.removesuffix(end) for end in COMPRESSED_SUFFIXES if name.endswith(end)), name)


def missing_parts(files: Sequence[Path], listed: Iterable[str]) -> list[str]:
    """What of a split bag is not there, one sentence each.

    Args:
        files: of the bag.
        listed: names of all its files by metadata.yaml; empty where that is not known.
    """
    there = {plain(path.name) for path in files}
    named = {plain(Path(name).name) for name in listed}
    if there & named:  # else it is the list of another bag, or the files were renamed
        return [
            f"{name} is missing, metadata.yaml names it"
            for name in sorted(named - there, key=lambda name: _order(Path(name)))
        ]
    numbers = {number for path in files if (number := _number(path)) is not None}
    if len(numbers) < len(files):
        return []
    holes = sorted(set(range(min(numbers), max(numbers))) - numbers)
    return [f"part {number} of the bag is missing, there are others before and after it" for number in holes]


def _order(path: Path) -> tuple[int, str]:
    return (_number(path) or 0, path.name)


def _number(path: Path) -> int | None:
    number = Path(plain(path.name)).stem.rpartition("_")[2]
    return int(number) if number.isdecimal() and number.isascii() else None
