"""analyse_mission: the table says what was flown, the pictures are there, and bad bags are told."""

import json
import math
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from tests import toy_mission
from tethernet_bringup.analysis import pictures, recorded_flight, snapshots
from tethernet_bringup.analysis.arguments import parse
from tethernet_bringup.analysis.command_line import default_output, main
from tethernet_bringup.analysis.metrics import net_distance, report, tracking_error
from tethernet_bringup.analysis.mission_data import load
from tethernet_bringup.analysis.punctuality import ClosingStart, closing_start, delay_text, late_decisions
from tethernet_bringup.bags.message_definitions import installed_type
from tethernet_bringup.bags.metadata import BagTopic, qos_profiles
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.writer import BagWriter

PLOTS = {"tracking.png", "thrust.png", "fuel.png", "capture.png", "loads.png", "snapshots.png", "overview.png"}
PICTURES = PLOTS | {"report.html"}
MU_TOPICS = [f"/mu{mu}/{what}" for mu in range(1, 9) for what in ("odom", "thrust", "status")]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "run"
    toy_mission.write_bag(folder / "bag")
    return folder


@pytest.fixture(scope="module")
def data(run):
    return load(open_bag(run))


@pytest.fixture
def coarse(monkeypatch):
    """Pictures of few dots, flights of few moments: quick."""
    monkeypatch.setattr(pictures, "_RESOLUTION_DPI", 30)
    monkeypatch.setattr(recorded_flight, "MOST_NUMBERS", 50_000)


def analyse(capsys, *words):
    status = main([str(word) for word in words])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def picture_shape(path):
    import matplotlib.image

    return matplotlib.image.imread(path).shape


def test_the_whole_analysis(run, tmp_path, capsys):
    status, out, err = analyse(capsys, run, "--output", tmp_path, "--json")
    assert (status, err) == (0, "")
    assert {path.name for path in tmp_path.iterdir()} == PICTURES | {"analysis.json"}
    for name in PLOTS:
        image = picture_shape(tmp_path / name)
        assert image[0] > 400, name
        assert image[1] > 800, name
    assert "system zenit_8mu, 8 units, policy nominal, seed 7, pace lockstep, commit 0123abc" in out
    assert "captured: CQI 0.90 below 2.5, 8 of 8 pairs locked" in out
    assert "/mu1..8/odom                      790 each   20.0              0.05      -      -" in out
    content = json.loads((tmp_path / "analysis.json").read_text())
    assert content["captured"] is True
    assert content["locked_pairs"] == content["max_locked_pairs"] == 8
    assert content["problems"] == []
    assert content["topics"]["/net/state"]["messages"] == 790


def test_phases_have_their_times(data):
    assert [change.phase.name for change in data.phases] == ["ARMED", "DEPLOYING", "CLOSING", "COMPLETE"]
    times = [float(data.seconds(change.time_ns)) for change in data.phases]
    assert times == pytest.approx([0.0, 0.0, toy_mission.TRIGGER_S, toy_mission.END_S])


def test_it_says_when_closing_began_and_which_decisions_came_late(run, data, tmp_path, coarse, capsys):
    start = closing_start(data)
    assert start.trigger_s == pytest.approx(toy_mission.TRIGGER_S - 0.05)
    on_time = dict.fromkeys(range(1, 9), 1)
    assert start.ticks == on_time | {toy_mission.LATE_MU: 1 + toy_mission.LATE_TICKS}
    count, [late] = late_decisions(data)
    assert (count, late.sequence, late.mu, late.ticks) == (8, 3, toy_mission.LATE_MU, toy_mission.LATE_TICKS)
    assert delay_text(start) == "1 to 3 ticks"
    assert delay_text(ClosingStart(24.4, on_time)) == "1 tick"
    _, out, _ = analyse(capsys, run, "--output", tmp_path, "--json")
    assert "trigger                     24.40 s after launch" in out
    assert "closing began               1 to 3 ticks after the trigger, last MU 3" in out
    assert "decisions while closing     1 of 8 late, by 2 ticks at most" in out
    content = json.loads((tmp_path / "analysis.json").read_text())
    assert content["closing_began_ticks_after_trigger"]["3"] == 3
    assert content["late_decisions"] == [{"sequence": 3, "decided_s": pytest.approx(24.4), "mu": 3, "ticks": 2}]


