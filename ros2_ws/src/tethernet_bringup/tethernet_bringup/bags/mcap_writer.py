"""Writes MCAP files so that nothing of a recording is lost, lean enough to share two cores with twelve processes.

Why not the Writer of the `mcap` package (1.6):

- It puts schemas and channels into the first chunk. When the recorder was killed, nothing repeats them, and one wrong
  byte in that chunk costs the whole bag. Here they stand before it, each a record of its own.
- A write that fails takes its chunk along. Here the file then ends with its last whole record, and the messages stay in
  memory, to be written once there is room.
- It spends twice as long on a message, in one small write after the other, and in lock-step some 5000 a second arrive;
  here a message is one tuple until its chunk is closed.

The rare records are packed by the `mcap` package.

Assumptions and limitations: no attachments; a chunk in the making is lost when the process is killed, so call
:meth:`McapWriter.flush` as often as you can afford to lose messages.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections import Counter
from pathlib import Path

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from tethernet_bringup.bags.errors import BagWriteError, cause

MAGIC = b"\x89MCAP0\r\n"
LIBRARY = "tethernet"
_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIELDS_BYTES = 22  # channel, sequence, log time, publish time
_INDEX = struct.Struct("<BQHI")


class McapWriter:
    """Writes one file.

    Args:
        path: file to make; it must not exist.
        profile: MCAP profile, "ros2" for bags.
        chunk_bytes: a chunk is closed when it holds so many bytes [B]; bounds the memory used.
        zstd_level: compression level. Positions as float32 hardly compress: levels above 1 cost time and gain nothing.

    Raises:
        BagWriteError: when the file cannot be made.
    """

    def __init__(self, path: Path, *, profile: str = "ros2", chunk_bytes: int = 1 << 18, zstd_level: int = 1):
        self._path = path
        self._chunk_bytes = chunk_bytes
        self._compressor = zstandard.ZstdCompressor(level=zstd_level)
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._metadata: list[MetadataIndex] = []
        self._chunks: list[ChunkIndex] = []
        self._pending: list[tuple[int, int, int, int, bytes]] = []
        self._pending_bytes = 0
        self._end = 0
        self._checksum = 0  # of the whole file so far
        self.counts: Counter[int] = Counter()
        """Messages in the file by channel, those of the open chunk not counted."""
        self.start_time = 0
        """Smallest log time in the file [ns]."""
        self.end_time = 0
        """Largest log time in the file [ns]."""
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise BagWriteError(f"cannot make {path}: {cause(error)}") from error
        self._append(MAGIC + _packed(Header(profile=profile, library=LIBRARY)))

    @property
    def message_count(self) -> int:
        """Messages in the file, those of the open chunk not counted."""
        return self.counts.total()

    @property
    def pending_count(self) -> int:
        """Messages that only memory holds."""
        return len(self._pending)

    @property
    def size(self) -> int:
        """Size of the file [B]."""
        return self._end

    @property
    def checksum(self) -> int:
        """CRC-32 of the file."""
        return self._checksum

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a message type; returns its id."""
        schema = Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=data)
        self._append(_packed(schema))
        self._schemas.append(schema)
        return schema.id

    def add_channel(self, topic: str, schema_id: int, metadata: dict[str, str], message_encoding: str = "cdr") -> int:
        """Add a topic; returns its id."""
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding=message_encoding,
            metadata=metadata,
            schema_id=schema_id,
        )
        self._append(_packed(channel))
        self._channels.append(channel)
        return channel.id

    def add_metadata(self, name: str, content: dict[str, str]) -> None:
        """Add a named set of texts."""
        record = _packed(Metadata(name=name, metadata=content))
        offset = self._end
        self._append(record)
        self._metadata.append(MetadataIndex(offset=offset, length=len(record), name=name))

    def add_message(self, channel: int, log_time: int, publish_time: int, sequence: int, data: bytes) -> None:
        """Take a message.

        Args:
            channel: id of its topic.
            log_time: what readers order and play by [ns].
            publish_time: when its publisher says that it is from [ns].
            sequence: the publisher's counter.
            data: as serialized by the middleware.

        Raises:
            BagWriteError: when a full chunk cannot be written; the messages stay in memory.
        """
        self._pending.append((log_time, channel, sequence, publish_time, data))
        self._pending_bytes += len(data) + _MESSAGE.size  # many empty messages take memory too
        if self._pending_bytes >= self._chunk_bytes:
            self.flush()

    def flush(self) -> None:
        """Close the chunk: what has been taken so far outlives this process.

        Messages of a chunk stand in the order of log time, channel, sequence: which of two topics was read first is
        chance.

        Raises:
            BagWriteError: when the chunk cannot be written; its messages stay in memory, to be flushed again.
        """
        if not self._pending:
            return
        self._pending.sort(key=_by_time)
        content, entries = self._chunk_content()
        start, end = self._pending[0][0], self._pending[-1][0]
        compressed = self._compressor.compress(content)
        chunk = _packed(
            Chunk(
                compression="zstd", data=compressed, message_start_time=start, message_end_time=end,
                uncompressed_crc=zlib.crc32(content), uncompressed_size=len(content),
            )
        )  # fmt: skip
        offsets, indexes, position = {}, [], self._end + len(chunk)
        for channel, flat in entries.items():
            offsets[channel] = position
            length = 8 * len(flat)
            indexes.append(
                _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + length, channel, length) + struct.pack(f"<{len(flat)}Q", *flat)
            )
            position += len(indexes[-1])
        index = ChunkIndex(
            chunk_length=len(chunk), chunk_start_offset=self._end, compression="zstd", compressed_size=len(compressed),
            message_end_time=end, message_index_length=position - self._end - len(chunk), message_index_offsets=offsets,
            message_start_time=start, uncompressed_size=len(content),
        )  # fmt: skip
        self._append(b"".join((chunk, *indexes)))
        self._chunks.append(index)
        self.start_time = min(start, self.start_time) if self.counts else start
        self.end_time = max(end, self.end_time)
        for channel, flat in entries.items():
            self.counts[channel] += len(flat) // 2
        self._pending, self._pending_bytes = [], 0

    def finish(self) -> None:
        """Write what is left and the summary, and close the file.

        Raises:
            BagWriteError: when there is no room for it; the file then lacks its end, but all records in it are whole.
        """
        try:
            self.flush()
            self._append(self._summary())
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Close the file as it is."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def _chunk_content(self) -> tuple[bytes, dict[int, list[int]]]:
        parts: list[bytes] = []
        entries: dict[int, list[int]] = {}
        offset = 0
        pack, opcode = _MESSAGE.pack, int(Opcode.MESSAGE)
        for log_time, channel, sequence, publish_time, data in self._pending:
            size = _MESSAGE_FIELDS_BYTES + len(data)
            parts += (pack(opcode, size, channel, sequence, log_time, publish_time), data)
            if channel in entries:
                entries[channel] += (log_time, offset)
            else:
                entries[channel] = [log_time, offset]
            offset += size + 9
        return b"".join(parts), entries

    def _summary(self) -> bytes:
        start = self._end + len(data_end := _packed(DataEnd(data_section_crc=self._checksum)))
        statistics = Statistics(
            attachment_count=0, channel_count=len(self._channels), channel_message_counts=dict(self.counts),
            chunk_count=len(self._chunks), message_count=self.message_count, message_end_time=self.end_time,
            message_start_time=self.start_time, metadata_count=len(self._metadata), schema_count=len(self._schemas),
        )  # fmt: skip
        groups = (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.METADATA_INDEX, self._metadata),
        )
        summary, offsets = b"", b""
        for opcode, records in groups:
            if records:
                group = b"".join(map(_packed, records))
                offsets += _packed(
                    SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(group))
                )
                summary += group
        offset_start = start + len(summary)
        summary += offsets
        checked = summary + struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start)
        footer = Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=zlib.crc32(checked))
        return data_end + summary + _packed(footer) + MAGIC

    def _append(self, record: bytes) -> None:
        view = memoryview(record)
        try:
            while view:
                view = view[os.write(self._file, view) :]
        except OSError as error:
            try:
                os.ftruncate(self._file, self._end)  # half a record would hide whatever is written after it
                os.lseek(self._file, self._end, os.SEEK_SET)
            except OSError:
                pass  # the error itself matters more; readers cope with half a record at the end
            raise BagWriteError(f"cannot write {self._path}: {cause(error)}") from error
        self._end += len(record)
        self._checksum = zlib.crc32(record, self._checksum)


def _packed(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def _by_time(message: tuple[int, int, int, int, bytes]) -> tuple[int, int, int]:
    return message[:3]
