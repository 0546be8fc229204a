"""What rosbag2 wants to know about a bag: metadata.yaml and the quality of service of each topic, as Jazzy writes them.

The text is in block style, a line for each entry, as rosbag2 writes it, because not every tool reads any other.
metadata.yaml is written when a bag is begun and when it is closed, not in flight: that takes some 5 ms for a mission's
bag, even with libyaml.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

METADATA_FILE = "metadata.yaml"
ROSBAG2_RECORD = "rosbag2"
"""Name of the MCAP metadata record in which rosbag2 repeats metadata.yaml."""
SERIALIZED_METADATA = "serialized_metadata"
"""Its one entry."""

VERSION = 9
"""Version of the layout: that of ROS 2 Jazzy."""

DISTRIBUTION = "jazzy"

DEFAULT_DEPTH = 10

# RMW_DURATION_INFINITE, in the words of rosbag2
_FOREVER = {"sec": 9223372036, "nsec": 854775807}
_LONGEST_PROFILES = 100_000
_LARGEST_NUMBER = 1 << 64
_WIDTH = 1 << 30  # no line is folded


class _BlockDumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]  # chosen at run time
    """As rosbag2 writes: one line a text, and what occurs twice written out twice."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_str(self, data: str) -> yaml.ScalarNode:
        style = None if data and data.isprintable() else '"'
        return self.represent_scalar("tag:yaml.org,2002:str", data, style=style)


_BlockDumper.add_representer(str, _BlockDumper.represent_str)


@dataclass(frozen=True)
class MessageType:
    """A message type with all that a reader needs to decode it."""

    name: str
    """Such as nav_msgs/msg/Odometry."""
    definition: str
    """Its .msg file, followed by those of the types in it, as rosbag2 joins them."""
    type_hash: str
    """RIHS01 hash; empty where nobody knows it."""
    encoding: str = "ros2msg"
    """Language of the definition: ros2msg or ros2idl."""


@dataclass(frozen=True)
class BagTopic:
    """One topic of a bag."""

    name: str
    message_type: MessageType
    qos: str
    """offered_qos_profiles, as :func:`qos_profiles` gives it."""


@functools.cache
def qos_profiles(*, latched: bool, depth: int = DEFAULT_DEPTH) -> str:
    """The quality of service that the publishers of a topic offer, as a YAML list of one profile.

    Args:
        latched: whether a late joiner gets the newest samples; ``ros2 bag play`` then latches the topic as well.
        depth: samples that a publisher keeps.
    """
    profile = {
        "history": "keep_last",
        "depth": depth,
        "reliability": "reliable",
        "durability": "transient_local" if latched else "volatile",
        "deadline": _FOREVER,
        "lifespan": _FOREVER,
        "liveliness": "automatic",
        "liveliness_lease_duration": _FOREVER,
        "avoid_ros_namespace_conventions": False,
    }
    return _dumped([profile])


def serialized_metadata(
    topics: Sequence[BagTopic],
    counts: Sequence[int],
    *,
    file_name: str,
    start_ns: int,
    end_ns: int,
    custom_data: Mapping[str, str],
) -> str:
    """What rosbag2 stores about a bag inside its MCAP file, YAML.

    Args:
        topics: all topics, also those without a message.
        counts: messages of each of them.
        file_name: the bag's one file, relative to its folder.
        start_ns: smallest log time [ns].
        end_ns: largest log time [ns].
        custom_data: facts about the recording.
    """
    total, name = sum(counts), printable(file_name)
    span = {
        "duration": {"nanoseconds": end_ns - start_ns},
        "starting_time": {"nanoseconds_since_epoch": start_ns},
        "message_count": total,
    }
    information = {
        "version": VERSION,
        "storage_identifier": "mcap",
        **span,
        "topics_with_message_count": [
            {"topic_metadata": _topic(topic), "message_count": count}
            for topic, count in zip(topics, counts, strict=True)
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [name],
        "files": [{"path": name, **span}],
        "custom_data": dict(custom_data) or None,
        "ros_distro": DISTRIBUTION,
    }
    return _dumped(information)


def metadata_yaml(serialized: str) -> str:
    """The content of metadata.yaml.

    Args:
        serialized: the same facts, as :func:`serialized_metadata` gives them.
    """
    return "rosbag2_bagfile_information:\n" + "".join(f"  {line}\n" for line in serialized.splitlines())


def _topic(topic: BagTopic) -> dict[str, Any]:
    return {
        "name": topic.name,
        "type": topic.message_type.name,
        "serialization_format": "cdr",
        "offered_qos_profiles": _profiles(topic.qos),
        "type_description_hash": topic.message_type.type_hash,
    }


@functools.lru_cache(maxsize=16)
def _profiles(text: str) -> list[dict[str, Any]]:
    """Profiles as another recorder wrote them; none where they are no list of profiles."""
    if not text or len(text) > _LONGEST_PROFILES or set("&*") & set(text):  # aliases can stand for gigabytes
        return []
    try:
        profiles = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError):
        return []
    return profiles if isinstance(profiles, list) and all(map(_is_profile, profiles)) else []


def _is_profile(value: object, depth: int = 2) -> bool:
    """Names with single values, or with names that have single values."""
    if isinstance(value, dict):
        return depth > 0 and all(
            isinstance(name, str) and _is_profile(entry, depth - 1) for name, entry in value.items()
        )
    is_single = isinstance(value, str | float) or (isinstance(value, int) and abs(value) < _LARGEST_NUMBER)
    return depth < 2 and is_single


def _dumped(value: object) -> str:
    text: str = yaml.dump(
        value, Dumper=_BlockDumper, default_flow_style=False, sort_keys=False, allow_unicode=True, width=_WIDTH
    )
    return text


def printable(text: str) -> str:
    """A text that UTF-8 can hold: bytes of another encoding, as file names may have, become escapes."""
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")


def as_texts(facts: Mapping[str, object]) -> dict[str, str]:
    """Facts as the texts that custom_data and MCAP metadata hold: texts as they are, anything else as JSON."""
    texts = {str(key): value if isinstance(value, str) else json.dumps(value) for key, value in facts.items()}
    return {printable(key): printable(value) for key, value in texts.items()}
