"""Bags by others, split, compressed, SQLite, of wall-clock times: the same analysis, or what is missing is named."""

import json
import random
import sqlite3

import numpy as np
import pytest
from mcap.writer import CompressionType
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from tests import foreign_bags, toy_mission
from tethernet_bringup.analysis import pictures, snapshots
from tethernet_bringup.analysis.command_line import main as analyse
from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.analysis.mission_clock import MissionClock, mission_clock
from tethernet_bringup.analysis.mission_data import load
from tethernet_bringup.bags import message_definitions
from tethernet_bringup.bags.contents import LARGEST_RECORD_BYTES
from tethernet_bringup.bags.errors import NotABagError
from tethernet_bringup.bags.message_definitions import UnknownTypeError
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.salvage import salvage
from tethernet_bringup.recorder.recorded_topics import mission_topics

SECOND_NS = 1_000_000_000
NO_FACTS = "no facts about the run (policy, seed, parameters): the system is taken to be zenit_8mu"
SQLITE, MCAP = StoragePlugin.SQLITE3, StoragePlugin.MCAP


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    return toy_mission.write_bag(tmp_path_factory.mktemp("run") / "bag")


@pytest.fixture(scope="module")
def expected(original, tmp_path_factory):
    return table_of(original, tmp_path_factory.mktemp("table"))


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    return toy_mission.write_bag(tmp_path_factory.mktemp("short") / "bag", end_s=3.0)


def table_of(bag, folder):
    """The table as JSON, but for the bag's name and for losses, of which other recorders keep no count."""
    assert analyse([str(bag), "--no-plots", "--json", "--output", str(folder)]) == 0
    table = json.loads((folder / "analysis.json").read_text())
    del table["bag"], table["never_arrived"]
    for topic in table["topics"].values():
        del topic["never_arrived"]
    return table


MAKERS = {
    "sqlite": foreign_bags.by_rosbags,
    "sqlite, compressed messages": lambda bag, out: foreign_bags.by_rosbags(bag, out, SQLITE, CompressionMode.MESSAGE),
    "sqlite, wall clock": lambda bag, out: foreign_bags.by_rosbags(bag, out, log_time=foreign_bags.wall_clock),
    "mcap, compressed messages": lambda bag, out: foreign_bags.by_rosbags(bag, out, MCAP, CompressionMode.MESSAGE),
    "mcap, compressed file, wall clock": lambda bag, out: foreign_bags.by_rosbags(
        bag, out, MCAP, CompressionMode.FILE, log_time=foreign_bags.wall_clock
    ),
    "mcap, chunks by the storage": lambda bag, out: foreign_bags.by_rosbags(bag, out, MCAP, CompressionMode.STORAGE),
}


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_a_bag_by_rosbags_gives_the_same_table(original, expected, tmp_path, make):
    assert table_of(make(original, tmp_path / "other"), tmp_path) == expected


NONE, LZ4 = CompressionType.NONE, CompressionType.LZ4
STOCK = {
    "one file, chunks by lz4": ("", {"compression": LZ4}),
    "one file, compressed by lz4": (".lz4", {"compression": NONE}),
    "split": ("", {"parts": 4}),
    "split, compressed files": (".zstd", {"parts": 3, "compression": NONE}),
    "split, compressed messages": ("", {"parts": 3, "compression": NONE, "each": foreign_bags.zstd_frame}),
}


@pytest.mark.parametrize(("suffix", "options"), STOCK.values(), ids=STOCK)
def test_a_bag_of_the_stock_recorder_lacks_the_facts_and_nothing_else(original, expected, tmp_path, suffix, options):
    bag = foreign_bags.by_stock_recorder(original, tmp_path / "stock", **options)
    if suffix:
        foreign_bags.compress_files(bag, suffix)
    table = table_of(bag, tmp_path)
    assert table["problems"] == [NO_FACTS]
    without = {"problems", "policy", "seed", "pace", "commit"}
    assert {key: table[key] for key in table if key not in without} == {
        key: expected[key] for key in expected if key not in without
    }


def test_losses_are_not_counted_where_no_counters_are(short, tmp_path, capsys):
    assert analyse([str(short), "--no-plots"]) == 0
    assert "none lost on the way" in capsys.readouterr().out
    analyse([str(foreign_bags.by_stock_recorder(short, tmp_path / "stock")), "--no-plots"])
    assert "what was lost on the way is not counted" in capsys.readouterr().out


