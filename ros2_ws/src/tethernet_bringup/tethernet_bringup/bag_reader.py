"""Reads bags, also torn ones, front to back, in bounded memory.

A reader that trusts the file's end finds nothing in a bag whose recorder was killed. This one goes from record to
record and trusts a record only when it lies within the file, and a chunk only when its checksum fits; so it yields
every message that is whole, says in plain words what is not, and a length of many gigabytes made of garbage costs no
memory.
"""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema

from .bag_errors import BagError, NotABagError
from .bag_metadata import BagTopic, MessageType
from .mcap_writer import MAGIC

LARGEST_CHUNK_BYTES = 1 << 28  # writers use about 1 MiB; anything like this is garbage
_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_CHUNK = struct.Struct("<QQQI")


@dataclass(frozen=True, slots=True)
class BagMessage:
    """One message as recorded."""

    topic: str
    log_time: int
    """[ns]"""
    publish_time: int
    """[ns]"""
    sequence: int
    data: bytes


@dataclass
class BagReader:
    """One bag. Topics, metadata and problems are complete once :meth:`messages` has come to its end."""

    files: list[Path]
    """Its MCAP files in their order."""
    topics: dict[str, BagTopic] = field(default_factory=dict)
    """All topics met so far, by name."""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    """Named texts met so far: "tethernet" holds the facts about the run."""
    problems: list[str] = field(default_factory=list)
    """What is wrong with the bag, one sentence each; empty for a whole one."""

    def messages(self, wanted: Callable[[str], bool] = lambda _: True) -> Iterator[BagMessage]:
        """Go through the bag once.

        Args:
            wanted: which topics to yield messages of.

        Yields:
            The messages in the order of the file: roughly that of time, exactly for each topic.

        Raises:
            BagError: when a file cannot be read.
            NotABagError: when a file is no MCAP file.
        """
        self.problems.clear()
        for path in self.files:
            try:
                with path.open("rb") as stream:
                    yield from _FileScan(self, path, stream, wanted).messages()
            except OSError as error:
                raise BagError(f"cannot read {path}: {error.strerror}") from error


