"""Messages that are sent again and again with other numbers: serialized once, then written over in place.

Turning a Python message into bytes takes the middleware a microsecond or so a number, whether it has changed or not: 80
microseconds for a nav_msgs/Odometry with its two covariance matrices, milliseconds for a picture of a net. Where the
shape of a message stays (texts and lengths of arrays), each number has its place in the bytes, which CDR, the encoding
that DDS prescribes, fixes.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from rosidl_parser.definition import (
    AbstractGenericString,
    AbstractNestedType,
    AbstractSequence,
    BasicType,
    NamespacedType,
)

_ORIGIN = 4  # [bytes] the encapsulation header; alignment counts from behind it
_STAMP = struct.Struct("<iI")
_SECOND_NS = 1_000_000_000
_FEW = 16
_SIZES = {
    "boolean": 1, "octet": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4,
    "float": 4, "int64": 8, "uint64": 8, "double": 8,
}  # fmt: skip


class Template:
    """A message of fixed shape as bytes."""

    def __init__(self, message: Any):
        """Args:
        message: as it is sent, apart from the numbers that are written later.
        """
        self.kind = type(message)
        """Its type."""
        self._data = bytearray(serialize_message(message))
        self._layout = Layout(message)
        self._few: list[Callable[[], list[float]]] = []
        self._many: list[np.ndarray] = []

    def doubles(self, path: str, count: int) -> np.ndarray:
        """A view on float64 numbers that lie one after the other: what is written to it is sent from then on.

        Args:
            path: of the first, such as ``pose.pose.position.x`` or ``markers[2].points[0].x``.
            count: how many.
        """
        return self._view(path, np.dtype("<f8"), count)

    def floats(self, path: str, count: int) -> np.ndarray:
        """The same for float32 numbers."""
        return self._view(path, np.dtype("<f4"), count)

    def flags(self, path: str, count: int) -> np.ndarray:
        """The same for booleans."""
        return np.frombuffer(self._data, np.bool_, count, self._layout.offsets[path]) if count else np.zeros(0, bool)

    def stamp(self, time_ns: int) -> None:
        """Write a time [ns] into every stamp of the message."""
        seconds, rest = divmod(time_ns, _SECOND_NS)
        for offset in self._layout.stamps:
            _STAMP.pack_into(self._data, offset, seconds, rest)

    @property
    def finite(self) -> bool:
        """Whether all numbers that can be written are finite."""
        # A sum that is finite has finite parts only; of a few numbers Python finds it in a fifth of the array's time.
        for numbers in self._few:
            if not (math.isfinite(sum(numbers())) or all(map(math.isfinite, numbers()))):
                return False
        return all(math.isfinite(view.sum()) or bool(np.isfinite(view).all()) for view in self._many)

    def bytes(self) -> bytes:
        """The message as it stands."""
        return bytes(self._data)

    def _view(self, path: str, kind: np.dtype, count: int) -> np.ndarray:
        if not count:
            return np.zeros(0, kind)
        view = np.frombuffer(self._data, kind, count, self._layout.offsets[path])
        if count <= _FEW:
            self._few.append(view.tolist)
        else:
            self._many.append(view)
        return view


class Layout:
    """Where the fields of a message lie in its bytes."""

    def __init__(self, message: Any):
        """Args:
        message: of this shape: its texts and the lengths of its arrays.
        """
        self.offsets: dict[str, int] = {}
        """Place of each field, and of each array's first element, by path [bytes]."""
        self.stamps: list[int] = []
        """Places of the stamps [bytes]."""
        self.shape: list[slice] = []
        """What the shape is told by: the texts and the lengths of arrays whose length is not part of the type."""
        self._at = _ORIGIN
        self._message(message, "")

    def _message(self, message: Any, path: str) -> None:
        if isinstance(message, Time):
            self._align(4)
            self.stamps.append(self._at)
        prefix = path + "." if path else ""
        for name, slot in zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True):
            self._field(getattr(message, name), slot, prefix + name)

    def _field(self, value: Any, slot: Any, path: str) -> None:
        if isinstance(slot, AbstractNestedType):
            if isinstance(slot, AbstractSequence):
                self._align(4)
                self.shape.append(slice(self._at, self._at + 4))
                self._at += 4
            element = slot.value_type
            if isinstance(element, BasicType) and len(value):
                self._numbers_at(_SIZES[element.typename], len(value), f"{path}[0]")
            elif not isinstance(element, BasicType):
                for index, item in enumerate(value):
                    self._field(item, element, f"{path}[{index}]")
        elif isinstance(slot, BasicType):
            self._numbers_at(_SIZES[slot.typename], 1, path)
        elif isinstance(slot, AbstractGenericString):
            self._align(4)
            begin, self._at = self._at, self._at + 4 + len(value.encode()) + 1
            self.shape.append(slice(begin, self._at))
        elif isinstance(slot, NamespacedType):
            self._message(value, path)

    def _numbers_at(self, size: int, count: int, path: str) -> None:
        self._align(size)
        self.offsets[path] = self._at
        self._at += size * count

    def _align(self, size: int) -> None:
        self._at += (_ORIGIN - self._at) % size
