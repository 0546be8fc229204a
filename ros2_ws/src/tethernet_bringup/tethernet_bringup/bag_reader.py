"""Finds the bag that a user means, and reads it, whole or damaged, in bounded memory.

How damage is dealt with: :mod:`tethernet_bringup.mcap_scan`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from .bag_contents import BagContents, BagMessage
from .bag_errors import BagError, NotABagError
from .mcap_scan import McapScan

__all__ = ["BagMessage", "BagReader", "open_bag"]


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
                    yield from McapScan(self, path, stream, wanted).messages()
            except OSError as error:
                raise BagError(f"cannot read {path}: {error.strerror}") from error


def open_bag(path: str | os.PathLike) -> BagReader:
    """Find the bag that a user means.

    Args:
        path: a run's folder, a bag's folder, or an MCAP file.

    Raises:
        NotABagError: when there is none, saying what was expected.
    """
    path = Path(path)
    expected = "expected a run's folder, a bag's folder with a .mcap file in it, or a .mcap file"
    if not path.exists():
        raise NotABagError(f"{path} does not exist; {expected}")
    if path.is_file():
        return BagReader(files=[path])
    for folder in (path, path / "bag"):
        files = sorted(folder.glob("*.mcap"), key=_part_number)
        if files:
            return BagReader(files=files)
    if list(path.glob("*.db3")) or list(path.glob("bag/*.db3")):
        raise NotABagError(f"{path} is an SQLite bag; {expected} ('ros2 bag convert' makes one)")
    runs = sorted(folder.parent.name for folder in path.glob("*/bag") if any(folder.glob("*.mcap")))
    if runs:
        raise NotABagError(f"{path} holds {len(runs)} runs; name one of them: {', '.join(runs[-5:])}")
    raise NotABagError(f"{path} holds no bag; {expected}")


def _part_number(path: Path) -> tuple[int, str]:
    number = path.stem.rpartition("_")[2]
    return (int(number) if number.isdigit() else 0, path.name)
