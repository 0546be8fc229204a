"""``ros2 bag info`` of the environment of wheels: the stock command's words, read by rosbags."""

from __future__ import annotations

import importlib.util
import re

import pytest
from rosbags.rosbag2 import Writer
from rosbags.rosbag2.enums import StoragePlugin
from rosbags.typesys import Stores, get_typestore

from bootstrap.places import venv_places

FILE = venv_places().ros2cli / "ros2cli_wheels" / "bag_information.py"
spec = importlib.util.spec_from_file_location("bag_information", FILE)
bag_information = importlib.util.module_from_spec(spec)
spec.loader.exec_module(bag_information)

START_NS = 1_700_000_000_250_000_000


@pytest.fixture(params=[StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def bag(request, tmp_path):
    """Three texts a second apart and a topic on which nothing came."""
    store = get_typestore(Stores.ROS2_JAZZY)
    text = store.types["std_msgs/msg/String"]
    with Writer(tmp_path / "bag", version=9, storage_plugin=request.param) as writer:
        said = writer.add_connection("/said", text.__msgtype__, typestore=store)
        writer.add_connection("/a/silent", text.__msgtype__, typestore=store)
        for second in range(3):
            message = store.serialize_cdr(text(data="hello"), text.__msgtype__)
            writer.write(said, START_NS + second * 1_000_000_000, message)
    return tmp_path / "bag"


def test_it_says_what_the_stock_command_says(bag):
    lines = bag_information.describe(bag).splitlines()
    labels = [line[:19].rstrip() for line in lines]
    assert labels == [
        "Files:", "Bag size:", "Storage id:", "ROS Distro:", "Duration:", "Start:", "End:", "Messages:",
        "Topic information:", "",
    ]  # fmt: skip
    said = {label: line[19:] for label, line in zip(labels[:-1], lines, strict=False)}
    file = next(path for path in bag.iterdir() if path.suffix in (".mcap", ".db3"))
    assert said["Files:"] == file.name
    assert re.fullmatch(r"\d+\.\d (B|KiB)", said["Bag size:"])
    assert said["Storage id:"] == {".mcap": "mcap", ".db3": "sqlite3"}[file.suffix]
    assert said["Duration:"] == "2.000000000s"
    assert said["Start:"].endswith("(1700000000.250000000)") and "2023" in said["Start:"]
    assert said["End:"].endswith("(1700000002.250000000)")
    assert said["Messages:"] == "3"
    topic = "Topic: {} | Type: std_msgs/msg/String | Count: {} | Serialization Format: cdr"
    assert said["Topic information:"] == topic.format("/a/silent", 0)
    assert lines[-1].strip() == topic.format("/said", 3)


def test_one_file_of_a_bag_is_read_too(bag):
    if file := next(iter(bag.glob("*.mcap")), None):
        assert "Messages:          3" in bag_information.describe(file)


def test_what_is_no_bag_is_named(tmp_path):
    with pytest.raises((OSError, bag_information.UnreadableBagError)):
        bag_information.describe(tmp_path / "nothing")
    (tmp_path / "torn").mkdir()
    (tmp_path / "torn" / "metadata.yaml").write_text("rosbag2_bagfile_information: {version: 9}")
    with pytest.raises(bag_information.UnreadableBagError):
        bag_information.describe(tmp_path / "torn")
