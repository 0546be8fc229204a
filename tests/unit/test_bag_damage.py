"""Damaged and hostile bags: damage costs what it hits, "whole" is never said of a changed bag, memory is bounded."""

import random
import struct
import subprocess
import sys
import zlib
from collections import Counter

import lz4.frame
import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.writer import CompressionType, IndexType, Writer

from tests import toy_mission
from tethernet_bringup.bags.contents import LARGEST_RECORD_BYTES, MOST_PROBLEMS
from tethernet_bringup.bags.errors import NotABagError
from tethernet_bringup.bags.mcap_writer import MAGIC
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.salvage import salvage
from tethernet_bringup.cli.main import main as tethernet

HEAD = struct.Struct("<BQ")
OTHERS = 0x80
"""Opcode of records that others may put into a file."""
MEMORY_MB = 500
"""More than the largest content, twice, and the interpreter with its libraries."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A bag of many chunks: (its bytes, its messages, its records as (position, opcode, end))."""
    folder = toy_mission.write_bag(tmp_path_factory.mktemp("run") / "bag", end_s=2.0, flush_every_s=0.1)
    content = (folder / "bag_0.mcap").read_bytes()
    records, position = [], len(MAGIC)
    while position < len(content) - len(MAGIC):
        opcode, length = HEAD.unpack_from(content, position)
        records.append((position, opcode, position + HEAD.size + length))
        position += HEAD.size + length
    return content, list(open_bag(folder).messages()), records


def read(path, content):
    path.write_bytes(content)
    bag = open_bag(path)
    return list(bag.messages()), bag


def flipped(content, position, mask):
    changed = bytearray(content)
    changed[position] ^= mask
    return bytes(changed)


def of(records, *opcodes):
    return [record for record in records if record[1] in opcodes]


def test_a_whole_bag_is_verified(tmp_path, whole):
    content, messages, _ = whole
    kept, bag = read(tmp_path / "a.mcap", content)
    assert (kept, bag.problems, bag.verified) == (messages, [], True)


@pytest.mark.parametrize(
    ("where", "count", "chunks"),
    [
        ("anywhere", 120, 1),
        ("heads of records", 120, 0),
        ("schemas, channels, facts, closing part", 120, 0),
        ("heads of chunks", 60, 1),
    ],
)
def test_one_wrong_byte_costs_at_most_its_chunk_and_is_noticed(tmp_path, whole, where, count, chunks):
    content, messages, records = whole
    rng = random.Random(where)
    described = of(records, 1, 2, 3, 4, 8, 11, 12, 13, 14, 15)
    places = {
        "anywhere": range(len(content)),
        "heads of records": [position + i for position, _, _ in records for i in range(HEAD.size)],
        "schemas, channels, facts, closing part": [i for start, _, end in described for i in range(start, end)],
        "heads of chunks": [i for start, _, _ in of(records, Opcode.CHUNK) for i in range(start, start + 60)],
    }[where]
    # A chunk of 0.1 s holds two ticks, or three.
    most = 3 * max(Counter(message.log_time for message in messages).values())
    for place in rng.sample(list(places), count):
        mask = rng.choice([0x01, 0x80, 0xFF, rng.randrange(1, 256)])
        kept, bag = read(tmp_path / "a.mcap", flipped(content, place, mask))
        assert not bag.verified, place
        assert bag.problems, place
        assert len(messages) - len(kept) <= chunks * most, (place, bag.problems)
        rest = iter(messages)
        assert all(message in rest for message in kept), place