@pytest.mark.parametrize("mu", [1, 6])
def test_tracking_error_is_that_of_the_true_position(data, mu):
    error = tracking_error(data, mu)
    expected = [toy_mission.tracking_error(time) for time in error.time_s]
    kinks = (toy_mission.TRIGGER_S, toy_mission.TRIGGER_S + 8.0)  # the recorded plan is straight across them
    steady = np.isfinite(error.value) & np.all([abs(error.time_s - kink) > 0.25 for kink in kinks], axis=0)
    assert steady.sum() > 750
    assert error.value[steady] == pytest.approx(np.array(expected)[steady], abs=1e-4)


def test_a_report_holds_what_was_flown(data):
    row = report(data, 3)
    assert row.max_error_m == pytest.approx(toy_mission.tracking_error(10.0), abs=1e-3)
    assert toy_mission.tracking_error(24.0) < row.rms_error_m < row.max_error_m
    assert row.impulse_n_s == pytest.approx(toy_mission.THRUST_N * toy_mission.END_S)
    assert row.fuel_kg == pytest.approx(toy_mission.FUEL_KG_S * toy_mission.END_S, rel=0.01)
    assert row.fuel_at_trigger_kg == pytest.approx(toy_mission.FUEL_KG_S * toy_mission.TRIGGER_S)
    assert row.saturated_share == pytest.approx(0.1, abs=0.01)


def test_distance_is_between_the_centres_of_mass(data):
    distance = net_distance(data)
    for index in (0, 200, 780):
        center = toy_mission.knots(distance.time_s[index]).mean(axis=0)
        assert distance.value[index] == pytest.approx(np.linalg.norm(center - toy_mission.DEBRIS), abs=1e-6)


def test_snapshots_show_early_deployment_trigger_and_end(run, data):
    shots = snapshots.take(data, open_bag(run))
    assert [shot.title for shot in shots] == ["early deployment", "trigger", "end"]
    assert [shot.time_s for shot in shots] == pytest.approx([11.0, toy_mission.TRIGGER_S, toy_mission.END_S], abs=0.05)
    for shot in shots:
        assert shot.knots.shape == (23 * 23, 3)
        assert shot.knots.reshape(-1, 3) == pytest.approx(toy_mission.knots(shot.time_s), abs=1e-4)
        assert shot.mus[5] == pytest.approx(toy_mission.true_position(5, shot.time_s), abs=1e-4)
        assert shot.debris[:3] == pytest.approx(toy_mission.DEBRIS)
    assert shots[2].locked.all()


def test_four_mus(tmp_path, coarse, capsys):
    toy_mission.write_bag(tmp_path / "bag", mus=4)
    status, out, _ = analyse(capsys, tmp_path, "--output", tmp_path / "out")
    assert status == 0
    assert "4 units" in out
    assert {path.name for path in (tmp_path / "out").iterdir()} == PICTURES


def test_a_torn_bag_is_analysed_as_far_as_it_goes(run, tmp_path, coarse, capsys):
    content = (run / "bag" / "bag_0.mcap").read_bytes()
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.mcap").write_bytes(content[: len(content) // 2])
    status, out, _ = analyse(capsys, tmp_path, "--output", tmp_path / "out")
    assert status == 0
    assert "note: the bag is damaged: bag_0.mcap, byte " in out
    assert "no verdict in this bag: it ends in phase DEPLOYING" in out
    assert {path.name for path in (tmp_path / "out").iterdir()} == PICTURES
    status, out, _ = analyse(capsys, tmp_path, "--salvage")
    assert status == 0
    assert "recovered " in out
    status, out, _ = analyse(capsys, tmp_path / "bag_salvaged", "--output", tmp_path / "out2")
    assert status == 0
    assert "the bag is damaged" not in out


