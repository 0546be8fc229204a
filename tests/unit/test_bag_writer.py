"""Bags: what rosbag2, rosbags and mcap expect, and what is left of them when a disk is full or a process dies."""

import errno
import math
import os

import pytest
import yaml
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from tests import toy_mission
from tests.toy_mission import START_NS
from tethernet_bringup.bags import mcap_writer
from tethernet_bringup.bags import writer as bag_writer
from tethernet_bringup.bags.errors import BagWriteError
from tethernet_bringup.bags.message_definitions import UnknownTypeError, installed_type
from tethernet_bringup.bags.metadata import BagTopic, as_texts, qos_profiles
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.writer import BagWriter
from tethernet_bringup.recorder.recorded_topics import mission_topics

SHORT_S = 1.0


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return toy_mission.write_bag(tmp_path_factory.mktemp("run") / "bag", end_s=SHORT_S, flush_every_s=0.3)


@pytest.fixture(scope="module")
def information(bag):
    return yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]


def recorded(end_s=SHORT_S):
    names = [topic.name for topic in mission_topics(8)]
    return sorted((names[index], stamp, data) for index, stamp, data in toy_mission.serialized(8, end_s))


def text_topic(name="/text"):
    return BagTopic(name, installed_type("std_msgs/msg/String").message_type, qos_profiles(latched=False))


class FullDisk:
    """Lets writes through until so many bytes are on the disk."""

    def __init__(self, monkeypatch, room):
        self.room = room
        self.real = os.write
        monkeypatch.setattr(mcap_writer.os, "write", self)

    def __call__(self, handle, data):
        fits = min(len(data), self.room)
        if fits == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.room -= fits
        return self.real(handle, bytes(data)[:fits])


def test_rosbags_reads_every_message_and_type(bag):
    with AnyReader([bag]) as reader:
        read = sorted((c.topic, time, bytes(data)) for c, time, data in reader.messages())
        assert read == recorded()
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
        assert {c.topic for c in reader.connections} == {topic.name for topic in mission_topics(8)}


