"""What a recorder says of its bag, in metadata.yaml and inside the files: the files, and facts about the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from tethernet_bringup.bags.contents import LARGEST_DESCRIPTION_BYTES
from tethernet_bringup.bags.metadata import METADATA_FILE, ROSBAG2_RECORD, SERIALIZED_METADATA

_ROSBAG2 = "rosbag2_bagfile_information"


@dataclass(frozen=True)
class BagInformation:
    """What is said of a bag; empty where nothing is, or nothing that can be read."""

    files: tuple[str, ...] = ()
    """Names of its files."""
    facts: Mapping[str, str] = field(default_factory=dict)
    """custom_data: facts about the run."""


def read_information(text: str) -> BagInformation:
    """What a text in the layout of metadata.yaml says; it may be damaged, or none at all."""
    if len(text) > LARGEST_DESCRIPTION_BYTES:
        return BagInformation()
    try:
        tree = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError):
        return BagInformation()
    information = tree.get(_ROSBAG2, tree) if isinstance(tree, dict) else {}
    if not isinstance(information, dict):
        return BagInformation()
    files, facts = information.get("relative_file_paths"), information.get("custom_data")
    return BagInformation(
        tuple(name for name in files if isinstance(name, str)) if isinstance(files, list) else (),
        # Nothing but single values: a list of lists of ... could be written out into gigabytes.
        {str(key): str(value) for key, value in facts.items() if _is_single(value)} if isinstance(facts, dict) else {},
    )


def information_in_folder(folder: Path) -> BagInformation:
    """What metadata.yaml says."""
    path = folder / METADATA_FILE
    try:
        with path.open("rb") as stream:
            content = stream.read(LARGEST_DESCRIPTION_BYTES + 1)
    except OSError:
        return BagInformation()
    return read_information(content.decode(errors="replace"))


def information_in_records(records: Mapping[str, Mapping[str, str]]) -> BagInformation:
    """What rosbag2 has written into an MCAP file.

    Args:
        records: its metadata records by name.
    """
    return read_information(records.get(ROSBAG2_RECORD, {}).get(SERIALIZED_METADATA, ""))


def _is_single(value: Any) -> bool:
    return isinstance(value, str | int | float | bool)