@pytest.mark.parametrize(
    ("without", "note", "drawn"),
    [
        (["/net/state"], "no /net/state: the net is not drawn", PICTURES - {"loads.png"}),
        (
            ["/debris/odom", "/net/state", "/chaser/odom"],
            "no /debris/odom: the debris is not drawn",
            PICTURES - {"loads.png"},
        ),
        (["/capture/assessment"], "no capture quality and no verdict", PICTURES),
        (["/mission/state"], "no phases, times count from the first message", PICTURES),
        (["/mu3/odom", "/mu3/status"], "no /muN/status of MU 3: no tracking error and no fuel", PICTURES),
        (MU_TOPICS, "no /muN/thrust of any MU: no thrust", PICTURES - {"thrust.png", "fuel.png"}),
        (["/clock", "/tf", "/sim/status"], "no /clock, /tf, /sim/status: nothing here needs them", PICTURES),
    ],
)
def test_what_is_missing_is_told_and_the_rest_is_drawn(tmp_path, coarse, capsys, without, note, drawn):
    toy_mission.write_bag(tmp_path / "bag", end_s=26.0, without=without)
    status, out, err = analyse(capsys, tmp_path, "--output", tmp_path / "out")
    assert (status, err) == (0, "")
    assert note in out
    assert {path.name for path in (tmp_path / "out").iterdir()} == drawn


def test_a_mission_that_was_never_launched_has_no_pictures(tmp_path, capsys):
    flown = ["/net/state", "/debris/odom", "/chaser/odom", "/capture/assessment", "/mission/state"]
    flown += [name for name in MU_TOPICS if not name.endswith("status")]
    toy_mission.write_bag(tmp_path / "bag", end_s=0.0, without=flown)
    status, out, err = analyse(capsys, tmp_path, "--output", tmp_path / "out")
    assert (status, err) == (0, "")
    assert "nothing was flown: no pictures" in out
    assert not (tmp_path / "out").exists()


def test_nan_is_left_out_and_told(tmp_path, coarse, capsys):
    """A bag with NaN in odometry, net and thrust, as no node of ours would send it."""
    from rclpy.serialization import serialize_message

    topics = toy_mission.bag_topics()
    number = {topic.name: index for index, topic in enumerate(topics)}
    writer = BagWriter(tmp_path / "bag", topics, run_info={})
    for count, (name, message) in enumerate(toy_mission.messages(end_s=5.0)):
        if count % 7 == 0 and name == "/mu2/odom":
            message.pose.pose.position.y = math.nan
        elif count % 5 == 0 and name == "/net/state":
            message.center_of_mass.x = math.inf
            message.knot_positions[100] = math.nan
        elif name == "/mu4/thrust":
            message.wrench.force.z = math.nan
        elif name == "/capture/assessment":
            message.cqi = math.nan
        writer.write(number[name], count * 1_000_000, count * 1_000_000, count, serialize_message(message))
    writer.close()
    status, out, err = analyse(capsys, tmp_path, "--output", tmp_path / "out", "--json")
    assert (status, err) == (0, "")
    assert "/mu4/thrust: 101 messages with NaN or infinite numbers left out" in out
    assert "/mu2/odom: " in out
    content = json.loads((tmp_path / "out" / "analysis.json").read_text())
    assert content["cqi"] is None
    assert content["locked_pairs"] == 0


def test_what_was_said_before_its_node_knew_the_time_is_dated_by_the_bag(tmp_path):
    from rclpy.serialization import serialize_message

    topics = toy_mission.bag_topics()
    number = {topic.name: index for index, topic in enumerate(topics)}
    writer = BagWriter(tmp_path / "bag", topics, run_info={})
    start = toy_mission.START_NS
    for name, message in toy_mission.messages(end_s=0.0):
        if name in {"/mission/state", "/mu2/status"} and message.header.stamp.sec:
            unset = type(message)(**({"mu": 2} if name == "/mu2/status" else {"mu_count": 8}))
            writer.write(number[name], start, start, 0, serialize_message(unset))
        writer.write(number[name], start, start, 0, serialize_message(message))
    writer.close()
    data = load(open_bag(tmp_path))
    assert data.origin_ns == start
    assert data.phases[0].phase.name == "WAITING"
    assert all(change.time_ns == start for change in data.phases)
    assert data.mus[2].fuel.stamps.tolist() == [start, start]


