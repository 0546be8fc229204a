"""Decompresses a bag's chunks, messages and files in bounded memory and time, whatever they claim to hold.

A few bytes of zstd or lz4 can stand for gigabytes. A chunk that inflates to more than
:data:`~tethernet_bringup.bags.contents.LARGEST_RECORD_BYTES` is given up, and so is every further one of a file whose
chunks together inflate to more than :data:`LARGEST_RATIO` times its size: the time spent on a file then goes with its
size.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import IO

import zstandard

from tethernet_bringup.bags.contents import LARGEST_RECORD_BYTES
from tethernet_bringup.bags.errors import BagError

LARGEST_RATIO = 250
"""Inflated bytes per byte of the file; sensor data have 1 to 20."""
COMPRESSIONS = ("", "lz4", "zstd")
_FRAMES = {b"\x28\xb5\x2f\xfd": "zstd", b"\x04\x22\x4d\x18": "lz4"}
_PIECE_BYTES = 1 << 20
_SLICE_BYTES = 1 << 10  # of zstd: 3 bytes can stand for a block of 128 KiB


class InflateError(BagError):
    """A chunk cannot be decompressed; the text says why."""


def frame_compression(data: bytes) -> str:
    """How data are compressed as a whole, by their first bytes; empty where they are not.

    No serialized message, MCAP file or SQLite file begins like a compressed frame.
    """
    return _FRAMES.get(data[:4], "")


class Inflater:
    """Decompresses what is compressed in one file: its chunks, its messages, or all of it.

    Args:
        file_bytes: size of the file [B].
    """

    def __init__(self, file_bytes: int):
        self._left = LARGEST_RECORD_BYTES + LARGEST_RATIO * file_bytes

    def __call__(self, compression: str, data: bytes) -> bytes | bytearray:
        """The content; of data that were cut off, as much as can be had.

        Args:
            compression: one of :data:`COMPRESSIONS`.
            data: one frame; what follows it is not looked at.

        Raises:
            InflateError: the content is too large, or the data are damaged.
        """
        if compression not in COMPRESSIONS:
            raise InflateError(f"its compression {compression[:20]!r} is unknown")
        if not compression:
            return data
        content = bytearray()
        for piece in self._pieces(_zstd_pieces(data) if compression == "zstd" else _lz4_pieces(data)):
            content += piece
            if len(content) > LARGEST_RECORD_BYTES:
                raise InflateError(f"it inflates to more than {LARGEST_RECORD_BYTES >> 20} MiB")
        return content

    def whole_file(self, compression: str, source: IO[bytes], target: IO[bytes]) -> None:
        """Decompress a file; of one that was cut off or is damaged, as much as can be had is in the target.

        Args:
            compression: zstd or lz4.
            source: at its start.
            target: gets the content.

        Raises:
            InflateError: the content is too large, or the data are damaged or cut off.
            OSError: when a file cannot be read or written.
        """
        for piece in self._pieces(_zstd_file(source) if compression == "zstd" else _lz4_file(source)):
            target.write(piece)

    def _pieces(self, pieces: Iterator[bytes]) -> Iterator[bytes]:
        try:
            self._spend(0)
            for piece in pieces:
                self._spend(len(piece))
                yield piece
        except EOFError as error:
            raise InflateError("it is cut off") from error
        except (zstandard.ZstdError, RuntimeError, MemoryError, ValueError) as error:
            raise InflateError(f"it cannot be decompressed ({error})") from error

    def _spend(self, inflated: int) -> None:
        self._left -= inflated
        if self._left <= 0:
            raise InflateError(f"the file inflates to more than {LARGEST_RATIO} times its size")


def _zstd_pieces(data: bytes) -> Iterator[bytes]:
    decompressor = zstandard.ZstdDecompressor(max_window_size=LARGEST_RECORD_BYTES)
    with decompressor.stream_reader(io.BytesIO(data), read_size=_PIECE_BYTES) as stream:
        while piece := stream.read(_PIECE_BYTES):
            yield piece


def _zstd_file(source: IO[bytes]) -> Iterator[bytes]:
    decompressor = zstandard.ZstdDecompressor(max_window_size=LARGEST_RECORD_BYTES)
    frame, data = None, b""
    while data or (data := source.read(_SLICE_BYTES)):
        frame = frame or decompressor.decompressobj()
        yield frame.decompress(data)
        data = frame.unused_data
        if frame.eof:
            frame = None  # another may follow: parallel compressors write several
    if frame is not None:
        raise EOFError


def _lz4_file(source: IO[bytes]) -> Iterator[bytes]:
    import lz4.frame

    with lz4.frame.LZ4FrameFile(source) as stream:
        while piece := stream.read(_PIECE_BYTES):
            yield piece


def _lz4_pieces(data: bytes) -> Iterator[bytes]:
    import lz4.frame

    decompressor, given = lz4.frame.LZ4FrameDecompressor(), data
    while not decompressor.eof:
        piece = decompressor.decompress(given, max_length=_PIECE_BYTES)
        if not piece and decompressor.needs_input:
            return  # cut off
        given = b""
        yield piece