def test_mcap_reads_every_message_in_time_order(bag):
    with (bag / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        read = [(channel.topic, message.log_time, message.data) for _, channel, message in reader.iter_messages()]
        summary = reader.get_summary()
    assert sorted(read) == recorded()
    times = [time for _, time, _ in read]
    assert times == sorted(times)
    assert summary.statistics.message_count == len(read)
    assert summary.statistics.message_start_time == START_NS
    assert summary.statistics.message_end_time == START_NS + round(SHORT_S * 1e9)
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 2
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert all(set(c.metadata) == {"offered_qos_profiles", "topic_type_hash"} for c in summary.channels.values())


def test_time_range_queries_use_the_index(bag):
    begin, end = START_NS + 300_000_000, START_NS + 500_000_000
    with (bag / "bag_0.mcap").open("rb") as stream:
        found = list(make_reader(stream).iter_messages(topics=["/mu3/odom"], starting_at=begin, ending_before=end))
    assert [message.log_time - begin for _, _, message in found] == [0, 50_000_000, 100_000_000, 150_000_000]


def test_every_checksum_fits(bag):
    with (bag / "bag_0.mcap").open("rb") as stream:
        assert sum(1 for _ in StreamReader(stream, validate_crcs=True).records) > len(recorded())


def test_metadata_is_what_jazzy_writes(information):
    assert set(information) == {
        "version", "storage_identifier", "duration", "starting_time", "message_count", "topics_with_message_count",
        "compression_format", "compression_mode", "relative_file_paths", "files", "custom_data", "ros_distro",
    }  # fmt: skip
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["relative_file_paths"] == ["bag_0.mcap"]
    assert information["duration"] == {"nanoseconds": round(SHORT_S * 1e9)}
    assert information["starting_time"] == {"nanoseconds_since_epoch": START_NS}
    assert information["message_count"] == len(recorded())
    assert information["files"] == [
        {
            "path": "bag_0.mcap",
            "starting_time": {"nanoseconds_since_epoch": START_NS},
            "duration": {"nanoseconds": round(SHORT_S * 1e9)},
            "message_count": len(recorded()),
        }
    ]
    assert information["custom_data"] == toy_mission.RUN_INFO
    assert information["ros_distro"] == "jazzy"


def test_metadata_tells_each_topic(information):
    topics = {entry["topic_metadata"]["name"]: entry for entry in information["topics_with_message_count"]}
    assert len(topics) == len(mission_topics(8)) == 12 + 3 * 8
    thrust = topics["/mu3/thrust"]
    assert thrust["message_count"] == 21
    assert thrust["topic_metadata"]["type"] == "geometry_msgs/msg/WrenchStamped"
    assert thrust["topic_metadata"]["serialization_format"] == "cdr"
    (profile,) = thrust["topic_metadata"]["offered_qos_profiles"]
    assert profile["reliability"] == "reliable"
    assert profile["durability"] == "volatile"
    (latched,) = topics["/mission/state"]["topic_metadata"]["offered_qos_profiles"]
    assert latched["durability"] == "transient_local"
    assert topics["/net/markers"]["message_count"] == 0


def test_type_hashes_equal_those_computed_from_the_definitions(bag, information):
    """rosbags computes RIHS01 from the definitions in the bag; the recorder takes it from the installed packages."""
    with Reader(bag) as reader, AnyReader([bag]) as any_reader:
        assert reader.connections
        for entry in information["topics_with_message_count"]:
            topic = entry["topic_metadata"]
            assert topic["type_description_hash"] == any_reader.typestore.hash_rihs01(topic["type"]), topic["type"]
            assert topic["type_description_hash"].startswith("RIHS01_")


def test_rosbag2_finds_its_metadata_inside_the_file_too(bag, information):
    with (bag / "bag_0.mcap").open("rb") as stream:
        records = {record.name: record.metadata for record in make_reader(stream).iter_metadata()}
    assert records["tethernet"] == toy_mission.RUN_INFO
    inside = yaml.safe_load(records["rosbag2"]["serialized_metadata"])
    assert inside == information


def test_definitions_hold_the_nested_types():
    definition = installed_type("nav_msgs/msg/Odometry").message_type.definition
    assert definition.count("=" * 80 + "\nMSG: ") == 9
    assert "MSG: geometry_msgs/PoseWithCovariance\n" in definition


@pytest.mark.parametrize("name", ["Odometry", "nav_msgs/Odometry", "nav_msgs/msg/Nothing", "no_msgs/msg/Odometry", ""])
def test_unknown_types_are_named(name):
    with pytest.raises(UnknownTypeError, match="message type"):
        installed_type(name)


def test_metadata_is_in_block_style(bag):
    """Some tools read metadata.yaml line by line, as rosbag2 writes it."""
    lines = (bag / "metadata.yaml").read_text().splitlines()
    for line in (
        "  starting_time:",
        f"    nanoseconds_since_epoch: {START_NS}",
        "  - topic_metadata:",
        "      name: /clock",
        "      type: rosgraph_msgs/msg/Clock",
        "      offered_qos_profiles:",
        "      - history: keep_last",
        "        deadline:",
        "          sec: 9223372036",
        "  relative_file_paths:",
        "  - bag_0.mcap",
    ):
        assert line in lines
    assert not any(set("[{") & set(line.partition('"')[0]) for line in lines)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("", []),
        ("[{history: 3, depth: 0}]", [{"history": 3, "depth": 0}]),
        ("- history: 3\n  depth: 0\n", [{"history": 3, "depth": 0}]),
        ("}{", []),
        ("a: &a [1]\nb: *a", []),
        ("- 1", []),
        ("- a: [[1]]", []),
        ("- history: 0x" + "f" * 9000, []),
        ("- depth: .nan", [{"depth": pytest.approx(math.nan, nan_ok=True)}]),
        ("- a: 2026-01-01", []),
    ],
)
def test_profiles_of_other_recorders_cannot_break_it(tmp_path, given, expected):
    kind = installed_type("std_msgs/msg/String").message_type
    BagWriter(tmp_path / "bag", [BagTopic("/text", kind, given)], run_info={}).close()
    content = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert content["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"] == expected


def test_names_in_another_encoding_are_shown(tmp_path):
    """A folder's name may hold bytes that are no UTF-8."""
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    BagWriter(folder, [text_topic()], run_info=as_texts({"output": str(folder)})).close()
    content = yaml.safe_load((folder / "metadata.yaml").read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
    assert content["custom_data"]["output"].endswith(r"caf\xe9")


def test_odd_texts_survive(tmp_path):
    breaks = "a\x85b\u2028c\u2029d\x7fe"
    odd = {"breaks": breaks, "quote": 'a "b": {c}\n\t- d', "letters": "äß漢😀"}
    facts = as_texts({**odd, "number": 1.5, "list": [1, None]})
    writer = BagWriter(tmp_path / "bag", [text_topic()], run_info=facts)
    writer.close()
    content = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text(encoding="utf-8"))
    assert content["rosbag2_bagfile_information"]["custom_data"] == facts
    assert facts["number"] == "1.5"
    lines = (tmp_path / "bag" / "metadata.yaml").read_text(encoding="utf-8").splitlines()
    assert sum(line.startswith("    ") and ": " in line for line in lines[lines.index("  custom_data:") + 1 :]) == 5


