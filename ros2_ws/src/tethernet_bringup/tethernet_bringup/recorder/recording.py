"""What the recorder left: messages by topic, and what it says of itself."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

from tethernet_bringup.bags.errors import BagError
from tethernet_bringup.bags.file_bytes import FileBytes
from tethernet_bringup.bags.metadata import METADATA_FILE
from tethernet_bringup.pulse import Answer

REPORT_FILE = "recorder.json"
_LONGEST_METADATA_BYTES = 1 << 22  # ours has 40 kB; whatever lies in its place may have any size
RECORDING, COMPLETE, FAULTY = "recording", "complete", "fault"
"""States of the recorder's report."""


def count_messages(bag: Path) -> dict[str, int]:
    """Messages in a bag by topic, as its metadata.yaml tells; empty where there is no bag.

    Args:
        bag: folder in the layout of rosbag2.
    """
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        path = bag / METADATA_FILE
        if path.stat().st_size > _LONGEST_METADATA_BYTES:
            return {}
        content = yaml.load(path.read_text(encoding="utf-8"), loader)
        topics = content["rosbag2_bagfile_information"]["topics_with_message_count"]
        return {topic["topic_metadata"]["name"]: int(topic["message_count"]) for topic in topics}
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError):
        return {}


def recorded_messages(run: Path, bag: Path) -> dict[str, int]:
    """Messages in a bag by topic, also of one that was not closed: its metadata.yaml has no counts, those of the
    recorder's last sign of life are given.

    Args:
        run: the run's folder.
        bag: folder of the bag, in the layout of rosbag2.
    """
    report = _report(run) or {}
    counts = report.get("messages")
    is_open = report.get("state") == RECORDING and isinstance(counts, dict)
    return counts if is_open and counts else count_messages(bag)


def faults(run: Path, bag: Path) -> list[str]:
    """Why a recording that should be whole is not; empty for a whole one.

    The file is compared with what the recorder says that it wrote, to the last bit: it may have been deleted, replaced
    or cut while the mission flew.

    Args:
        run: the run's folder.
        bag: folder of the bag, in the layout of rosbag2.
    """
    report = _report(run)
    if report is None:
        return [f"the recorder left no report {run / REPORT_FILE}: the recording may be incomplete"]
    state = report.get("state")
    if state == RECORDING:
        return ["the recorder ended without closing the bag: the recording is incomplete"]
    if state != COMPLETE:
        return [f"the recording is not complete: {report.get('fault') or state}"]
    if not report.get("message_count"):
        return [f"nothing was recorded under {bag}"]
    changed = _change(bag / f"{bag.name}_0.mcap", report.get("bytes"), report.get("crc32"))
    if changed:
        return [f"the bag was changed while it was recorded, or since: {changed}"]
    if count_messages(bag) != report.get("messages"):
        return [f"{bag / METADATA_FILE} is gone or was changed while the bag was recorded, or since"]
    return []


def problems(run: Path) -> list[str]:
    """What the recorder's own report finds wanting in a whole recording.

    Args:
        run: the run's folder.
    """
    report = _report(run) or {}
    lost = {topic: count for topic, count in report.get("never_arrived", {}).items() if count}
    if not lost:
        return []
    listed = ", ".join(f"{topic} ({count})" for topic, count in sorted(lost.items()))
    return [f"messages that were sent but not recorded: {listed}"]


def sign_of_life(run: Path) -> Callable[[], Answer]:
    """A question to the recorder for :class:`~tethernet_bringup.pulse.Pulse`: whether it renews its report.

    Args:
        run: the run's folder.
    """
    path = run / REPORT_FILE

    def written() -> tuple[int, int] | None:
        try:
            status = path.stat()
        except OSError:
            return None
        return status.st_mtime_ns, status.st_ino

    def ask() -> Answer:
        before = written()
        return lambda: True if written() not in (None, before) else None

    return ask


def _report(run: Path) -> dict[str, Any] | None:
    try:
        report = json.loads((run / REPORT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return report if isinstance(report, dict) else None


def _change(path: Path, size: int | None, checksum: int | None) -> str:
    try:
        with path.open("rb") as stream:
            file = FileBytes(stream)
            if file.size != size:
                return f"{path} has {file.size} bytes, the recorder wrote {size}"
            if file.checksum(0, file.size) != checksum:
                return f"the content of {path} is not what the recorder wrote"
    except FileNotFoundError:
        return f"{path} is gone"
    except OSError as error:
        return f"{path} cannot be read: {error.strerror or error}"
    except BagError as error:
        return str(error)
    return ""
