"""What the recorder left: messages by topic, and what it says of itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import yaml

REPORT_FILE = "recorder.json"


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


def complaints(run: Path) -> list[str]:
    """What the recorder's own report finds wanting in a recording that should be whole.

    Args:
        run: the run's folder.
    """
    try:
        report: dict[str, Any] = json.loads((run / REPORT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return ["the recorder left no report: the recording may be incomplete"]
    found = []
    if report.get("state") != "complete":
        found.append(f"the recording is not complete: {report.get('fault') or report.get('state')}")
    lost = {topic: count for topic, count in report.get("never_arrived", {}).items() if count}
    if lost:
        listed = ", ".join(f"{topic} ({count})" for topic, count in sorted(lost.items()))
        found.append(f"messages that were sent but not recorded: {listed}")
    return found
