"""What the recorder left: messages by topic."""

from __future__ import annotations

from pathlib import Path

import yaml


def count_messages(bag: Path) -> dict[str, int]:
    """Messages in a bag by topic, as its metadata.yaml tells; empty where there is no bag.

    Args:
        bag: folder in the layout of rosbag2.
    """
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        content = yaml.load((bag / "metadata.yaml").read_text(encoding="utf-8"), loader)
        topics = content["rosbag2_bagfile_information"]["topics_with_message_count"]
        return {topic["topic_metadata"]["name"]: int(topic["message_count"]) for topic in topics}
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError):
        return {}