def test_flushed_messages_are_there_before_the_bag_is_closed(tmp_path):
    def information():
        return yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]

    writer = BagWriter(tmp_path / "bag", [text_topic()], run_info={"seed": "1"})
    assert information()["version"] == 9
    for number in range(10):
        writer.write(0, number, number, number, b"x" * 20)
    writer.flush()
    writer.write(0, 11, 11, 11, b"not flushed")
    bag = open_bag(tmp_path)
    assert [message.sequence for message in bag.messages()] == list(range(10))
    assert bag.metadata["tethernet"] == {"seed": "1"}
    assert len(bag.problems) == 1
    (topic,) = information()["topics_with_message_count"]
    assert topic["topic_metadata"]["name"] == "/text"
    assert information()["custom_data"] == {"seed": "1"}
    writer.close()
    assert information()["message_count"] == 11


def test_memory_is_bounded_by_the_chunk(tmp_path):
    writer = BagWriter(tmp_path / "bag", [text_topic()], run_info={}, chunk_bytes=1000)
    for number in range(100):
        writer.write(0, number, number, number, b"x" * 100)
        assert writer.pending_count <= 10
    writer.close()
    assert writer.counts == [100]


def test_empty_messages_take_memory_too(tmp_path):
    writer = BagWriter(tmp_path / "bag", [text_topic()], run_info={}, chunk_bytes=1000)
    for number in range(1000):
        writer.write(0, number, number, number, b"")
        assert writer.pending_count <= 1000 // 31
    writer.close()


def test_times_out_of_order_are_sorted_within_a_chunk(tmp_path):
    writer = BagWriter(tmp_path / "bag", [text_topic("/a"), text_topic("/b")], run_info={})
    for topic, time in ((1, 5), (0, 7), (0, 5), (1, 3)):
        writer.write(topic, time, time, 0, b"....")
    writer.close()
    assert [(m.topic, m.log_time) for m in open_bag(tmp_path).messages()] == [
        ("/b", 3),
        ("/a", 5),
        ("/b", 5),
        ("/a", 7),
    ]
    assert writer.span_ns == (3, 7)


def test_a_bag_without_messages_is_whole(tmp_path):
    BagWriter(tmp_path / "bag", [text_topic()], run_info={}).close()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        assert make_reader(stream).get_summary().statistics.message_count == 0
    bag = open_bag(tmp_path)
    assert list(bag.messages()) == []
    assert bag.problems == []


def test_nothing_is_written_over(tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "notes.txt").write_text("mine")
    with pytest.raises(BagWriteError, match=r"not empty \(it holds notes.txt\).*give another folder"):
        BagWriter(tmp_path / "bag", [text_topic()], run_info={})
    assert [path.name for path in (tmp_path / "bag").iterdir()] == ["notes.txt"]


def test_a_file_in_the_folders_place_is_told(tmp_path):
    (tmp_path / "bag").write_text("a file")
    with pytest.raises(BagWriteError, match="cannot make the bag's folder"):
        BagWriter(tmp_path / "bag", [text_topic()], run_info={})


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_folder_is_told(tmp_path):
    tmp_path.chmod(0o555)
    with pytest.raises(BagWriteError, match="Permission denied"):
        BagWriter(tmp_path / "bag", [text_topic()], run_info={})


@pytest.mark.parametrize("room", [5_000, 50_000, 61_234])
def test_a_full_disk_costs_nothing_that_was_recorded(tmp_path, monkeypatch, room):
    """The reserve gives room for what memory holds, the index and metadata.yaml: the bag is a whole one."""
    writer = BagWriter(tmp_path / "bag", [text_topic()], run_info={}, chunk_bytes=4_000)
    disk = FullDisk(monkeypatch, room)
    taken = 0
    with pytest.raises(BagWriteError, match="No space left on device"):
        while True:
            taken += 1
            writer.write(0, taken, taken, taken, os.urandom(500))
    release = writer._release

    def make_room():
        release()
        disk.room = 1 << 30

    monkeypatch.setattr(writer, "_release", make_room)
    writer.close()
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == taken


def test_a_disk_that_stays_full_leaves_whole_records(tmp_path, monkeypatch):
    writer = BagWriter(tmp_path / "bag", [text_topic()], run_info={}, chunk_bytes=4_000)
    FullDisk(monkeypatch, 30_000)
    with pytest.raises(BagWriteError):
        for number in range(1000):
            writer.write(0, number, number, number, os.urandom(500))
    with pytest.raises(BagWriteError):
        writer.close()
    bag = open_bag(tmp_path)
    kept = [message.sequence for message in bag.messages()]
    assert kept == list(range(len(kept)))
    assert kept == list(range(sum(writer.counts)))
    assert writer.pending_count > 0
    assert len(bag.problems) == 1


def test_no_room_at_the_start_is_told(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(bag_writer.os, "posix_fallocate", full)
    with pytest.raises(BagWriteError, match=r"no room for a bag .* No space left on device"):
        BagWriter(tmp_path / "bag", [text_topic()], run_info={})