def test_the_scenes_of_a_compressed_split_bag_are_those_of_the_original(original, tmp_path):
    other = foreign_bags.compress_files(foreign_bags.by_stock_recorder(original, tmp_path / "other", parts=3), ".zstd")
    shots = [snapshots.take(load(open_bag(bag)), open_bag(bag)) for bag in (original, other)]
    assert [shot.title for shot in shots[0]] == ["early deployment", "trigger", "end"]
    for mine, theirs in zip(*shots, strict=True):
        assert (mine.title, mine.time_s, mine.stamp_ns) == (theirs.title, theirs.time_s, theirs.stamp_ns)
        for name in ("knots", "locked", "debris", "chaser"):
            assert np.array_equal(getattr(mine, name), getattr(theirs, name)), name
        assert all(np.array_equal(mine.trails[mu], theirs.trails[mu]) for mu in mine.trails)


@pytest.mark.parametrize(
    "make",
    [
        lambda bag, out: foreign_bags.by_rosbags(bag, out, SQLITE, CompressionMode.FILE),
        lambda bag, out: foreign_bags.by_stock_recorder(bag, out, parts=3, each=foreign_bags.zstd_frame),
        lambda bag, out: foreign_bags.compress_files(foreign_bags.by_stock_recorder(bag, out, parts=2), ".lz4"),
    ],
)
def test_salvage_makes_one_plain_bag_of_it(short, tmp_path, make):
    result = salvage(make(short, tmp_path / "other"))
    assert result.folder == tmp_path / "other_salvaged"
    assert result.problems == ()
    assert sorted(foreign_bags.content(result.folder)) == sorted(foreign_bags.content(short))
    assert [path.name for path in result.folder.glob("*.mcap")] == ["other_salvaged_0.mcap"]


@pytest.mark.parametrize(("suffix", "keep"), [(".zstd", 0.6), (".lz4", 0.3)])
def test_of_a_compressed_file_that_was_cut_off_the_beginning_is_shown(original, tmp_path, suffix, keep):
    bag = foreign_bags.compress_files(
        foreign_bags.by_stock_recorder(original, tmp_path / "stock", compression=CompressionType.NONE), suffix
    )
    [path] = bag.iterdir()
    content = path.read_bytes()
    path.write_bytes(content[: int(keep * len(content))])
    table = table_of(bag, tmp_path)
    assert any(f"{path.name}: what follows is left out, it is cut off" in problem for problem in table["problems"])
    assert 0.5 * keep * 19_000 < table["messages"] < 19_000


def test_files_of_several_frames_are_read_to_their_end(short, tmp_path):
    bag = foreign_bags.copy(short, tmp_path / "bag")
    path = bag / "bag_0.mcap"
    path.with_name("bag_0.mcap.zst").write_bytes(foreign_bags.several_frames(path.read_bytes()))
    path.unlink()
    reader = open_bag(bag)
    assert sum(1 for _ in reader.messages()) == sum(1 for _ in open_bag(short).messages())
    assert reader.problems == []
    assert reader.verified


def test_a_part_that_was_being_compressed_is_taken_from_the_plain_file(short, tmp_path):
    bag = foreign_bags.by_stock_recorder(short, tmp_path / "stock", parts=3)
    foreign_bags.compress_files(bag, ".zstd")
    last = bag / "stock_2.mcap.zstd"
    plain = foreign_bags.by_stock_recorder(short, tmp_path / "again" / "stock", parts=3) / "stock_2.mcap"
    plain.rename(bag / "stock_2.mcap")
    last.write_bytes(last.read_bytes()[:100])
    reader = open_bag(bag)
    assert [path.name for path in reader.files] == ["stock_0.mcap.zstd", "stock_1.mcap.zstd", "stock_2.mcap"]
    assert sum(1 for _ in reader.messages()) == sum(1 for _ in open_bag(short).messages())


