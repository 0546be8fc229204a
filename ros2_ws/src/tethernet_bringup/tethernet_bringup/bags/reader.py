"""Finds the bag that a user means, and reads it, whole or damaged, in bounded memory.

Read are the bags of rosbag2 and rosbags, whoever recorded them: MCAP and SQLite, in one file or split, compressed file
by file, message by message, or chunk by chunk. How damage is dealt with: :mod:`tethernet_bringup.bags.mcap_scan`.
"""

from __future__ import annotations

import dataclasses
import os
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from tethernet_bringup.bags.bag_files import bag_files, missing_parts
from tethernet_bringup.bags.bag_information import BagInformation, information_in_folder, information_in_records
from tethernet_bringup.bags.contents import BagContents, BagMessage
from tethernet_bringup.bags.errors import BagError, NotABagError
from tethernet_bringup.bags.inflate import InflateError, Inflater, frame_compression
from tethernet_bringup.bags.mcap_scan import McapScan
from tethernet_bringup.bags.sqlite_scan import MAGIC as SQLITE_MAGIC
from tethernet_bringup.bags.sqlite_scan import SqliteScan
from tethernet_bringup.bags.writer import RUN_INFO_RECORD

__all__ = ["BagMessage", "BagReader", "open_bag"]

_ROS_1_MAGIC = b"#ROSBAG V"


@dataclass
class BagReader(BagContents):
    """One bag. Topics, metadata and problems are complete once :meth:`messages` has come to its end."""

    files: list[Path] = field(kw_only=True)
    """Its files in their order."""
    absent: list[str] = field(kw_only=True, default_factory=list)
    """Which of its files are missing, one sentence each."""
    information: BagInformation = field(kw_only=True, default_factory=BagInformation)
    """What metadata.yaml says."""

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
        for problem in self.absent:
            self.note(problem)
        for path in self.files:
            try:
                with path.open("rb") as stream:
                    yield from self._inflated(path, self._scanned(path, stream, wanted))
            except OSError as error:
                raise BagError(f"cannot read {path}: {error.strerror}") from error
        if RUN_INFO_RECORD not in self.metadata:
            facts = information_in_records(self.metadata).facts or self.information.facts
            if facts:
                self.metadata[RUN_INFO_RECORD] = dict(facts)

    def _scanned(self, path: Path, stream: IO[bytes], wanted: Callable[[str], bool]) -> Iterator[BagMessage]:
        """The messages as they are in the file."""
        head = stream.read(len(SQLITE_MAGIC))
        if compression := frame_compression(head):
            yield from self._unpacked(path, stream, compression, wanted)
        elif head == SQLITE_MAGIC:
            yield from SqliteScan(self, path, path, wanted).messages()
        elif head.startswith(_ROS_1_MAGIC):
            raise NotABagError(
                f"{path} is a bag of ROS 1; convert it first: rosbags-convert --src {path} --dst {path.stem}"
            )
        else:
            yield from McapScan(self, path, stream, wanted).messages()

    def _unpacked(
        self, path: Path, stream: IO[bytes], compression: str, wanted: Callable[[str], bool]
    ) -> Iterator[BagMessage]:
        """The messages of a file that is compressed as a whole, by way of a temporary file."""
        with tempfile.NamedTemporaryFile(prefix="tethernet_bag_", suffix=path.suffix) as unpacked:
            stream.seek(0)
            try:
                Inflater(path.stat().st_size).whole_file(compression, stream, unpacked)
                unpacked.flush()
            except InflateError as error:
                self.note(f"{path.name}: what follows is left out, {error}")
                unpacked.flush()
            except OSError as error:
                raise BagError(
                    f"cannot unpack {path} into {tempfile.gettempdir()}: {error.strerror}; TMPDIR names another folder"
                ) from error
            unpacked.seek(0)
            if unpacked.read(len(SQLITE_MAGIC)) == SQLITE_MAGIC:
                yield from SqliteScan(self, path, Path(unpacked.name), wanted).messages()
            else:
                yield from McapScan(self, path, unpacked, wanted).messages()

    def _inflated(self, path: Path, messages: Iterator[BagMessage]) -> Iterator[BagMessage]:
        """The messages, those decompressed that are compressed each for itself."""
        inflate = Inflater(path.stat().st_size)
        left_out: Counter[str] = Counter()
        for message in messages:
            compression = frame_compression(message.data)
            if not compression:
                yield message
                continue
            try:
                yield dataclasses.replace(message, data=bytes(inflate(compression, message.data)))
            except InflateError as error:
                left_out[str(error)] += 1
        for why, count in left_out.items():
            self.note(f"{path.name}: {count} messages were left out, {why}")


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
        if files := bag_files(folder):
            information = information_in_folder(folder)
            return BagReader(files=files, absent=missing_parts(files, information.files), information=information)
    runs = sorted(folder.parent.name for folder in path.glob("*/bag") if bag_files(folder))
    if runs:
        raise NotABagError(f"{path} holds {len(runs)} runs; name one of them: {', '.join(runs[-5:])}")
    raise NotABagError(f"{path} holds no bag; {expected}")
