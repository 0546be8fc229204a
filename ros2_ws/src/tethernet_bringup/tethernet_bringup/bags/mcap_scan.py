"""Reads one MCAP file, also a damaged one, front to back, in bounded memory.

A reader that trusts the file's end finds nothing in a bag whose recorder was killed, and one that trusts every length
loses all that follows a wrong one: the readers of the `mcap` package do either, keep as much in memory as a chunk of a
few kB claims to hold, and do not compare the closing part's checksum. This one goes from record to record, and trusts

- a record's length where the lengths inside the record agree with it, or where another record begins at its end; of
  two lengths that both lead to a record the shorter one, since a wrong one may lead to a later record by chance;
  otherwise it searches on, byte by byte, for the next whole record;
- a chunk's content where its checksum fits;
- schemas and channels as the closing part repeats them, where that keeps its checksum; else as they first occur.

So damage costs what it hits: at most the chunk that it is in. Afterwards the checksums over all of the file are
compared and the messages are counted, so that "whole" is never said of a file that was changed.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import IO

from mcap.opcode import Opcode

from tethernet_bringup.bags.contents import LARGEST_DESCRIPTION_BYTES, LARGEST_RECORD_BYTES, BagContents, BagMessage
from tethernet_bringup.bags.errors import NotABagError
from tethernet_bringup.bags.file_bytes import FileBytes
from tethernet_bringup.bags.inflate import COMPRESSIONS, InflateError, Inflater
from tethernet_bringup.bags.mcap_records import (
    CHUNK,
    CRC,
    LONGEST_CHUNK_HEAD_BYTES,
    MESSAGE,
    RECORD,
    inner_length,
    is_head,
    is_private,
)
from tethernet_bringup.bags.mcap_summary import read_summary
from tethernet_bringup.bags.mcap_topics import TopicTable
from tethernet_bringup.bags.mcap_writer import MAGIC

# Records that a search may stop at: opcode, and a length below 4 GiB.
_CANDIDATE = re.compile(rb"[\x03-\x07\x09\x0c\x0f](?=[\x00-\xff]{4}\0{4})")
_CANDIDATE_BYTES = RECORD.size
_DESCRIPTIONS = {Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA}
_DAMAGED = (struct.error, UnicodeDecodeError, ValueError)

_Messages = Generator[BagMessage, None, int | None]


class McapScan:
    """One pass over one file.

    Args:
        contents: gets topics, facts and problems.
        path: of the file, for what is said about it.
        stream: the open file.
        wanted: which topics to yield messages of.
    """

    def __init__(self, contents: BagContents, path: Path, stream: IO[bytes], wanted: Callable[[str], bool]):
        self._contents = contents
        self._path = path
        self._file = FileBytes(stream)
        self._size = self._file.size
        self._summary = read_summary(self._file)
        self._topics = TopicTable(contents, self._summary, wanted)
        self._inflate = Inflater(self._size)
        self._seen = 0
        self._unusable: Counter[int] = Counter()  # messages without topic or type, by channel

    def messages(self) -> Iterator[BagMessage]:
        """The messages in the order of the file.

        Raises:
            NotABagError: when it is no MCAP file.
            BagError: when it cannot be read.
        """
        self._check_start()
        position, lost_from = len(MAGIC), None
        while True:
            if self._is_end(position):
                break
            after = yield from self._record(position)
            if after is not None and lost_from is not None:
                self._problem(lost_from, f"{position - lost_from} bytes that hold no whole record were left out")
                lost_from = None
            elif after is None:
                lost_from = position if lost_from is None else lost_from
                found = self._search(position + 1)
                if found is None:
                    yield from self._torn(lost_from, position)
                    break
                after = found
            position = after
        self._finish(position, torn=lost_from is not None)

    def _check_start(self) -> None:
        if self._size == 0:
            raise NotABagError(f"{self._path} is empty: nothing was recorded, nothing can be recovered")
        if self._size >= len(MAGIC) and self._file(0, len(MAGIC)) == MAGIC:
            return
        header_at = len(MAGIC)
        if self._size > header_at + RECORD.size and (self._summary.is_there or self._is_header(header_at)):
            self._problem(0, "the first bytes are not those of an MCAP file; the rest is")
            return
        raise NotABagError(f"{self._path} is no MCAP file: it does not begin like one")

    def _is_header(self, position: int) -> bool:
        opcode, length = self._head(position)
        return opcode == Opcode.HEADER and self._inner_length(opcode, position) == length

    def _head(self, position: int) -> tuple[int, int]:
        return RECORD.unpack(self._file(position, RECORD.size))

    def _inner_length(self, opcode: int, position: int) -> int | None:
        body = position + RECORD.size
        return inner_length(opcode, lambda offset, count: self._file(body + offset, count), self._size - body)

    def _begins_record(self, position: int) -> bool:
        """Whether a record, or the file's end, can be at this place."""
        room = self._size - position
        if room < RECORD.size:
            return room == 0 or (room == len(MAGIC) and self._file(position, room) == MAGIC)
        return is_head(*self._head(position), room - RECORD.size)

    def _is_end(self, position: int) -> bool:
        """Whether the messages end here as they should."""
        if self._summary.start is not None and position >= self._summary.start:
            return True
        if self._size - position < RECORD.size:
            return False
        opcode, length = self._head(position)
        after = position + RECORD.size + length
        if not is_head(opcode, length, self._size - position - RECORD.size):
            return False
        if opcode == Opcode.FOOTER:
            return after >= self._size - len(MAGIC)
        return opcode == Opcode.DATA_END and self._begins_record(after)

    def _record(self, position: int) -> _Messages:
        """Take one record; returns where the next one is, None where this is none that can be trusted."""
        body, room = position + RECORD.size, self._size - position - RECORD.size
        if room < 0:
            return None
        opcode, length = self._head(position)
        if opcode == Opcode.CHUNK:
            return (yield from self._chunk(position, length))
        end = body + length
        if length > room:
            return None
        followed, inner = self._begins_record(end), self._inner_length(opcode, position)
        if inner != length:
            if self._inner_length(Opcode.CHUNK, position) == length and self._is_chunk(body):
                self._problem(position, "a chunk calls itself something else")
                return (yield from self._chunk(position, length))
            if not followed:
                return None
            if inner is not None and inner < length and self._is_trusted(body + inner):
                end = body + inner
        if opcode == Opcode.MESSAGE and MESSAGE.size <= length <= LARGEST_RECORD_BYTES:
            yield from self._chunk_messages(position, self._file(position, RECORD.size + length))
        elif opcode in _DESCRIPTIONS:
            self._describe(position, opcode, self._file(body, min(length, LARGEST_DESCRIPTION_BYTES + 1)))
        elif not (Opcode.HEADER <= opcode <= Opcode.DATA_END or is_private(opcode)):
            self._problem(position, f"unknown record {opcode:#x}")
        elif inner is not None and inner != length:
            self._problem(position, "a damaged record was left out")
        return end

    def _is_chunk(self, body: int) -> bool:
        """Whether a chunk's compression is named where it should be."""
        (length,) = CRC.unpack(self._file(body + CHUNK.size, 4))
        return length <= 4 and self._file(body + CHUNK.size + 4, length) in {name.encode() for name in COMPRESSIONS}

    def _search(self, start: int) -> int | None:
        """The next place at which a record begins that can be trusted."""
        tail, tail_at = b"", start
        for block in self._file.blocks(start, self._size):
            content = tail + block
            for match in _CANDIDATE.finditer(content):
                if self._is_trusted(tail_at + match.start()):
                    return tail_at + match.start()
            tail = content[-_CANDIDATE_BYTES + 1 :]
            tail_at += len(content) - len(tail)
        return None

    def _is_trusted(self, position: int) -> bool:
        room = self._size - position - RECORD.size
        opcode, length = self._head(position)
        if not is_head(opcode, length, room):
            return False
        inner = self._inner_length(opcode, position)
        if opcode == Opcode.MESSAGE:
            (channel,) = struct.unpack("<H", self._file(position + RECORD.size, 2))
            if channel not in self._topics.channels:
                return False
        elif inner != length:
            return False
        end = position + RECORD.size + length
        return end > self._size or self._begins_record(end)  # only a chunk may reach beyond the end

    def _chunk(self, position: int, length: int) -> _Messages:
        body, room = position + RECORD.size, self._size - position - RECORD.size
        inner = self._inner_length(Opcode.CHUNK, position)
        lengths = [given for given in dict.fromkeys((length, inner)) if given is not None and given <= room]
        ends = [body + given for given in lengths]
        if len(ends) > 1:  # one of them is wrong: what lies there may look like a record's head, or be a later one's
            ends.sort(key=lambda end: (not self._is_trusted(end), end))
        end = next((end for end in ends if self._begins_record(end)), None)
        if not lengths or max(lengths) < CHUNK.size + 12:
            return end
        try:
            content = self._content(body, lengths)
        except (InflateError, *_DAMAGED) as error:
            if end is not None:
                self._problem(position, f"a chunk was left out, {error}")
            return end
        yield from self._chunk_messages(position, content)
        return ends[0] if end is None else end

    def _content(self, body: int, lengths: list[int]) -> bytes | bytearray:
        """A chunk's content, by whichever of its lengths gives the one that its checksum is of."""
        size, checksum, compression, begin = self._chunk_head(body)
        sizes = [length - begin for length in lengths if length >= begin]
        if not compression and size <= max(sizes, default=0):
            sizes.append(size)
        why = "its lengths are wrong"
        for each in dict.fromkeys(sizes):
            if each > LARGEST_RECORD_BYTES:
                why = f"it is longer than {LARGEST_RECORD_BYTES >> 20} MiB"
                continue
            try:
                content = self._inflate(compression, self._file(body + begin, each))
            except InflateError as error:
                why = str(error)
                continue
            if zlib.crc32(content) == checksum if checksum else len(content) == size:
                return content
            why = "its checksum is wrong" if checksum else "its content has not the size that it says"
        raise InflateError(why)

    def _chunk_head(self, body: int) -> tuple[int, int, str, int]:
        """Size and checksum of the content, compression, where the data begin."""
        head = self._file(body, min(LONGEST_CHUNK_HEAD_BYTES, self._size - body))
        _, _, size, checksum = CHUNK.unpack_from(head)
        (length,) = CRC.unpack_from(head, CHUNK.size)
        begin = CHUNK.size + 4 + length + 8
        if begin > len(head):
            raise InflateError("its compression is unknown")
        return size, checksum, head[CHUNK.size + 4 : begin - 8].decode(), begin

    def _chunk_messages(
        self, position: int, content: bytes | bytearray, *, torn: bool = False
    ) -> Generator[BagMessage, None, None]:
        offset, end, view = 0, len(content), memoryview(content)
        names, head, record = self._topics.names, MESSAGE.unpack_from, RECORD.unpack_from
        while end - offset >= RECORD.size:
            opcode, length = record(content, offset)
            start = offset + RECORD.size
            if length > end - start:
                break
            offset = start + length
            if opcode == Opcode.MESSAGE and length >= MESSAGE.size:
                channel, sequence, log_time, publish_time = head(content, start)
                name = names.get(channel, "")
                if name == "" and self._topics.take_repeated(channel):
                    name = names[channel]
                if name:
                    self._seen += 1
                    yield BagMessage(name, log_time, publish_time, sequence, bytes(view[start + MESSAGE.size : offset]))
                elif name is None:
                    self._seen += 1
                else:
                    self._unusable[channel] += 1
            elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                self._describe(position, opcode, view[start:offset])
            elif not is_private(opcode):
                self._problem(position, f"the rest of a chunk was left out, a record {opcode:#x} is in it")
                return
        if offset != end and not torn:
            self._problem(position, "the last record of a chunk is cut off")

    def _describe(self, position: int, opcode: int, body: bytes | memoryview) -> None:
        if problem := self._topics.describe(opcode, body):
            self._problem(position, problem)

    def _torn(self, lost_from: int, position: int) -> Iterator[BagMessage]:
        """What a cut-off chunk begins with: it is decompressed block by block, so the whole ones can be had."""
        room = self._size - position - RECORD.size
        body = position + RECORD.size
        if room <= 0:
            self._problem(lost_from, "it ends without the closing part, as after a killed recorder")
            return
        if room < CHUNK.size + 12 or self._head(position)[0] != Opcode.CHUNK or not self._is_chunk(body):
            self._problem(lost_from, "from there on it holds no records")
            return
        self._problem(position, "it ends in the middle of a chunk")
        try:
            _, _, compression, begin = self._chunk_head(body)
            data = self._file(body + begin, min(max(room - begin, 0), LARGEST_RECORD_BYTES))
            yield from self._chunk_messages(position, self._inflate(compression, data), torn=True)
        except InflateError as error:
            self._problem(position, f"this chunk was left out, {error}")
        except _DAMAGED:
            return  # not even its beginning is there

    def _finish(self, position: int, *, torn: bool) -> None:
        """Say what the end of the file says about the rest."""
        summary = self._summary
        for channel, left_out in self._unusable.items():
            known = self._topics.channels.get(channel)
            what = f"{known.topic}: its type" if known else f"topic number {channel}: its name"
            self._problem(position, f"{left_out} messages were left out of {what} is not in the bag")
        if torn:
            return
        if not (summary.is_there and summary.is_whole):
            self._problem(position, "the closing part is damaged; no message is in it")
        self._check_data(position)
        expected = summary.message_count if summary.is_checked else None
        if expected is not None and expected != self._seen:
            missing = expected - self._seen
            count = f"{missing} of {expected} messages are missing" if missing > 0 else f"{-missing} messages too many"
            self._problem(position, count)

    def _check_data(self, position: int) -> None:
        """Compare the checksum over all that comes before the closing part."""
        start = self._summary.start
        verified = self._summary.is_checked and start is not None
        if self._size - position > RECORD.size and self._head(position) == (Opcode.DATA_END, CRC.size):
            (checksum,) = CRC.unpack(self._file(position + RECORD.size, CRC.size))
            if checksum and self._file.checksum(0, position) != checksum:
                self._problem(position, "it was changed after it was written: the checksum over all of it is wrong")
            verified &= checksum != 0 and start == position + RECORD.size + CRC.size
        else:
            self._problem(position, "the record that ends the messages is damaged")
        self._contents.verified &= verified

    def _problem(self, position: int, what: str) -> None:
        self._contents.note(f"{self._path.name}, byte {position} of {self._size}: {what}")
