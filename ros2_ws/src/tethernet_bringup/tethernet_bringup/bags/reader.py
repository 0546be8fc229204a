"""Finds the bag that a user means, and reads it, whole or damaged, in bounded memory.

How damage is dealt with: :mod:`tethernet_bringup.bags.mcap_scan`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from tethernet_bringup.bags.contents import BagContents, BagMessage
from tethernet_bringup.bags.errors import BagError, NotABagError
from tethernet_bringup.bags.mcap_scan import McapScan
from tethernet_bringup.bags.sqlite_scan import MAGIC as SQLITE_MAGIC
from tethernet_bringup.bags.sqlite_scan import SqliteScan

__all__ = ["BagMessage", "BagReader", "open_bag"]

_PATTERNS = ("*.mcap", "*.db3")


@dataclass
class BagReader(BagContents):
    """One bag. Topics, metadata and problems are complete once :meth:`messages` has come to its end."""

    files: list[Path] = field(kw_only=True)
    """Its files in their order."""

    def messages(self, wanted: Callable[[str], bool] = lambda _: True) -> Iterator[BagMessage]:
        """Go through the bag once.

        Args:
            wanted: which topics to yield messages of.

        Yields:
            The messages in the order of the file: roughly that of time, exactly for each topic.

        Raises:
            BagError: when a file cannot be read.
            NotABagError: when a file is no bag's file.
        """
        self.start_anew()
        for path in self.files:
            try:
                with path.open("rb") as stream:
                    if stream.read(len(SQLITE_MAGIC)) == SQLITE_MAGIC:
                        yield from SqliteScan(self, path, wanted).messages()
                    else:
                        yield from McapScan(self, path, stream, wanted).messages()
            except OSError as error:
                raise BagError(f"cannot read {path}: {error.strerror}") from error


def open_bag(path: str | os.PathLike[str]) -> BagReader:
    """Find the bag that a user means.

    Args:
        path: a run's folder, a bag's folder, or an MCAP or SQLite file. Files are found by their names, whatever
            metadata.yaml says: it may be missing, damaged, or lead out of the folder.

    Raises:
        NotABagError: when there is none, saying what was expected.
    """
    path = Path(path)
    expected = "expected a run's folder, a bag's folder with .mcap or .db3 files in it, or one of these files"
    if not path.exists():
        raise NotABagError(f"{path} does not exist; {expected}")
    if path.is_file():
        return BagReader(files=[path])
    for folder in (path, path / "bag"):
        for pattern in _PATTERNS:
            files = sorted((file for file in folder.glob(pattern) if file.is_file()), key=_part_number)
            if files:
                return BagReader(files=files)
    if compressed := [*path.glob("*.zstd"), *path.glob("bag/*.zstd")]:
        raise NotABagError(f"{path} is compressed as a whole; decompress it first with: zstd -d {compressed[0]}")
    runs = sorted(folder.parent.name for folder in path.glob("*/bag") if any(map(list, map(folder.glob, _PATTERNS))))
    if runs:
        raise NotABagError(f"{path} holds {len(runs)} runs; name one of them: {', '.join(runs[-5:])}")
    raise NotABagError(f"{path} holds no bag; {expected}")


def _part_number(path: Path) -> tuple[int, str]:
    number = path.stem.rpartition("_")[2]
    return (int(number) if number.isdigit() else 0, path.name)
