"""Random access to a file in bounded memory; no memory map, which kills the process when the file is cut."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from typing import IO

from tethernet_bringup.bags.errors import BagError

_WINDOW_BYTES = 1 << 18


class FileBytes:
    """The bytes of an open file.

    Args:
        stream: stays open as long as this is used.
    """

    def __init__(self, stream: IO[bytes]):
        self._handle = stream.fileno()
        self._name = stream.name
        self.size = os.fstat(self._handle).st_size
        """[B]"""
        self._start = 0
        self._window = b""

    def __call__(self, position: int, count: int) -> bytes:
        """So many bytes from a place.

        Raises:
            BagError: when the file has become shorter since it was opened.
        """
        offset = position - self._start
        if offset < 0 or offset + count > len(self._window):
            self._window = os.pread(self._handle, max(count, _WINDOW_BYTES), position)
            self._start, offset = position, 0
            if len(self._window) < count:
                raise BagError(f"{self._name} became shorter while it was read")
        found = self._window[offset : offset + count]
        if len(self._window) > 4 * _WINDOW_BYTES:
            self._window = b""  # a long record is not kept twice
        return found

    def blocks(self, start: int, stop: int) -> Iterator[bytes]:
        """The bytes from start to stop, piece by piece."""
        while start < stop:
            block = os.pread(self._handle, min(_WINDOW_BYTES, stop - start), start)
            if not block:
                raise BagError(f"{self._name} became shorter while it was read")
            yield block
            start += len(block)

    def checksum(self, start: int, stop: int) -> int:
        """CRC-32 of the bytes from start to stop."""
        crc = 0
        for block in self.blocks(start, stop):
            crc = zlib.crc32(block, crc)
        return crc
