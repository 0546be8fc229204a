"""What a bag holds, in the words of the stock ``ros2 bag info``."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import cast

LABEL_WIDTH = 19


class UnreadableBagError(Exception):
    """What rosbags says of a bag that it cannot read."""


def describe(bag: Path) -> str:
    """The text of the stock command.

    Args:
        bag: a bag's folder, or one file of it.
    """
    from rosbags.interfaces import ConnectionExtRosbag2
    from rosbags.rosbag2 import Reader, ReaderError

    try:
        with Reader(bag) as reader:
            files = _files(bag)
            size = sum(file.stat().st_size for file in files)
            topics = [
                f"Topic: {connection.topic} | Type: {connection.msgtype} | Count: {connection.msgcount} | "
                f"Serialization Format: {cast(ConnectionExtRosbag2, connection.ext).serialization_format}"
                for connection in sorted(reader.connections, key=lambda connection: connection.topic)
            ]
            duration_ns = max(reader.duration - 1, 0)  # rosbags ends a bag 1 ns behind its last message
            storage = "sqlite3" if files[0].suffix == ".db3" else "mcap"
            entries = {
                "Files": "\n".join(file.name for file in files),
                "Bag size": _size(size),
                "Storage id": storage,
                "ROS Distro": reader.ros_distro or "unknown",
                "Duration": f"{duration_ns / 1e9:.9f}s",
                "Start": _moment(reader.start_time),
                "End": _moment(reader.start_time + duration_ns),
                "Messages": str(reader.message_count),
                "Topic information": "\n".join(topics),
            }
    except ReaderError as error:
        raise UnreadableBagError(f"{error} `tethernet salvage` makes a torn bag whole") from error
    return "\n".join(_entry(label, text) for label, text in entries.items())


def _files(bag: Path) -> list[Path]:
    found = [bag] if bag.is_file() else sorted([*bag.glob("*.mcap*"), *bag.glob("*.db3*")])
    if not found:
        raise UnreadableBagError("it holds no .mcap and no .db3 file")
    return found


def _entry(label: str, text: str) -> str:
    first, *rest = text.split("\n")
    return "\n".join([f"{label + ':':{LABEL_WIDTH}}{first}", *(" " * LABEL_WIDTH + line for line in rest)])


def _moment(time_ns: int) -> str:
    seconds, rest_ns = divmod(time_ns, 1_000_000_000)
    local = datetime.datetime.fromtimestamp(seconds).astimezone()
    return f"{local:%b %e %Y %H:%M:%S}.{rest_ns:09d} ({seconds}.{rest_ns:09d})"


def _size(size_b: float) -> str:
    for unit in ("B", "KiB", "MiB"):
        if size_b < 1024:
            return f"{size_b:.1f} {unit}"
        size_b /= 1024
    return f"{size_b:.1f} GiB"
