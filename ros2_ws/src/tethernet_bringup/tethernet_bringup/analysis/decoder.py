"""Decodes recorded messages by the definitions in the bag itself: no message package has to be installed."""

from __future__ import annotations

from typing import Any

from tethernet_bringup.bags.metadata import MessageType


class Decoder:
    """Decodes CDR messages of any type whose definition it is given."""

    def __init__(self) -> None:
        from rosbags.typesys import Stores, get_typestore

        self._store = get_typestore(Stores.EMPTY)
        self._known: set[str] = set()

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

    def _learn(self, kind: MessageType) -> None:
        from rosbags.typesys import get_types_from_idl, get_types_from_msg

        if kind.encoding == "ros2idl":
            types = get_types_from_idl(kind.definition)
        else:
            types = get_types_from_msg(kind.definition, kind.name)
        self._store.register({name: fields for name, fields in types.items() if name not in self._store.types})
        self._known.add(kind.name)
