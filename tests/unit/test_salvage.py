"""Torn bags: whatever the cut, the messages before it come back."""

import random
import subprocess

import pytest
import yaml
from rosbags.highlevel import AnyReader

from tests import toy_mission
from tests.command import COMMAND, tethernet
from tethernet_bringup.bags.errors import BagWriteError, NotABagError
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.salvage import salvage

SHORT_S = 2.0


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A bag of several chunks: (its file's bytes, its messages in the order of the file)."""
    folder = toy_mission.write_bag(tmp_path_factory.mktemp("run") / "bag", end_s=SHORT_S, flush_every_s=0.25)
    return (folder / "bag_0.mcap").read_bytes(), list(open_bag(folder).messages())


def torn(folder, content):
    folder.mkdir(parents=True)
    (folder / "bag_0.mcap").write_bytes(content)
    return folder


def read(bag):
    return list(open_bag(bag).messages())


def test_cut_anywhere_the_messages_before_it_come_back(tmp_path, whole):
    content, messages = whole
    rng = random.Random(1)
    begin = content.index(b"zstd")  # in the first chunk
    previous = 0
    for cut in sorted(rng.randrange(begin, len(content)) for _ in range(25)):
        folder = torn(tmp_path / str(cut), content[:cut])
        try:
            result = salvage(folder, tmp_path / f"{cut}_out")
        except NotABagError:
            assert previous == 0, "a longer piece gave less than a shorter one"
            continue
        kept = read(result.folder)
        assert kept == messages[: len(kept)]
        assert result.message_count == len(kept) >= previous
        assert result.problems
        assert (folder / "bag_0.mcap").read_bytes() == content[:cut], "the torn bag was touched"
        previous = len(kept)
    assert previous > len(messages) // 2


def test_the_salvaged_bag_is_a_whole_one(tmp_path, whole):
    content, _ = whole
    folder = torn(tmp_path / "bag", content[: len(content) * 2 // 3])
    result = salvage(folder, tmp_path / "out")
    with AnyReader([result.folder]) as reader:
        assert sum(1 for _ in reader.messages()) == reader.message_count == result.message_count
    information = yaml.safe_load((result.folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == result.message_count
    assert information["custom_data"] == toy_mission.RUN_INFO
    assert all(t["topic_metadata"]["type_description_hash"] for t in information["topics_with_message_count"])
    again = open_bag(result.folder)
    assert sum(1 for _ in again.messages()) == result.message_count
    assert again.problems == []


def test_a_cut_chunk_gives_its_first_messages(tmp_path, whole):
    """zstd is decoded block by block; a block is at most 128 KiB."""
    content, messages = whole
    bag = open_bag(torn(tmp_path / "bag", content))
    writer_cut = tmp_path / "long"
    long = toy_mission.write_bag(writer_cut, end_s=SHORT_S, flush_every_s=100.0)  # one chunk of a MiB, then another
    path = next(long.glob("*.mcap"))
    path.write_bytes(path.read_bytes()[:150_000])
    assert 0 < sum(1 for _ in open_bag(long).messages()) < len(messages)
    assert sum(1 for _ in bag.messages()) == len(messages)


@pytest.mark.parametrize("tail", [b"\x00" * 1000, bytes(random.Random(2).randbytes(5000)), b"\x06" + b"\xff" * 200])
def test_rubbish_at_the_end_is_left_out(tmp_path, whole, tail):
    content, messages = whole
    end = content.rindex(b"rosbag2", 0, content.rindex(b"serialized_metadata")) - 13
    folder = torn(tmp_path / "bag", content[:end] + tail)
    result = salvage(folder, tmp_path / "out")
    assert read(result.folder) == messages
    assert len(result.problems) == 1


def test_a_damaged_chunk_costs_only_itself(tmp_path, whole):
    content, messages = whole
    middle = content.index(b"zstd", len(content) // 4) + 200  # in a chunk
    folder = torn(
        tmp_path / "bag",
        content[:middle] + bytes(b ^ 0x55 for b in content[middle : middle + 3]) + content[middle + 3 :],
    )
    result = salvage(folder, tmp_path / "out")
    kept = read(result.folder)
    assert 0.5 * len(messages) < len(kept) < len(messages)
    assert set(kept) < set(messages)
    assert any("chunk was left out" in problem for problem in result.problems)


def test_a_length_of_many_gigabytes_costs_no_memory(tmp_path, whole):
    content, messages = whole
    first = content.index(b"zstd") - 8 - 8 - 8 - 4 - 4 - 8  # the length of the first chunk's record
    folder = torn(tmp_path / "bag", content[:first] + (1 << 60).to_bytes(8, "little") + content[first + 8 :])
    bag = open_bag(folder)
    kept = list(bag.messages())  # the record reaches beyond the file, so what there is of it is taken
    assert kept == messages[: len(kept)]
    assert len(bag.problems) == 1


def test_without_metadata_yaml(tmp_path, whole):
    content, messages = whole
    result = salvage(torn(tmp_path / "bag", content), tmp_path / "out")
    assert read(result.folder) == messages
    assert result.problems == ()


def test_default_output_is_beside_the_torn_bag(tmp_path, whole):
    content, _ = whole
    torn(tmp_path / "run" / "bag", content[:-100])
    assert salvage(tmp_path / "run").folder == tmp_path / "run" / "bag_salvaged"
    assert salvage(tmp_path / "run" / "bag", tmp_path / "o1").folder == tmp_path / "o1"
    file = tmp_path / "run" / "bag" / "bag_0.mcap"
    with pytest.raises(BagWriteError, match="not empty"):
        salvage(file)  # would be bag_salvaged again


def test_the_command_tells_what_was_recovered(tmp_path, whole, capsys):
    content, _ = whole
    folder = torn(tmp_path / "bag", content[: len(content) // 2])
    assert tethernet("salvage", str(folder), str(tmp_path / "out")) == 0
    out = capsys.readouterr().out
    assert "recovered " in out
    assert "messages, 1.00 s to " in out
    assert "lost: bag_0.mcap, byte " in out


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda p: None, "does not exist"),
        (lambda p: p.write_bytes(b""), "is empty"),
        (lambda p: p.write_bytes(b"hello, I am no bag"), "is no MCAP file"),
        (lambda p: p.mkdir(), "holds no bag"),
        (lambda p: (p.mkdir(), (p / "old.db3").touch()), "is empty"),
        (lambda p: (p.mkdir(), (p / "bag_0.mcap").write_bytes(b"\x89MCAP0\r\n")), "not one message can be recovered"),
    ],
)
def test_what_is_no_bag_is_told(tmp_path, capsys, make, expected):
    make(tmp_path / "thing")
    assert tethernet("salvage", str(tmp_path / "thing")) == 1
    assert expected in capsys.readouterr().err
    assert not (tmp_path / "thing_salvaged").exists()


def test_a_folder_of_runs_is_told(tmp_path, whole, capsys):
    for name in ("run1", "run2"):
        torn(tmp_path / name / "bag", whole[0])
    assert tethernet("salvage", str(tmp_path)) == 1
    assert "holds 2 runs; name one of them: run1, run2" in capsys.readouterr().err


def test_as_a_process(tmp_path, whole):
    folder = torn(tmp_path / "bag", whole[0][:-9])
    command = [*COMMAND, "salvage"]
    done = subprocess.run([*command, str(folder)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert subprocess.run(command, capture_output=True, text=True, check=False).returncode == 2
