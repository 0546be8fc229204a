"""What rosbag2 wants to know about a bag: metadata.yaml and the quality of service of each topic, as Jazzy writes them.

The text is put together by hand, because a provisional metadata.yaml is written twice a second beside a flying
mission: a YAML library takes 100 times as long. All strings are JSON strings, which are YAML strings too.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

VERSION = 9
"""Version of the layout: that of ROS 2 Jazzy."""

DISTRIBUTION = "jazzy"

DEFAULT_DEPTH = 10

# RMW_DURATION_INFINITE, in the words of rosbag2
_FOREVER = "sec: 9223372036, nsec: 854775807"


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
    durability = "transient_local" if latched else "volatile"
    return (
        f"[{{history: keep_last, depth: {depth}, reliability: reliable, durability: {durability}, "
        f"deadline: {{{_FOREVER}}}, lifespan: {{{_FOREVER}}}, liveliness: automatic, "
        f"liveliness_lease_duration: {{{_FOREVER}}}, avoid_ros_namespace_conventions: false}}]"
    )


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


def _information(topics, counts, file_name, start_ns, end_ns, custom_data) -> str:
    total, duration, name = sum(counts), end_ns - start_ns, _text(file_name)
    span = f"starting_time: {{nanoseconds_since_epoch: {start_ns}}}"
    lines = [
        f"version: {VERSION}",
        "storage_identifier: mcap",
        f"duration: {{nanoseconds: {duration}}}",
        span,
        f"message_count: {total}",
        "topics_with_message_count:" if topics else "topics_with_message_count: []",
    ]
    for topic, count in zip(topics, counts, strict=True):
        lines += (
            "  - topic_metadata:",
            f"      name: {_text(topic.name)}",
            f"      type: {_text(topic.message_type.name)}",
            "      serialization_format: cdr",
            f"      offered_qos_profiles: {topic.qos or '[]'}",
            f"      type_description_hash: {_text(topic.message_type.type_hash)}",
            f"    message_count: {count}",
        )
    lines += (
        'compression_format: ""',
        'compression_mode: ""',
        f"relative_file_paths: [{name}]",
        "files:",
        f"  - path: {name}",
        f"    {span}",
        f"    duration: {{nanoseconds: {duration}}}",
        f"    message_count: {total}",
        f"custom_data: {_text(dict(custom_data)) if custom_data else '~'}",
        f"ros_distro: {DISTRIBUTION}",
    )
    return "\n".join(lines) + "\n"


def _text(value: str | dict[str, str]) -> str:
    return json.dumps(value, ensure_ascii=False)  # YAML knows no pairs of surrogates


def _indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.splitlines())


def as_texts(facts: Mapping[str, object]) -> dict[str, str]:
    """Facts as the texts that custom_data and MCAP metadata hold: texts as they are, anything else as JSON."""
    return {str(key): value if isinstance(value, str) else json.dumps(value) for key, value in facts.items()}
