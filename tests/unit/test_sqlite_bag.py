"""SQLite bags: read like MCAP bags, and as wary of what is wrong with them."""

import sqlite3

import pytest
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from tests import toy_mission
from tethernet_bringup.analysis.command_line import main as analyse
from tethernet_bringup.bags.errors import NotABagError
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.salvage import salvage


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    """A mission's bag, and the same as SQLite, converted with rosbags."""
    folder = tmp_path_factory.mktemp("bags")
    mcap = toy_mission.write_bag(folder / "mcap" / "bag", end_s=26.0)
    sqlite = folder / "sqlite" / "bag"
    sqlite.parent.mkdir()
    store = get_typestore(Stores.EMPTY)
    with Reader(mcap) as reader, Writer(sqlite, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        for key, value in toy_mission.RUN_INFO.items():
            writer.set_custom_data(key, value)
        connections = {
            c.id: writer.add_connection(
                c.topic, c.msgtype, msgdef=c.msgdef.data, rihs01=c.digest, serialization_format="cdr", typestore=store
            )
            for c in reader.connections
        }
        for connection, time, data in reader.messages():
            writer.write(connections[connection.id], time, data)
    return mcap, sqlite


@pytest.fixture
def database(bags, tmp_path):
    path = tmp_path / "bag" / "bag.db3"
    path.parent.mkdir()
    path.write_bytes(next(bags[1].glob("*.db3")).read_bytes())
    return path


def change(path, *statements):
    connection = sqlite3.connect(path)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


def table(bag, capsys):
    """What is printed but for the bag's name and for losses, of which SQLite keeps no count."""
    assert analyse([str(bag), "--no-plots"]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    return [line.replace("none lost on the way", "what was lost on the way is not counted") for line in lines]


def test_the_table_of_an_sqlite_bag_is_that_of_the_mcap_bag(bags, capsys):
    mcap, sqlite = bags
    assert table(sqlite, capsys) == table(mcap, capsys)


def test_the_messages_are_the_same(bags):
    mcap, sqlite = (sorted((m.topic, m.log_time, m.data) for m in open_bag(bag).messages()) for bag in bags)
    assert sqlite == mcap
    assert len(mcap) > 10_000


def test_an_sqlite_bag_is_only_read_and_can_be_rewritten(bags, database, tmp_path):
    before = database.read_bytes()
    result = salvage(database, tmp_path / "out")
    assert (result.problems, result.verified) == ((), False)
    assert sum(1 for _ in open_bag(result.folder).messages()) == result.message_count
    assert database.read_bytes() == before
    assert [path.name for path in database.parent.iterdir()] == ["bag.db3"]


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        (["UPDATE messages SET topic_id = 999 WHERE id = 3"], "1 messages were left out, their topic is unknown"),
        (["UPDATE messages SET data = 'text' WHERE id < 3"], "2 messages were left out, they are damaged or too long"),
        (["UPDATE messages SET data = zeroblob(70000000) WHERE id = 3"], "1 messages were left out, they are damaged"),
        (["UPDATE messages SET data = x'28b52ffd0000ffffffffffff' WHERE id = 3"], "it cannot be decompressed"),
        (
            ["UPDATE topics SET type = 'no_msgs/msg/Thing' WHERE name = '/tf'"],
            "type no_msgs/msg/Thing is neither in it nor installed",
        ),
    ],
)
def test_what_is_damaged_is_left_out_and_said(database, statements, expected):
    change(database, *statements)
    bag = open_bag(database)
    assert sum(1 for _ in bag.messages()) > 10_000
    assert expected in "\n".join(bag.problems)


def test_without_definitions_the_installed_ones_are_used(database, bags, capsys):
    change(database, "DROP TABLE message_definitions")
    assert table(database, capsys)[1:] == table(bags[0], capsys)[1:]


def test_a_torn_database_is_refused_in_one_sentence(database, capsys):
    """SQLite keeps its directory in its first pages, and refuses a file that is shorter than that says."""
    content = database.read_bytes()
    database.write_bytes(content[: len(content) // 2])
    assert analyse([str(database), "--no-plots"]) == 1
    assert "cannot be read as an SQLite bag: database disk image is malformed" in capsys.readouterr().err


def test_a_damaged_page_costs_what_follows_it(database):
    content = bytearray(database.read_bytes())
    content[len(content) // 2 : len(content) // 2 + 8192] = bytes(8192)
    database.write_bytes(content)
    bag = open_bag(database)
    assert sum(1 for _ in bag.messages()) > 1000
    assert "it is damaged, what follows is left out" in bag.problems[0]


@pytest.mark.parametrize(
    "statements",
    [
        ["DROP TABLE messages"],
        [
            "DROP TABLE messages",
            "CREATE VIEW messages AS WITH RECURSIVE r(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM r) "
            "SELECT id, 1 AS topic_id, id AS timestamp, x'00' AS data FROM r",
        ],
    ],
)
def test_a_database_that_is_no_bag_is_refused(database, statements):
    change(database, *statements)
    with pytest.raises(NotABagError, match="no bag: it has no tables"):
        list(open_bag(database).messages())


def test_rubbish_that_begins_like_a_database_is_refused(database):
    database.write_bytes(b"SQLite format 3\0" + bytes(5000))
    with pytest.raises(NotABagError, match="cannot be read as an SQLite bag"):
        list(open_bag(database).messages())
