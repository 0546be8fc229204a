"""What rosbag2 wants to know about a bag: metadata.yaml and the quality of service of each topic, as Jazzy writes them.

The text is in block style, as rosbag2 writes it, because not every tool reads any other. It is put together by hand,
because a provisional metadata.yaml is written twice a second beside a flying mission: a YAML library takes 100 times as
long. Strings that are not plain words are JSON strings, which are YAML strings too.
"""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

METADATA_FILE = "metadata.yaml"

VERSION = 9
"""Version of the layout: that of ROS 2 Jazzy."""

DISTRIBUTION = "jazzy"

DEFAULT_DEPTH = 10

# RMW_DURATION_INFINITE, in the words of rosbag2
_FOREVER = {"sec": 9223372036, "nsec": 854775807}
_PLAIN = re.compile(r"[A-Za-z_/][\w/.-]*", re.ASCII)  # text that YAML takes for itself
_BREAKS = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff]")  # what else YAML may take for the end of a line
_LONGEST_PROFILES = 100_000
_NO_TEXT = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"}  # but not these


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
    return "\n".join(_block([profile]))


def metadata_yaml(
    topics: Sequence[BagTopic],
    counts: Sequence[int],
    *,
    file_name: str,
    start_ns: int,
    end_ns: int,
    custom_data: Mapping[str, str],
) -> str:
    """The content of metadata.yaml.

    Args:
        topics: all topics, also those without a message.
        counts: messages of each of them.
        file_name: the bag's one file, relative to its folder.
        start_ns: smallest log time [ns].
        end_ns: largest log time [ns].
        custom_data: facts about the recording.
    """
    information = _information(topics, counts, file_name, start_ns, end_ns, custom_data)
    return f"rosbag2_bagfile_information:\n{_indented(information)}"


def serialized_metadata(
    topics: Sequence[BagTopic],
    counts: Sequence[int],
    *,
    file_name: str,
    start_ns: int,
    end_ns: int,
    custom_data: Mapping[str, str],
) -> str:
    """The same facts as rosbag2 stores them inside the MCAP file; arguments as for :func:`metadata_yaml`."""
    return _information(topics, counts, file_name, start_ns, end_ns, custom_data)


def _information(
    topics: Sequence[BagTopic],
    counts: Sequence[int],
    file_name: str,
    start_ns: int,
    end_ns: int,
    custom_data: Mapping[str, str],
) -> str:
    total, name = sum(counts), _scalar(file_name)
    start = ("starting_time:", f"  nanoseconds_since_epoch: {start_ns}")
    duration = ("duration:", f"  nanoseconds: {end_ns - start_ns}")
    lines = [f"version: {VERSION}", "storage_identifier: mcap", *duration, *start, f"message_count: {total}"]
    lines.append("topics_with_message_count:" if topics else "topics_with_message_count: []")
    for topic, count in zip(topics, counts, strict=True):
        lines.append(_topic_head(topic))
        lines.append(f"    message_count: {count}")
    lines += ('compression_format: ""', 'compression_mode: ""', "relative_file_paths:", f"  - {name}")
    lines += ("files:", f"  - path: {name}", *(f"    {line}" for line in start + duration))
    lines += (f"    message_count: {total}", "custom_data:" if custom_data else "custom_data: ~")
    lines += (f"  {_scalar(key)}: {_scalar(value)}" for key, value in custom_data.items())
    lines.append(f"ros_distro: {DISTRIBUTION}")
    return "\n".join(lines) + "\n"


@functools.lru_cache(maxsize=1000)
def _topic_head(topic: BagTopic) -> str:
    profiles = _profiles(topic.qos)
    lines = [
        "  - topic_metadata:",
        f"      name: {_scalar(topic.name)}",
        f"      type: {_scalar(topic.message_type.name)}",
        "      serialization_format: cdr",
        "      offered_qos_profiles:" if profiles else "      offered_qos_profiles: []",
        *(f"        {line}" for line in _block(profiles)),
        f"      type_description_hash: {_scalar(topic.message_type.type_hash)}",
    ]
    return "\n".join(lines)


def _profiles(text: str) -> list[dict[str, Any]]:
    """Profiles as another recorder wrote them; none where they are no list of profiles."""
    if not text or len(text) > _LONGEST_PROFILES or set("&*") & set(text):  # aliases can stand for gigabytes
        return []
    import yaml  # only for the topics of a bag, once

    try:
        profiles = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError):
        return []
    is_list = isinstance(profiles, list) and all(isinstance(profile, dict) for profile in profiles)
    return profiles if is_list else []


def _block(value: object) -> list[str]:
    """Lists and mappings as lines in YAML's block style."""
    lines: list[str] = []
    if isinstance(value, list):
        for item in value:
            first, *rest = _block(item)
            lines += (f"- {first}", *(f"  {line}" for line in rest))
    elif isinstance(value, dict):
        for key, item in value.items():
            if item and isinstance(item, list | dict):
                lines += (f"{_scalar(key)}:", *(f"  {line}" for line in _block(item)))
            else:
                lines.append(f"{_scalar(key)}: {_scalar(item)}")
    else:
        lines.append(_scalar(value))
    return lines


def _scalar(value: object) -> str:
    if isinstance(value, str) and _PLAIN.fullmatch(value) and value.lower() not in _NO_TEXT:
        return value
    text = json.dumps(value, ensure_ascii=False, default=str)  # YAML knows no pairs of surrogates
    return _BREAKS.sub(lambda found: f"\\u{ord(found[0]):04x}", printable(text))


def printable(text: str) -> str:
    """A text that UTF-8 can hold: bytes of another encoding, as file names may have, become escapes."""
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")


def _indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.splitlines())


def as_texts(facts: Mapping[str, object]) -> dict[str, str]:
    """Facts as the texts that custom_data and MCAP metadata hold: texts as they are, anything else as JSON."""
    texts = {str(key): value if isinstance(value, str) else json.dumps(value) for key, value in facts.items()}
    return {printable(key): printable(value) for key, value in texts.items()}
