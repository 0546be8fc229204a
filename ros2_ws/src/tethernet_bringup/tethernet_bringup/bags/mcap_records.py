"""How MCAP records are laid out, as far as a reader of damaged files needs it: to tell a record from rubbish.

Most records say their length twice: at their head, and by the lengths of the texts and arrays in them. Where the two
agree, the length is right; where they do not, one of them is damaged.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from mcap.opcode import Opcode

from tethernet_bringup.bags.contents import LARGEST_RECORD_BYTES

RECORD = struct.Struct("<BQ")
"""Head of a record: opcode, length of what follows [B]."""
MESSAGE = struct.Struct("<HIQQ")
"""Head of a message: channel, sequence, log time [ns], publish time [ns]."""
CHUNK = struct.Struct("<QQQI")
"""Head of a chunk: first and last log time [ns], size of the content [B], its CRC-32; compression and data follow."""
FOOTER = struct.Struct("<QQI")
"""Start of the summary, start of the summary's offsets, CRC-32 from the first up to here."""
CRC = struct.Struct("<I")

FOOTER_BYTES = RECORD.size + FOOTER.size
LONGEST_CHUNK_HEAD_BYTES = 64

# Bytes before the first text or array, how each of these gives its length, bytes after the last.
_LAYOUT: dict[int, tuple[int, str, int]] = {
    Opcode.HEADER: (0, "II", 0),
    Opcode.FOOTER: (FOOTER.size, "", 0),
    Opcode.SCHEMA: (2, "III", 0),
    Opcode.CHANNEL: (4, "III", 0),
    Opcode.CHUNK: (CHUNK.size, "IQ", 0),
    Opcode.MESSAGE_INDEX: (2, "I", 0),
    Opcode.ATTACHMENT: (16, "IIQ", 4),
    Opcode.METADATA: (0, "II", 0),
    Opcode.DATA_END: (CRC.size, "", 0),
}
_LENGTHS = {"I": struct.Struct("<I"), "Q": struct.Struct("<Q")}
_EXACT = {Opcode.FOOTER, Opcode.DATA_END}
_FIRST_PRIVATE = 0x80


def shortest(opcode: int) -> int:
    """The least length of a record's body [B]."""
    if opcode == Opcode.MESSAGE:
        return MESSAGE.size
    before, lengths, after = _LAYOUT.get(opcode, (0, "", 0))
    return before + sum(_LENGTHS[kind].size for kind in lengths) + after


def is_head(opcode: int, length: int, room: int) -> bool:
    """Whether this can be a record's head.

    Args:
        opcode: of any value.
        length: of the body by the head [B].
        room: bytes that follow the head in the file; only a chunk, which is long, may be cut off by its end.
    """
    if not (Opcode.HEADER <= opcode <= Opcode.DATA_END or opcode >= _FIRST_PRIVATE):
        return False
    if length < shortest(opcode) or (opcode in _EXACT and length != shortest(opcode)):
        return False
    return length <= room or (opcode == Opcode.CHUNK and length <= LARGEST_RECORD_BYTES + LONGEST_CHUNK_HEAD_BYTES)


def is_private(opcode: int) -> bool:
    """Whether readers shall pass over a record in silence: others' extensions."""
    return opcode >= _FIRST_PRIVATE


def inner_length(opcode: int, peek: Callable[[int, int], bytes], room: int) -> int | None:
    """Length of a record's body as the texts and arrays in it make it [B].

    Args:
        opcode: of the record.
        peek: gives so many bytes from a place in the body.
        room: bytes from the body's start to the file's end.

    Returns:
        None for records without such a structure, and where the lengths lead out of the file.
    """
    if opcode not in _LAYOUT:
        return None
    offset, lengths, after = _LAYOUT[opcode]
    for kind in lengths:
        layout = _LENGTHS[kind]
        if offset + layout.size > room:
            return None
        (length,) = layout.unpack(peek(offset, layout.size))
        offset += layout.size + length
    return offset + after