def test_what_is_missing_is_counted(tmp_path, whole):
    content, messages, records = whole
    start, _, end = of(records, Opcode.CHUNK)[2]
    kept, bag = read(tmp_path / "a.mcap", flipped(content, (start + end) // 2, 0x55))
    missing = len(messages) - len(kept)
    assert missing > 0
    assert f"{missing} of {len(messages)} messages are missing" in "\n".join(bag.problems)


def test_a_chunk_that_is_gone_is_noticed(tmp_path, whole):
    content, messages, records = whole
    start, _, end = of(records, Opcode.CHUNK)[2]
    kept, bag = read(tmp_path / "a.mcap", content[:start] + content[end:])
    assert 0 < len(kept) < len(messages)
    assert not bag.verified
    assert "it was changed after it was written" in "\n".join(bag.problems)


def test_a_hole_in_the_middle_costs_two_chunks(tmp_path, whole):
    """A block that is missing, as after a damaged file system: the records behind it are found again."""
    content, messages, records = whole
    chunks = of(records, Opcode.CHUNK)
    start = (chunks[4][0] + chunks[4][2]) // 2
    kept, bag = read(tmp_path / "a.mcap", content[:start] + content[start + 4096 :])
    assert len(kept) > len(messages) * (len(chunks) - 3) / len(chunks)
    assert bag.problems


def test_a_torn_bag_with_a_wrong_byte_too(tmp_path, whole):
    content, messages, records = whole
    chunks = of(records, Opcode.CHUNK)
    cut = content[: chunks[12][0] + 200]
    kept, _ = read(tmp_path / "a.mcap", flipped(cut, chunks[3][0] + 2, 0x40))
    assert len(kept) == sum(1 for m in messages if m.log_time <= kept[-1].log_time)


LENGTH_OF_RECORD, LENGTH_OF_DATA = 1, HEAD.size + 8 + 8 + 8 + 4 + 4 + len("zstd")
"""Where the two lengths of a chunk are, from its start."""


@pytest.mark.parametrize("at", [LENGTH_OF_RECORD, LENGTH_OF_DATA])
def test_a_length_that_leads_to_a_later_record_costs_nothing(tmp_path, whole, at):
    """Of a chunk's two lengths a wrong one may end at a record too: what lies between stays."""
    content, messages, records = whole
    start, _, end = of(records, Opcode.CHUNK)[3]
    (length,) = struct.unpack_from("<Q", content, start + at)
    later = [record for record in records if record[0] > end]
    for position, _, _ in later[::7]:
        changed = bytearray(content)
        struct.pack_into("<Q", changed, start + at, length + position - end)
        kept, bag = read(tmp_path / "a.mcap", bytes(changed))
        assert kept == messages, position
        assert not bag.verified


@pytest.mark.parametrize("opcode", [Opcode.SCHEMA, Opcode.CHANNEL])
def test_a_description_that_leads_to_a_later_record_costs_nothing(tmp_path, whole, opcode):
    """Without a closing part, which would repeat the descriptions that follow."""
    content, messages, records = whole
    last = of(records, Opcode.CHUNK)[-1]
    described = of(records, opcode)
    start, _, end = described[0]
    for position, _, _ in [record for record in records if end < record[0] < last[0]][::7]:
        changed = bytearray(content[: last[2]])
        struct.pack_into("<Q", changed, start + LENGTH_OF_RECORD, position - start - HEAD.size)
        kept, _ = read(tmp_path / "a.mcap", bytes(changed))
        assert kept == messages, position


def test_the_command_says_whole_only_of_a_verified_bag(tmp_path, whole, capsys):
    content, _, records = whole
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    assert tethernet(["salvage", str(path), str(tmp_path / "out1")]) == 0
    assert "the bag was whole" in capsys.readouterr().out
    header = of(records, Opcode.HEADER)[0]
    path.write_bytes(flipped(content, header[2] - 1, 0x20))  # a letter of the writer's name: no message is hit
    assert tethernet(["salvage", str(path), str(tmp_path / "out2")]) == 0
    out = capsys.readouterr().out
    assert "the bag was whole" not in out
    assert "it was changed after it was written" in out


def test_a_wrong_length_that_leads_to_what_looks_like_a_record_costs_nothing(tmp_path):
    for shift in range(9):  # in one of them the wrong end is at such a place
        path = tmp_path / f"{shift}.mcap"
        with path.open("wb") as stream:
            writer = Writer(stream, compression=CompressionType.NONE, chunk_size=3000)
            writer.start("ros2", "another")
            channel = writer.register_channel(
                "/text", "cdr", writer.register_schema("a/msg/B", "ros2msg", b"string a\n")
            )
            for number in range(100):
                writer.add_message(channel, number, bytes(shift) + HEAD.pack(OTHERS, 0) * 100, number, number)
            writer.finish()
        content = path.read_bytes()
        position = len(MAGIC)
        while content[position] != Opcode.CHUNK:
            position += HEAD.size + HEAD.unpack_from(content, position)[1]
        kept, _ = read(path, flipped(content, position + 2, 0x40))
        assert [message.log_time for message in kept] == list(range(100)), shift


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_bags_of_another_recorder(tmp_path, capsys, compression, chunked):
    """Schemas and channels inside the chunks, no checksum over the whole file."""
    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(
            stream, compression=compression, chunk_size=2000, use_chunking=chunked, index_types=IndexType.ALL,
            enable_crcs=chunked,
        )  # fmt: skip
        writer.start("ros2", "another")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/text", "cdr", schema)
        for number in range(100):
            writer.add_message(channel, number, b"\0\1\0\0\2\0\0\0a\0" + bytes(90), number, number)
        writer.finish()
    content = path.read_bytes()
    kept, bag = read(path, content)
    assert [message.log_time for message in kept] == list(range(100))
    assert (bag.problems, bag.verified) == ([], False)
    assert tethernet(["salvage", str(path), str(tmp_path / "out")]) == 0
    assert "as far as can be seen" in capsys.readouterr().out
    rng = random.Random(4)
    for place in rng.sample(range(len(MAGIC), len(content)), 60):
        kept, bag = read(path, flipped(content, place, 0xFF))
        assert len(kept) >= 75, (place, bag.problems)


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def record(opcode, body):
    return HEAD.pack(opcode, len(body)) + body


def chunk(compression, data, size=1000, checksum=0):
    return record(
        6, struct.pack("<QQQI", 0, 1, size, checksum) + text(compression) + struct.pack("<Q", len(data)) + data
    )


def inflating(compression, piece, count):
    compressor = zstandard.ZstdCompressor().compressobj() if compression == "zstd" else lz4.frame.LZ4FrameCompressor()
    begin = b"" if compression == "zstd" else compressor.begin()
    return begin + b"".join(compressor.compress(piece) for _ in range(count)) + compressor.flush()


MESSAGE = record(5, struct.pack("<HIQQ", 1, 0, 5, 5) + b"\0\1\0\0\2\0\0\0a\0\0\0")
EMPTY = record(5, struct.pack("<HIQQ", 1, 0, 0, 0))
START = (
    MAGIC
    + record(1, text("ros2") + text("t"))
    + record(3, struct.pack("<H", 1) + text("std_msgs/msg/String") + text("ros2msg") + text("string data\n"))
    + record(4, struct.pack("<HH", 1, 1) + text("/x") + text("cdr") + struct.pack("<I", 0))
)
END = chunk("", MESSAGE, len(MESSAGE), zlib.crc32(MESSAGE)) + record(15, bytes(4)) + record(2, bytes(20)) + MAGIC


def schema(number, length):
    return record(3, struct.pack("<H", number) + text(f"a/msg/B{number}") + text("ros2msg") + text("#" * length))


def whole_chunk(content):
    return chunk("zstd", zstandard.compress(content), len(content), zlib.crc32(content))


def mapping(value):
    entries = text("k") + text(value)
    return struct.pack("<I", len(entries)) + entries


def zeros(compression, mebibytes):
    return inflating(compression, bytes(1 << 20), mebibytes)


HOSTILE = {
    "zstd": lambda: START + chunk("zstd", zeros("zstd", 400)) + END,
    "zstd that says so": lambda: START + chunk("zstd", zeros("zstd", 400), 400 << 20) + END,
    "torn zstd": lambda: START + chunk("zstd", zeros("zstd", 400))[:-20],
    "lz4": lambda: START + chunk("lz4", zeros("lz4", 300)) + END,
    "torn lz4": lambda: START + chunk("lz4", zeros("lz4", 300))[:-20],
    "window of a gigabyte": lambda: START + chunk("zstd", bytes.fromhex("28b52ffd00a8") + bytes(300)) + END,
    "many chunks": lambda: START + chunk("zstd", zeros("zstd", 60), 60 << 20) * 60 + END,
    "a schema of 40 MB": lambda: START + whole_chunk(schema(2, 40_000_000)) + END,
    "many schemas": lambda: START + whole_chunk(b"".join(schema(2 + n, 900_000) for n in range(60))) + END,
    "facts of 50 MB": lambda: START + record(12, text("m") + mapping("v" * 50_000_000)) + END,
    "a length beyond the file": lambda: START + HEAD.pack(3, 1 << 60) + bytes(100) + END,
    "an attachment of an exabyte": lambda: START + record(9, bytes(24) + struct.pack("<Q", 1 << 62) + bytes(64)) + END,
    "many chunks of rubbish": lambda: START + chunk("", b"", 5, 7) * 20_000 + END,
    "heads in heads": lambda: START + b"".join(HEAD.pack(7, (1 << 26) - n) for n in range(20_000)) + END,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_bags_cost_bounded_memory(tmp_path, name):
    """The good message behind the hostile part is found where there is one, and the reason is given."""
    path = tmp_path / "a.mcap"
    path.write_bytes(HOSTILE[name]())
    code = (
        "import sys\n"
        "from tethernet_bringup.cli.main import main\n"
        f"status = main(['salvage', {str(path)!r}, {str(tmp_path / 'out')!r}])\n"
        "peak = next(line for line in open('/proc/self/status') if line.startswith('VmHWM'))\n"
        "print('peak', int(peak.split()[1]) // 1000)\n"
        "sys.exit(status)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False)
    torn = name.startswith("torn")
    assert done.returncode == (1 if torn else 0), done.stderr
    assert "Traceback" not in done.stderr
    assert int(done.stdout.split()[-1]) < MEMORY_MB
    said = done.stderr + done.stdout
    assert "left out" in said, said
    assert len(said) < 300 * (MOST_PROBLEMS + 3)


def test_the_largest_content_is_read(tmp_path):
    content = EMPTY * (LARGEST_RECORD_BYTES // len(EMPTY) // 40)
    kept, bag = read(tmp_path / "a.mcap", START + whole_chunk(content) + END)
    assert len(kept) == len(content) // len(EMPTY) + 1
    assert bag.problems == []


def test_a_message_on_an_unknown_topic_costs_itself_alone(tmp_path):
    content = MESSAGE + record(5, struct.pack("<HIQQ", 9, 0, 5, 5) + b"abcd") + MESSAGE
    kept, bag = read(tmp_path / "a.mcap", START + whole_chunk(content) + END)
    assert len(kept) == 3
    assert "1 messages were left out of topic number 9: its name is not in the bag" in bag.problems[0]


def test_a_salvaged_bag_is_verified(tmp_path, whole):
    content, _, _ = whole
    (tmp_path / "a.mcap").write_bytes(content[: len(content) // 2])
    out = salvage(tmp_path / "a.mcap", tmp_path / "out").folder
    again = open_bag(out)
    assert sum(1 for _ in again.messages()) > 0
    assert again.verified


def test_wrong_first_bytes_cost_nothing(tmp_path, whole):
    content, messages, _ = whole
    kept, bag = read(tmp_path / "a.mcap", b"\0" * 8 + content[8:])
    assert kept == messages
    assert "the first bytes are not those of an MCAP file" in bag.problems[0]
    with pytest.raises(NotABagError):
        read(tmp_path / "b.mcap", b"\0" * 5000)