def test_a_missing_part_is_named(short, tmp_path):
    bag = foreign_bags.by_stock_recorder(short, tmp_path / "stock", parts=4)
    (bag / "stock_1.mcap").unlink()
    assert "the bag is damaged: part 1 of the bag is missing" in table_of(bag, tmp_path)["problems"][0]
    names = "".join(f"  - stock_{part}.mcap\n" for part in range(4))
    (bag / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  relative_file_paths:\n{names}")
    (bag / "stock_3.mcap").unlink()
    problems = table_of(bag, tmp_path)["problems"]
    for number in (1, 3):
        assert f"the bag is damaged: stock_{number}.mcap is missing, metadata.yaml names it" in problems


@pytest.mark.parametrize("order", ["by topic", "backwards"])
def test_the_order_of_messages_in_the_file_does_not_matter_to_times(original, expected, tmp_path, order):
    """As a script may write them: topic after topic."""
    bag = foreign_bags.by_rosbags(original, tmp_path / "bag", log_time=foreign_bags.wall_clock)
    connection = sqlite3.connect(next(bag.glob("*.db3")))
    ordering = "topic_id, id" if order == "by topic" else "topic_id DESC, id"
    connection.execute(f"CREATE TABLE other AS SELECT * FROM messages ORDER BY {ordering}")
    connection.execute("DROP TABLE messages")
    connection.execute(
        "CREATE TABLE messages AS SELECT rowid AS id, topic_id, timestamp, data FROM other ORDER BY rowid"
    )
    connection.commit()
    connection.close()
    assert table_of(bag, tmp_path) == expected


def test_facts_that_only_metadata_yaml_has_are_found(short, tmp_path):
    bag = foreign_bags.by_stock_recorder(short, tmp_path / "stock")
    (bag / "metadata.yaml").write_text((short / "metadata.yaml").read_text())
    table = table_of(bag, tmp_path)
    assert (table["policy"], table["seed"], table["problems"]) == ("nominal", "7", [])


def test_definitions_that_a_bag_lacks_are_those_of_rosbags_where_ros_is_not_installed(short, tmp_path, monkeypatch):
    bag = foreign_bags.by_rosbags(short, tmp_path / "bag")
    connection = sqlite3.connect(next(bag.glob("*.db3")))
    connection.execute("DROP TABLE message_definitions")
    connection.commit()
    connection.close()

    def nothing(name):
        raise UnknownTypeError(name)

    monkeypatch.setattr(message_definitions, "installed_type", nothing)
    message_definitions.known_type.cache_clear()
    try:
        data = load(open_bag(bag))
    finally:
        message_definitions.known_type.cache_clear()
    assert len(data.mus[3].measured) == len(data.debris) - 1 == 61
    left_out = "the messages of /net/state were left out, type tethernet_msgs/msg/NetState is neither in it nor"
    assert any(left_out in problem for problem in data.problems)


def test_a_bag_of_ros_1_is_named(tmp_path, capsys):
    path = tmp_path / "old.bag"
    path.write_bytes(b"#ROSBAG V2.0\n" + bytes(1000))
    assert analyse([str(path), "--no-plots"]) == 1
    assert f"is a bag of ROS 1; convert it first: rosbags-convert --src {path}" in capsys.readouterr().err


def test_a_file_that_inflates_without_end_is_given_up(tmp_path):
    path = tmp_path / "bag_0.mcap.zstd"
    path.write_bytes(foreign_bags.zstd_frame(bytes(2 * LARGEST_RECORD_BYTES)))
    reader = open_bag(tmp_path)
    with pytest.raises(NotABagError):
        list(reader.messages())
    assert "the file inflates to more than 250 times its size" in reader.problems[0]


# --- topics one by one


def consequences(topic):
    """Words that must be said where a topic is missing."""
    kinds = {"odom": "no path", "thrust": "no thrust", "status": "no tracking error and no fuel"}
    if topic.startswith("/mu"):
        _, mu, what = topic.split("/")
        return f"no /muN/{what} of MU {mu.removeprefix('mu')}: {kinds[what]}"
    return {
        "/mission/state": "no /mission/state: no phases, times count from the first message",
        "/net/state": "no /net/state: the net is not drawn",
        "/debris/odom": "no /debris/odom: the debris is not drawn",
        "/chaser/odom": "no /chaser/odom: the chaser is not drawn",
        "/capture/assessment": "no /capture/assessment: no capture quality and no verdict",
    }.get(topic, f"no {topic}: nothing here needs it")


TOPICS = [topic.name for topic in mission_topics(8)]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """A short mission, its trigger in it, as SQLite: topics can be deleted."""
    whole = toy_mission.write_bag(tmp_path_factory.mktemp("whole") / "bag", end_s=26.0, without=())
    return foreign_bags.by_rosbags(whole, tmp_path_factory.mktemp("rows") / "bag", log_time=foreign_bags.wall_clock)


def without(rows, folder, topics):
    bag = foreign_bags.copy(rows, folder)
    connection = sqlite3.connect(next(bag.glob("*.db3")))
    for topic in topics:
        connection.execute("DELETE FROM messages WHERE topic_id = (SELECT id FROM topics WHERE name = ?)", (topic,))
        connection.execute("DELETE FROM topics WHERE name = ?", (topic,))
    connection.commit()
    connection.close()
    return bag


@pytest.mark.parametrize("topic", [name for name in TOPICS if not name.startswith("/mu") or name.startswith("/mu3/")])
def test_each_topic_that_is_missing_is_named_with_what_cannot_be_shown(rows, tmp_path, topic):
    table = table_of(without(rows, tmp_path / "bag", [topic]), tmp_path)
    assert any(consequences(topic) in problem for problem in table["problems"]), table["problems"]
    assert len(table["problems"]) == 1
    assert topic not in table["topics"]


@pytest.mark.parametrize("seed", range(3))
def test_whatever_is_missing_the_rest_is_shown(rows, tmp_path, monkeypatch, seed):
    monkeypatch.setattr(pictures, "_RESOLUTION_DPI", 20)
    rng = random.Random(seed)
    missing = rng.sample(TOPICS, rng.randrange(8, len(TOPICS) - 3))
    bag = without(rows, tmp_path / "bag", missing)
    assert analyse([str(bag), "--output", str(tmp_path / "out")]) == 0


# --- the mission's clock


def test_the_clock_of_most_messages_is_the_missions():
    stamps = [10 * SECOND_NS, 20 * SECOND_NS, foreign_bags.WALL_NS, 30 * SECOND_NS]
    clock = MissionClock([100, 200, 250, 300], stamps)
    assert clock.time_ns(25 * SECOND_NS, 0) == 25 * SECOND_NS, "a stamp counts, whenever it was recorded"
    assert clock.time_ns(foreign_bags.WALL_NS, 260) == 20 * SECOND_NS
    assert [clock.time_ns(None, log) // SECOND_NS for log in (0, 100, 199, 200, 1000)] == [10, 10, 10, 20, 30]
    assert clock.time_ns(0, 300) == 30 * SECOND_NS


def test_where_nothing_tells_the_time_log_times_do():
    assert MissionClock([], []).time_ns(None, 77) == 77
    assert MissionClock([], []).time_ns(5, 77) == 77


def test_without_clock_the_stamps_of_all_topics_tell_the_time(rows, tmp_path):
    bag = without(rows, tmp_path / "bag", ["/clock"])
    clock = mission_clock(open_bag(bag), Decoder())
    log_time = foreign_bags.wall_clock(toy_mission.START_NS + 10 * SECOND_NS)
    assert clock.time_ns(None, log_time) == toy_mission.START_NS + 10 * SECOND_NS


def test_what_was_said_before_its_node_knew_the_time_is_dated_by_the_others(short, tmp_path):
    """In a bag with wall-clock log times an unset stamp is no year 2025 in the table."""
    bag = foreign_bags.by_rosbags(short, tmp_path / "bag", log_time=foreign_bags.wall_clock)
    connection = sqlite3.connect(next(bag.glob("*.db3")))
    topic = "(SELECT id FROM topics WHERE name = '/mission/state')"
    [(row, data)] = connection.execute(f"SELECT id, data FROM messages WHERE topic_id = {topic} ORDER BY id LIMIT 1")
    connection.execute("UPDATE messages SET data = ? WHERE id = ?", (data[:4] + bytes(8) + data[12:], row))
    connection.commit()
    connection.close()
    data = load(open_bag(bag))
    assert data.phases[0].time_ns == toy_mission.START_NS
    assert data.end_ns == toy_mission.START_NS + 3 * SECOND_NS
