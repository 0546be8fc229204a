"""Decodes recorded messages by the definitions in the bag itself: no message package has to be installed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tethernet_bringup.bags.metadata import MessageType
from tethernet_bringup.recorder.timeline import StampReader

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc

_TIME = "builtin_interfaces/msg/Time"
_ENCAPSULATION_BYTES, _LENGTH_BYTES = 4, 4


class Decoder:
    """Decodes CDR messages of any type whose definition it is given."""

    def __init__(self) -> None:
        from rosbags.typesys import Stores, get_typestore

        self._store = get_typestore(Stores.EMPTY)
        self._known: set[str] = set()
        self._stamps: dict[str, StampReader] = {}

    def __call__(self, kind: MessageType, data: bytes) -> Any:
        """The message, its fields as attributes; arrays of numbers are NumPy arrays.

        Raises:
            ValueError: when data does not fit the type, or the type has no usable definition.
        """
        try:
            if kind.name not in self._known:
                self._learn(kind)
            return self._store.deserialize_cdr(data, kind.name)
        except Exception as error:  # rosbags has no common class for what bad data does to it
            raise ValueError(f"{kind.name} cannot be decoded: {type(error).__name__}: {error}") from error

    def stamp_ns(self, kind: MessageType, data: bytes) -> int | None:
        """The stamp of a message [ns], not decoded any further.

        Returns:
            None for a type without a stamp or without a usable definition, and where none was set (0).
        """
        reader = self._stamps.get(kind.name)
        if reader is None:
            try:
                if kind.name not in self._known:
                    self._learn(kind)
                reader = self._stamp_reader(kind.name)
            except Exception:  # as above
                reader = StampReader(None)
            self._stamps[kind.name] = reader
        return reader(data)

    def _stamp_reader(self, name: str) -> StampReader:
        """Where the stamp is: in a header or time that comes first, or in an array's first element."""
        offset, in_array = _ENCAPSULATION_BYTES, False
        while name != _TIME:
            fields = self._store.fielddefs[name][1]
            first = _nested(fields[0][1]) if fields else None
            if first is None or (in_array and first[1]):
                return StampReader(None)
            name, is_array = first
            if is_array:
                in_array, offset = True, offset + _LENGTH_BYTES
        return StampReader(offset, in_array)

    def _learn(self, kind: MessageType) -> None:
        from rosbags.typesys import get_types_from_idl, get_types_from_msg

        if kind.encoding == "ros2idl":
            types = get_types_from_idl(kind.definition)
        else:
            types = get_types_from_msg(kind.definition, kind.name)
        self._store.register({name: fields for name, fields in types.items() if name not in self._store.types})
        self._known.add(kind.name)


def _nested(field: FieldDesc) -> tuple[str, bool] | None:
    """The message type that a field is made of, and whether it is an array of any length of them; None for others."""
    from rosbags.interfaces import Nodetype

    if field[0] == Nodetype.NAME:
        return str(field[1]), False
    if field[0] == Nodetype.SEQUENCE and field[1][0][0] == Nodetype.NAME:
        return str(field[1][0][1]), True
    return None