def test_another_robots_bag_is_told(tmp_path, capsys):
    topic = BagTopic("/camera", installed_type("std_msgs/msg/String").message_type, qos_profiles(latched=False))
    writer = BagWriter(tmp_path / "bag", [topic], run_info={})
    writer.write(0, 1, 1, 1, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00\x00\x00")
    writer.close()
    status, _, err = analyse(capsys, tmp_path)
    assert status == 1
    assert "holds no mission" in err
    assert "/camera" in err


def test_a_topic_of_another_type_is_told(tmp_path, coarse, capsys):
    toy_mission.write_bag(tmp_path / "good" / "bag", end_s=1.0)
    topics = [
        BagTopic("/mu1/odom", installed_type("std_msgs/msg/String").message_type, qos_profiles(latched=False)),
        *toy_mission.bag_topics()[:4],
    ]
    writer = BagWriter(tmp_path / "bag", topics, run_info={})
    names = [topic.name for topic in toy_mission.bag_topics()]
    for index, stamp, data in toy_mission.serialized(8, 1.0):
        if names[index] == "/debris/odom":
            writer.write(4, stamp, stamp, 0, data)
    writer.write(0, 1, 1, 1, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00\x00\x00")
    writer.close()
    status, out, _ = analyse(capsys, tmp_path, "--output", tmp_path / "out")
    assert status == 0
    assert "/mu1/odom: 1 messages do not fit their type" in out


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda p: None, "does not exist"),
        (lambda p: p.write_bytes(b""), "is empty"),
        (lambda p: p.write_text("no bag"), "is no MCAP file"),
        (lambda p: p.mkdir(), "holds no bag"),
    ],
)
def test_no_bag_is_told(tmp_path, capsys, make, expected):
    make(tmp_path / "thing")
    status, out, err = analyse(capsys, tmp_path / "thing")
    assert (status, out) == (1, "")
    assert err.startswith("analyse_mission.py: ")
    assert expected in err


def test_a_bag_without_messages_is_told(tmp_path, capsys):
    BagWriter(tmp_path / "bag", toy_mission.bag_topics(), run_info={}).close()
    status, _, err = analyse(capsys, tmp_path)
    assert status == 1
    assert "not one message is in" in err


def test_an_output_that_cannot_be_written_is_told(run, tmp_path, capsys):
    (tmp_path / "file").write_text("in the way")
    status, _, err = analyse(capsys, run, "--output", tmp_path / "file")
    assert status == 1
    assert "give another folder with --output" in err


def test_the_default_output_is_in_the_runs_folder(tmp_path):
    (tmp_path / "run" / "bag").mkdir(parents=True)
    file = tmp_path / "run" / "bag" / "bag_0.mcap"
    file.touch()
    expected = tmp_path / "run" / "analysis"
    assert (
        default_output(tmp_path / "run") == default_output(tmp_path / "run" / "bag") == default_output(file) == expected
    )


def test_a_bag_in_a_folder_of_another_encoding_as_a_process(run, tmp_path):
    folder = tmp_path / os.fsdecode(b"caf\xe9\n") / "bag"
    shutil.copytree(run / "bag", folder)
    command = [sys.executable, "-m", "tethernet_bringup.analysis.command_line", str(folder.parent)]
    for more in (["--no-plots", "--json"], ["--salvage"]):
        environment = os.environ | {"LC_ALL": "C"}
        done = subprocess.run([*command, *more], capture_output=True, text=True, check=False, env=environment)
        assert (done.returncode, done.stderr) == (0, "")
    assert (folder.parent / "analysis" / "analysis.json").is_file()


@pytest.mark.parametrize("words", [[], ["a", "b"], ["a", "--format", "bmp"], ["a", "--outptu", "x"]])
def test_bad_usage_ends_with_2(words, capsys):
    with pytest.raises(SystemExit) as caught:
        parse(words)
    assert caught.value.code == 2
    assert main(words) == 2
    assert "usage: analyse_mission.py" in capsys.readouterr().err


def test_neither_ros_nor_the_simulator_is_loaded(run, tmp_path):
    """Whoever gets a bag by mail can look at it."""
    code = (
        "import sys; from tethernet_bringup.analysis.command_line import main; "
        f"assert main([{str(run)!r}, '--output', {str(tmp_path)!r}]) == 0; "
        "loaded = {name.partition('.')[0] for name in sys.modules}; "
        "assert not loaded & {'rclpy', 'tethernet_sim', 'tethernet_msgs', 'nav_msgs', 'numba', 'scipy'}, loaded"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_help_as_a_process():
    command = [sys.executable, "-m", "tethernet_bringup.analysis.command_line", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "exit status: 0 done" in done.stdout