class _FileScan:
    def __init__(self, reader: BagReader, path: Path, stream: BinaryIO, wanted: Callable[[str], bool]):
        self._reader = reader
        self._path = path
        self._stream = stream
        self._size = os.fstat(stream.fileno()).st_size
        self._wanted = wanted
        self._schemas: dict[int, Schema] = {}
        self._names: dict[int, str | None] = {}  # of the channels; None for those not wanted

    def messages(self) -> Iterator[BagMessage]:
        if self._size == 0:
            raise NotABagError(f"{self._path} is empty: nothing was recorded, nothing can be recovered")
        if self._stream.read(len(MAGIC)) != MAGIC:
            raise NotABagError(f"{self._path} is no MCAP file: it does not begin like one")
        position = len(MAGIC)
        while True:
            head = self._stream.read(_RECORD.size)
            if len(head) < _RECORD.size:
                self._problem(position, "it ends without the closing part, as after a killed recorder")
                return
            opcode, length = _RECORD.unpack(head)
            room = self._size - position - _RECORD.size
            if opcode in {Opcode.DATA_END, Opcode.FOOTER}:
                if not self._closed_properly():
                    self._problem(position, "all messages are there, but the closing part is damaged")
                return
            if not Opcode.HEADER <= opcode <= Opcode.SUMMARY_OFFSET or (length > room and opcode != Opcode.CHUNK):
                self._problem(
                    position, "from there on it holds no records" if length > room else f"unknown record {opcode:#x}"
                )
                return
            if length > room:
                yield from self._torn_chunk(position, self._stream.read(min(room, LARGEST_CHUNK_BYTES)))
                return
            if opcode in {Opcode.MESSAGE_INDEX, Opcode.ATTACHMENT} or length > LARGEST_CHUNK_BYTES:
                self._stream.seek(length, os.SEEK_CUR)
            else:
                yield from self._record(position, opcode, self._stream.read(length))
            position += _RECORD.size + length

    def _record(self, position: int, opcode: int, body: bytes) -> Iterator[BagMessage]:
        try:
            if opcode == Opcode.CHUNK:
                content = self._chunk_content(position, body)
                if content is not None:
                    yield from self._chunk_messages(position, content)
            elif opcode == Opcode.MESSAGE:
                yield from self._message(body)
            else:
                self._description(opcode, body)
        except (McapError, struct.error, UnicodeDecodeError, KeyError) as error:
            self._problem(position, f"a damaged record was left out ({type(error).__name__})")

    def _description(self, opcode: int, body: bytes) -> None:
        stream = ReadDataStream(io.BytesIO(body))
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            self._schemas[schema.id] = schema
        elif opcode == Opcode.METADATA:
            record = Metadata.read(stream)
            self._reader.metadata[record.name] = record.metadata
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            schema = self._schemas[channel.schema_id]
            kind = MessageType(
                name=schema.name,
                definition=schema.data.decode(),
                type_hash=channel.metadata.get("topic_type_hash", ""),
                encoding=schema.encoding,
            )
            qos = channel.metadata.get("offered_qos_profiles", "")
            self._reader.topics.setdefault(channel.topic, BagTopic(channel.topic, kind, qos))
            self._names[channel.id] = channel.topic if self._wanted(channel.topic) else None

    def _message(self, body: bytes) -> Iterator[BagMessage]:
        channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(body)
        name = self._names[channel]
        if name is not None:
            yield BagMessage(name, log_time, publish_time, sequence, body[_MESSAGE.size :])

    def _chunk_messages(self, position: int, content: bytes, *, torn: bool = False) -> Iterator[BagMessage]:
        offset, end = 0, len(content)
        while end - offset >= _RECORD.size:
            opcode, length = _RECORD.unpack_from(content, offset)
            start = offset + _RECORD.size
            if length > end - start:
                break
            if opcode == Opcode.MESSAGE:
                channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(content, start)
                name = self._names[channel]
                if name is not None:
                    yield BagMessage(
                        name, log_time, publish_time, sequence, content[start + _MESSAGE.size : start + length]
                    )
            elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                self._description(opcode, content[start : start + length])
            offset = start + length
        if offset != end and not torn:
            self._problem(position, "the last record of a chunk is cut off")

    def _chunk_content(self, position: int, body: bytes) -> bytes | None:
        checksum, size, compression, data = _chunk_parts(body)
        try:
            content = _decompressed(compression, data, size)
        except (zstandard.ZstdError, RuntimeError, MemoryError, ValueError) as error:
            self._problem(position, f"a chunk was left out, it cannot be decompressed ({error})")
            return None
        if checksum and zlib.crc32(content) != checksum:
            self._problem(position, "a chunk was left out, its checksum is wrong")
            return None
        return content

    def _torn_chunk(self, position: int, body: bytes) -> Iterator[BagMessage]:
        """What a cut-off chunk begins with: zstd decompresses block by block, so the whole ones can be had."""
        self._problem(position, "it ends in the middle of a chunk")
        try:
            _, _, compression, data = _chunk_parts(body)
            if compression == "zstd":
                data = zstandard.ZstdDecompressor().decompressobj().decompress(data)
            if compression in {"", "zstd"}:
                yield from self._chunk_messages(position, data, torn=True)
        except (McapError, zstandard.ZstdError, struct.error, UnicodeDecodeError, KeyError):
            return  # not even its beginning is there

    def _closed_properly(self) -> bool:
        self._stream.seek(self._size - len(MAGIC))
        return self._stream.read() == MAGIC

    def _problem(self, position: int, what: str) -> None:
        self._reader.problems.append(f"{self._path.name}, byte {position} of {self._size}: {what}")


def _chunk_parts(body: bytes) -> tuple[int, int, str, bytes]:
    _, _, size, checksum = _CHUNK.unpack_from(body)
    offset = _CHUNK.size
    (length,) = struct.unpack_from("<I", body, offset)
    compression = body[offset + 4 : offset + 4 + length].decode()
    return checksum, size, compression, body[offset + 12 + length :]


def _decompressed(compression: str, data: bytes, size: int) -> bytes:
    if size > LARGEST_CHUNK_BYTES:
        raise ValueError(f"it claims {size} bytes")
    if compression == "zstd":
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    if compression == "lz4":
        import lz4.frame

        return lz4.frame.decompress(data)
    if compression == "":
        return data
    raise ValueError(f"unknown compression {compression!r}")


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
        return BagReader([path])
    for folder in (path, path / "bag"):
        files = sorted(folder.glob("*.mcap"), key=_part_number)
        if files:
            return BagReader(files)
    if list(path.glob("*.db3")) or list(path.glob("bag/*.db3")):
        raise NotABagError(f"{path} is an SQLite bag; {expected} ('ros2 bag convert' makes one)")
    runs = sorted(folder.parent.name for folder in path.glob("*/bag") if any(folder.glob("*.mcap")))
    if runs:
        raise NotABagError(f"{path} holds {len(runs)} runs; name one of them: {', '.join(runs[-5:])}")
    raise NotABagError(f"{path} holds no bag; {expected}")


def _part_number(path: Path) -> tuple[int, str]:
    number = path.stem.rpartition("_")[2]
    return (int(number) if number.isdigit() else 0, path.name)
