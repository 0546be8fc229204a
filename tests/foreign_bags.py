"""Bags as others make them of a mission: by rosbags, and as the recorder of rosbag2 does it."""

from __future__ import annotations

import io
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import lz4.frame
import zstandard
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Reader as RosbagsReader
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from tethernet_bringup.bags.reader import BagMessage, open_bag
from tethernet_bringup.bags.writer import RUN_INFO_RECORD

WALL_NS = 1_760_000_000_000_000_000
"""When a recording is said to have begun by the wall clock."""
SPEED = 7
"""How many times faster than real time a mission in lock-step was flown."""


def by_rosbags(
    source: Path,
    target: Path,
    storage: StoragePlugin = StoragePlugin.SQLITE3,
    compression: CompressionMode = CompressionMode.NONE,
    *,
    log_time: Callable[[int], int] = lambda time: time,
    facts: bool = True,
) -> Path:
    """Convert a bag with rosbags.

    Args:
        source: bag's folder.
        target: folder of the new one.
        storage: sqlite3 or mcap.
        compression: of nothing, each message, or the file.
        log_time: gives the new log time for the old [ns].
        facts: whether those about the run are taken along; rosbags-convert leaves them.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    writer = RosbagsWriter(target, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with RosbagsReader(source) as reader, writer:
        for key, value in _facts(source).items() if facts else ():
            writer.set_custom_data(key, value)
        store = get_typestore(Stores.EMPTY)
        connections = {
            c.id: writer.add_connection(
                c.topic, c.msgtype, msgdef=c.msgdef.data, rihs01=c.digest, serialization_format="cdr", typestore=store
            )
            for c in reader.connections
        }
        for connection, time, data in reader.messages():
            writer.write(connections[connection.id], log_time(time), data)
    return target


def _facts(source: Path) -> dict[str, str]:
    bag = open_bag(source)
    assert not list(bag.messages(lambda _: False))
    return bag.metadata.get(RUN_INFO_RECORD, {})


def wall_clock(time_ns: int) -> int:
    """When a message of a mission in lock-step arrived at a recorder, by the wall clock [ns]."""
    return WALL_NS + time_ns // SPEED


def by_stock_recorder(
    source: Path,
    target: Path,
    *,
    parts: int = 1,
    compression: CompressionType = CompressionType.ZSTD,
    each: Callable[[bytes], bytes] = lambda data: data,
) -> Path:
    """A bag like those of ``ros2 bag record -s mcap``: wall-clock times, no counters, no facts, no metadata.yaml yet.

    Args:
        source: bag's folder.
        target: folder of the new one.
        parts: files that it is split into.
        compression: of chunks.
        each: what becomes of the bytes of each message.
    """
    bag = open_bag(source)
    messages = [message for message in bag.messages() if message.log_time]
    target.mkdir(parents=True)
    length = -(-len(messages) // parts)
    for part in range(parts):
        with (target / f"{target.name}_{part}.mcap").open("wb") as stream:
            writer = Writer(stream, chunk_size=1 << 18, compression=compression)
            writer.start("ros2", "rosbag2")
            channels, schemas = {}, {}
            for topic in bag.topics.values():
                kind = topic.message_type
                if kind.name not in schemas:
                    schemas[kind.name] = writer.register_schema(kind.name, kind.encoding, kind.definition.encode())
                channels[topic.name] = writer.register_channel(topic.name, "cdr", schemas[kind.name])
            for message in messages[part * length : (part + 1) * length]:
                time = wall_clock(message.log_time)
                writer.add_message(channels[message.topic], time, each(message.data), time, 0)
            writer.finish()
    return target


def compress_files(folder: Path, suffix: str) -> Path:
    """Compress each file of a bag as a whole.

    Args:
        folder: bag's folder.
        suffix: ".zstd" or ".lz4".
    """
    for path in [*folder.glob("*.mcap"), *folder.glob("*.db3")]:
        content = path.read_bytes()
        compressed = zstandard.compress(content) if suffix == ".zstd" else lz4.frame.compress(content)
        path.with_name(path.name + suffix).write_bytes(compressed)
        path.unlink()
    return folder


def copy(bag: Path, folder: Path) -> Path:
    """Another bag with the same files, which a test may damage."""
    shutil.copytree(bag, folder)
    return folder


def zstd_frame(data: bytes) -> bytes:
    """A message as rosbag2 writes it with message compression."""
    return zstandard.compress(data)


def several_frames(data: bytes) -> bytes:
    """Compressed piece by piece, as parallel compressors do."""
    stream = io.BytesIO(data)
    return b"".join(zstandard.compress(piece) for piece in iter(lambda: stream.read(1 << 16), b""))


def content(bag: Path) -> Iterator[tuple[str, bytes]]:
    """Topic and bytes of all messages."""
    messages: Iterator[BagMessage] = open_bag(bag).messages()
    return ((message.topic, message.data) for message in messages)
