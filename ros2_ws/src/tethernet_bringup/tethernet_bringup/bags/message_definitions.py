"""Message types as the installed message packages describe them: definition text, type hash, where the stamp is.

A bag carries these, so that it can be read where the packages are not installed. The packages are
looked up in the folders that ROS 2 is installed in; nothing of ROS 2 is imported or running for this.
"""

from __future__ import annotations

import functools
import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tethernet_bringup.bags.errors import BagError
from tethernet_bringup.bags.metadata import MessageType

_DELIMITER = "=" * 80
_NESTED = 1  # type_description_interfaces/msg/FieldType
_ENCAPSULATION_BYTES = 4
_LENGTH_BYTES = 4


class UnknownTypeError(BagError):
    """A message type is not installed."""


@dataclass(frozen=True)
class InstalledType:
    """A message type found on this machine."""

    message_type: MessageType
    stamp_offset: int | None
    """Where a serialized message has its stamp (sec int32, nanosec uint32) [B]; None for a type without."""
    stamp_in_array: bool
    """Whether the stamp is that of the first element of an array, so that a short message has none."""


@functools.cache
def installed_type(name: str) -> InstalledType:
    """Look up a message type.

    Args:
        name: such as nav_msgs/msg/Odometry.

    Raises:
        UnknownTypeError: when its package or the type is not installed.
    """
    description = _description(name)
    nested = {
        entry["type_name"]: entry for entry in description["type_description_msg"]["referenced_type_descriptions"]
    }
    parts = [_definition(name)]
    for other in sorted(nested):
        parts.append(f"{_DELIMITER}\nMSG: {_short(other)}\n{_definition(other)}")
    hashes = {entry["type_name"]: entry["hash_string"] for entry in description["type_hashes"]}
    message_type = MessageType(name=name, definition="\n".join(parts), type_hash=hashes[name])
    offset, in_array = _stamp(description["type_description_msg"]["type_description"], nested)
    return InstalledType(message_type, offset, in_array)


@functools.cache
def known_type(name: str) -> MessageType | None:
    """A message type of which a bag holds no definition: as installed, else as rosbags has it for Jazzy.

    Args:
        name: such as nav_msgs/msg/Odometry; None where neither knows it.
    """
    try:
        return installed_type(name).message_type
    except (UnknownTypeError, KeyError, ValueError):
        pass
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    if name not in store.fielddefs:
        return None
    definition, _ = store.generate_msgdef(name, ros_version=2)
    return MessageType(name, definition, store.hash_rihs01(name))


def _file(name: str, suffix: str) -> Path:
    package, kind, short = (*name.split("/"), "", "")[:3]
    if kind != "msg" or not short:
        raise UnknownTypeError(f"message type {name!r}: expected PACKAGE/msg/NAME, such as nav_msgs/msg/Odometry")
    # A sourced ROS 2 names its folders; without one the packages are in the virtual environment itself.
    prefixes = [prefix for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
    for prefix in (*prefixes, sys.prefix):
        path = Path(prefix) / "share" / package / "msg" / (short + suffix)
        if path.is_file():
            return path
    raise UnknownTypeError(
        f"message type {name}: share/{package}/msg/{short}{suffix} is not installed in "
        + " or ".join((*prefixes, sys.prefix))
    )


def _text(name: str, suffix: str) -> str:
    path = _file(name, suffix)
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UnknownTypeError(f"message type {name}: cannot read {path}: {error.strerror}") from error


def _definition(name: str) -> str:
    return _text(name, ".msg")


def _description(name: str) -> dict[str, Any]:
    description: dict[str, Any] = json.loads(_text(name, ".json"))
    return description


def _short(name: str) -> str:
    package, _, short = name.split("/")
    return f"{package}/{short}"


def _stamp(description: dict[str, Any], nested: dict[str, dict[str, Any]]) -> tuple[int | None, bool]:
    """Where the stamp is: in a header or time that comes first, or in an array's first element if that comes first."""
    first = _first_nested(description)
    if first is None:
        return None, False
    name, in_array = first
    offset = _ENCAPSULATION_BYTES + (_LENGTH_BYTES if in_array else 0)
    while name != "builtin_interfaces/msg/Time":
        inner = _first_nested(nested[name])
        if inner is None or inner[1]:
            return None, False
        name = inner[0]
    return offset, in_array


def _first_nested(description: dict[str, Any]) -> tuple[str, bool] | None:
    if not description["fields"]:
        return None
    kind = description["fields"][0]["type"]
    if kind["type_id"] == _NESTED:
        return kind["nested_type_name"], False
    if kind["type_id"] in {_NESTED + 96, _NESTED + 144}:  # bounded and unbounded sequences
        return kind["nested_type_name"], True
    return None
