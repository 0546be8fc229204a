"""The closing part of an MCAP file: a second copy of its schemas and channels, its counts, and its checksums."""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass, field

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Schema, Statistics

from tethernet_bringup.bags.contents import LARGEST_DESCRIPTION_BYTES, MOST_DESCRIPTION_BYTES
from tethernet_bringup.bags.file_bytes import FileBytes
from tethernet_bringup.bags.mcap_records import FOOTER, FOOTER_BYTES, RECORD
from tethernet_bringup.bags.mcap_writer import MAGIC


@dataclass
class Summary:
    """What the closing part says."""

    is_there: bool = False
    """Whether the file ends as a finished one does."""
    is_whole: bool = False
    """Whether its checksum fits."""
    is_checked: bool = False
    """Whether it has a checksum at all."""
    start: int | None = None
    """Where it begins in the file [B]; None where there is none."""
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    message_count: int | None = None
    """Messages in the file; None where it does not say."""


def read_summary(file: FileBytes) -> Summary:
    """Read the closing part; one that does not keep its checksum gives nothing, because it cannot be trusted.

    Args:
        file: of any content.
    """
    summary = Summary()
    footer_at = file.size - len(MAGIC) - FOOTER_BYTES
    if footer_at < len(MAGIC):
        return summary
    tail = file(footer_at, FOOTER_BYTES + len(MAGIC))
    if RECORD.unpack_from(tail) != (Opcode.FOOTER, FOOTER.size):
        return summary
    start, _, checksum = FOOTER.unpack_from(tail, RECORD.size)
    summary.is_there = tail.endswith(MAGIC)
    summary.is_checked = checksum != 0
    if start == 0:
        summary.is_whole = summary.is_there
        return summary
    end = footer_at + FOOTER_BYTES - 4  # all but the checksum itself
    if not len(MAGIC) <= start <= footer_at or (checksum and file.checksum(start, end) != checksum):
        return summary
    summary.start = start
    try:
        _read_records(file, summary, start, footer_at)
    except (McapError, struct.error, UnicodeDecodeError, ValueError):
        return Summary(is_there=summary.is_there, is_checked=summary.is_checked)
    summary.is_whole = summary.is_there
    return summary


def _read_records(file: FileBytes, summary: Summary, start: int, end: int) -> None:
    position, kept = start, 0
    while position < end:
        opcode, length = RECORD.unpack(file(position, RECORD.size))
        if length > end - position - RECORD.size:
            raise ValueError("a record reaches beyond the closing part")
        if opcode in {Opcode.SCHEMA, Opcode.CHANNEL, Opcode.STATISTICS} and length <= LARGEST_DESCRIPTION_BYTES:
            kept += length
            if kept > MOST_DESCRIPTION_BYTES:
                raise ValueError("more descriptions than a bag has")
            stream = ReadDataStream(io.BytesIO(file(position + RECORD.size, length)))
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                summary.schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(stream)
                summary.channels[channel.id] = channel
            else:
                summary.message_count = Statistics.read(stream).message_count
        position += RECORD.size + length
