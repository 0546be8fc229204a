"""What the command finds out about the recording when the mission is over, and whether the recorder goes on."""

import json
import os
import shutil

import pytest

from tests import toy_mission
from tethernet_bringup.pulse import Pulse
from tethernet_bringup.recorder.recording import count_messages, faults, problems, recorded_messages, sign_of_life


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    run = tmp_path_factory.mktemp("runs") / "run"
    topics = toy_mission.bag_topics()
    writer = toy_mission.BagWriter(run / "bag", topics, run_info={})
    for index, stamp, data in toy_mission.serialized(8, 1.0):
        writer.write(index, stamp, stamp, 0, data)
    writer.close()
    report = {
        "state": "complete",
        "fault": "",
        "message_count": sum(writer.counts),
        "messages": {topic.name: count for topic, count in zip(topics, writer.counts, strict=True)},
        "never_arrived": {},
        "bytes": writer.size,
        "crc32": writer.checksum,
    }
    (run / "recorder.json").write_text(json.dumps(report))
    return run


@pytest.fixture
def run(recorded, tmp_path):
    return shutil.copytree(recorded, tmp_path / "run")


def bag_file(run):
    return run / "bag" / "bag_0.mcap"


def edit_report(run, **changes):
    path = run / "recorder.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_a_whole_recording_has_no_faults(run):
    assert faults(run, run / "bag") == []
    assert problems(run) == []
    assert sum(count_messages(run / "bag").values()) > 100


def overwrite(run, content):
    bag_file(run).write_bytes(content)


@pytest.mark.parametrize(
    ("damage", "expected"),
    [
        (lambda run: bag_file(run).unlink(), "bag_0.mcap is gone"),
        (lambda run: shutil.rmtree(run / "bag"), "bag_0.mcap is gone"),
        (lambda run: overwrite(run, bag_file(run).read_bytes()[:-1]), "the recorder wrote"),
        (lambda run: overwrite(run, b""), "has 0 bytes"),
        (lambda run: overwrite(run, b"\0" * bag_file(run).stat().st_size), "not what the recorder wrote"),
        (lambda run: (bag_file(run).unlink(), bag_file(run).mkdir()), "cannot be read: Is a directory"),
        (lambda run: (run / "bag" / "metadata.yaml").unlink(), "metadata.yaml is gone or was changed"),
        (lambda run: (run / "bag" / "metadata.yaml").write_text("a: [1"), "metadata.yaml is gone or was changed"),
        (lambda run: os.truncate(run / "bag" / "metadata.yaml", 1 << 30), "metadata.yaml is gone or was changed"),
        (lambda run: (run / "recorder.json").unlink(), "left no report"),
        (lambda run: (run / "recorder.json").write_text("[]"), "left no report"),
        (lambda run: edit_report(run, state="recording"), "ended without closing the bag"),
        (lambda run: edit_report(run, state="fault", fault="disk full"), "not complete: disk full"),
        (lambda run: edit_report(run, message_count=0), "nothing was recorded"),
    ],
)
def test_what_is_wrong_with_a_recording_is_a_fault(run, damage, expected):
    damage(run)
    (found,) = faults(run, run / "bag")
    assert expected in found


def test_of_a_killed_recorder_the_last_report_tells_the_counts(run):
    counted = count_messages(run / "bag")
    assert recorded_messages(run, run / "bag") == counted
    edit_report(run, state="recording", messages={"/clock": 7})
    assert recorded_messages(run, run / "bag") == {"/clock": 7}
    (run / "recorder.json").unlink()
    assert recorded_messages(run, run / "bag") == counted


def test_lost_messages_are_only_a_warning(run):
    edit_report(run, never_arrived={"/mu1/odom": 3})
    assert faults(run, run / "bag") == []
    assert problems(run) == ["messages that were sent but not recorded: /mu1/odom (3)"]


def test_a_recorder_that_renews_its_report_lives_and_one_that_does_not_hangs(run):
    now = 0.0
    pulse = Pulse({}, 3.0, lambda: now)
    pulse.watch("recorder", sign_of_life(run))
    for tick in range(100):
        now = 0.1 * tick
        if tick % 10 == 0:
            (run / "new").write_text(str(tick))
            (run / "new").replace(run / "recorder.json")
        assert pulse.update() == []
    hung = []
    for tick in range(100, 150):
        now = 0.1 * tick
        hung += pulse.update()
    assert hung == ["recorder"]
    (run / "recorder.json").unlink()
    pulse = Pulse({}, 3.0, lambda: now)
    pulse.watch("recorder", sign_of_life(run))
    for tick in range(150, 200):
        now = 0.1 * tick
        hung += pulse.update()
    assert hung == ["recorder", "recorder"], "no report is no sign of life"
