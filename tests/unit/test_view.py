"""What --view takes, what is drawn, and that whoever draws may stand still."""

import dataclasses
import itertools
import sys
import threading

import numpy as np
import pytest
from geometry_msgs.msg import Point

from tests import toy_mission
from tests.rerun_file import read
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.mission import arguments as mission_arguments
from tethernet_bringup.mission import command_line as mission_command
from tethernet_bringup.view import application, command_line
from tethernet_bringup.view.arguments import FILE, WEB, WINDOW, parse, view_target
from tethernet_bringup.view.observer import DEBRIS, Observer
from tethernet_bringup.view.snapshot import Event, Newest
from tethernet_bringup.view.strands import strands
from tethernet_core.shapes import shape_from
from tethernet_core.system import load_system, shipped_systems
from tethernet_msgs.msg import CaptureAssessment, MissionState

HOLD_S = 2.0
BOX = {"kind": "box", "size_m": [1.0, 2.0, 3.0]}
SHAPES = [
    {"kind": "cylinder", "radius_m": 1.0, "length_m": 4.0},
    BOX,
    {"kind": "sphere", "radius_m": 1.5},
    {"kind": "capsule", "radius_m": 0.5, "length_m": 2.0},
    {"kind": "cone", "base_radius_m": 1.0, "top_radius_m": 0.3, "length_m": 2.0},
    {"kind": "compound", "parts": [{"shape": BOX}, {"shape": BOX, "position_m": [2.0, 0.0, 0.0]}]},
]


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("screen", "screen: cannot be meant; allowed: window, web, or the name of a file that ends in .rrd"),
        (".rrd", "cannot be meant"),
        ("", "cannot be meant"),
        ("flight.mp4", "flight.mp4: cannot be meant"),
        ("nowhere/flight.rrd", "its folder does not exist"),
        ("folder.rrd", "is a folder"),
        ("x\0.rrd", "can be no file's name"),
        ("x" * 300 + ".rrd", "…"),
    ],
)
def test_views_that_cannot_be_meant_are_refused_before_anything_begins(tmp_path, monkeypatch, capsys, word, hint):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.rrd").mkdir()
    for command in (mission_arguments.parse, parse):
        with pytest.raises(SystemExit) as ended:
            command((["."] if command is parse else []) + ["--view", word])
        assert ended.value.code == 2
        assert hint in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["folder.rrd"]


def test_views_that_can_be_meant(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert mission_arguments.parse([]).view is None
    assert view_target(mission_arguments.parse(["--view"]).view).kind == WINDOW
    assert view_target(mission_arguments.parse(["--view", "web"]).view).kind == WEB
    assert view_target(mission_arguments.parse(["--view", "a.rrd"]).view) == (FILE, tmp_path / "a.rrd")
    assert parse(["runs/RUN"]).view.kind == WINDOW
    assert parse(["runs/RUN", "--view", "a.rrd"]).view == (FILE, tmp_path / "a.rrd")


def test_without_rerun_one_sentence_says_what_installs_it_and_nothing_is_begun(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "rerun", None)
    monkeypatch.chdir(tmp_path)
    assert mission_command.main(["--view", "a.rrd"]) == command_line.main([str(tmp_path), "--view", "a.rrd"]) == 1
    said = capsys.readouterr()
    for line in said.err.splitlines():
        assert "needs rerun, not installed here; python3 -m bootstrap view installs it, and so does make view" in line
    assert (said.out, said.err.count("\n")) == ("", 2)
    assert list(tmp_path.iterdir()) == []


def test_a_window_needs_a_display(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(application, "require", lambda *_: None)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    assert mission_command.main(["--view"]) == command_line.main(["."]) == 2
    assert capsys.readouterr().err.count("allowed here: --view web, --view FILE.rrd") == 2
    assert list(tmp_path.iterdir()) == []


def test_who_draws_may_stand_still_and_words_are_not_lost():
    snapshot = Observer(load_system("zenit_4mu")).snapshot()
    newest = Newest()
    for number in range(100):  # nobody takes any of them, and nothing waits
        newest.put(dataclasses.replace(snapshot, time_ns=number, events=(Event(number, f"event {number}"),)))
    taken = newest.take()
    assert (taken.time_ns, newest.dropped) == (99, 99)
    assert [event.text for event in taken.events] == [f"event {number}" for number in range(100)]
    waiting = threading.Thread(target=newest.take, daemon=True)
    waiting.start()
    newest.close()
    waiting.join(10.0)
    assert not waiting.is_alive()
    assert newest.take() is None


@pytest.mark.parametrize("name", shipped_systems())
def test_strands_hold_every_thread_once(name):
    net = load_system(name).net
    found = strands(net.threads, net.nodes)
    steps = [tuple(sorted(step)) for strand in found for step in itertools.pairwise(strand.tolist())]
    assert len(steps) == net.thread_count
    assert set(steps) == {tuple(sorted(ends)) for ends in net.threads.tolist()}
    assert sum(map(len, found)) < 1.7 * net.thread_count, "shorter than thread by thread"


def test_another_systems_messages_are_not_taken():
    observer = Observer(load_system("zenit_4mu"))
    with pytest.raises(ValueError, match="allowed: those of zenit_4mu"):
        observer.net(1, (0, 0, 0), np.zeros((5, 3)), np.zeros((4, 3)), [False] * 12)
    assert observer.newest_ns == 0


@pytest.mark.parametrize("measured", [False, True])
def test_one_stamp_from_the_future_does_not_hold_the_pictures_up(measured):
    """Of the net, and of a driver where nothing measures the net."""
    observer = Observer(load_system("zenit_4mu"))
    net = np.zeros((observer.system.net.node_count, 3))

    def tell(stamp_ns):
        if measured:
            observer.net(stamp_ns, (0.0, 0.0, 0.0), net, np.zeros((4, 3)), [False] * 12)
        else:
            observer.unit(2, stamp_ns, (0.0, 0.0, 0.0))

    for tick in range(20, 60):
        tell(tick * 50_000_000)
        if tick == 40:
            tell(10**18)
        assert observer.newest_ns == tick * 50_000_000


def test_closing_points_take_the_place_of_aiming_points():
    observer = Observer(load_system("zenit_4mu"))
    point = Point(x=1.0, y=2.0, z=-52.0)
    state = MissionState(mu_count=4, phase=MissionState.CLOSING, closing_points=[point, point, Point(z=-52.0), point])
    state.launch_time.sec, state.closing_time.sec = 2, 12
    for phase, aims, meets in ((MissionState.DEPLOYING, 4, 0), (MissionState.CLOSING, 0, 2)):
        observer.state(MissionState(mu_count=4, phase=phase) if meets == 0 else state)
        snapshot = observer.snapshot()
        assert (len(snapshot.aiming_points), len(snapshot.closing_points)) == (aims, meets)
    assert [(event.text, event.time_ns) for event in snapshot.events] == [("CLOSING", 10_000_000_000)]
    with pytest.raises(ValueError, match="8 units; allowed: those of zenit_4mu"):
        observer.state(MissionState(mu_count=8))


def test_before_the_launch_all_times_are_zero():
    observer = Observer(load_system("zenit_4mu"))
    observer.unit(3, 5_000_000_000, (1.0, 2.0, 3.0))
    observer.body(DEBRIS, 5_000_000_000, (0.0, 0.0, -50.0), (0.0, 0.0, 0.0, 1.0))
    snapshot = observer.snapshot()
    assert (snapshot.time_ns, observer.launched) == (0, False)
    assert snapshot.units[2].tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(snapshot.units[[0, 1, 3]]).all()
    assert np.isnan(snapshot.distance), "nothing has measured the net"


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """A pretended mission with a hold test, shown from its bag: the bag's folder and what was recorded of it."""
    pytest.importorskip("rerun")
    folder = tmp_path_factory.mktemp("view")
    toy_mission.write_bag(folder / "run" / "bag", end_s=toy_mission.end_of_hold(HOLD_S), hold_s=HOLD_S)
    output = folder / "flight.rrd"
    assert command_line.main([str(folder / "run"), "--view", str(output)]) == 0
    return folder / "run", read(output)


PLOTS = {f"/plots/{name}" for name in ("distance", "tracking_error", "thrust", "fuel", "cqi", "locked_pairs")}
ENTITIES = PLOTS | {
    "/events", "/scene", "/scene/debris", "/scene/debris/shape", "/scene/chaser", "/scene/chaser/shape",
    "/scene/tether", "/scene/net/threads", "/scene/net/knots", "/scene/net/locked", "/scene/units",
    "/scene/units/threads", "/scene/units/thrust", "/scene/aiming", "/scene/closing",
}  # fmt: skip
"""Of a mission with units that dock."""


def test_all_of_a_bag_is_shown_at_its_times(shown):
    _, found = shown
    assert set(found) == ENTITIES
    end_ns = round(toy_mission.end_of_hold(HOLD_S) * 1e9)
    for name in ("/scene/units", "/scene/net/threads", "/scene/debris", "/plots/distance", "/plots/thrust"):
        times = found[name].times_ns
        assert times[0] == 0 and times[-1] == pytest.approx(end_ns, abs=60_000_000), name
        assert set(np.diff(times)) == {50_000_000}, f"{name}: every tick"
    texts = {row["text"][0]: time_ns for time_ns, row in found["/events"].rows}
    assert texts["DEPLOYING"] == 0
    assert texts["CLOSING"] == pytest.approx(toy_mission.TRIGGER_S * 1e9)
    assert {"HOLDING", "COMPLETE"} <= set(texts)
    assert any(text.startswith("captured: CQI 0.90") for text in texts)


def test_what_is_shown_is_what_was_recorded(shown):
    _, found = shown
    system = load_system("zenit_8mu")
    time_s = found["/scene/units"].times_ns[200] * 1e-9
    row = dict(found["/scene/units"].rows)[found["/scene/units"].times_ns[200]]
    expected = [toy_mission.true_position(mu, time_s) for mu in range(1, 9)]
    np.testing.assert_allclose(row["positions"], expected, atol=1e-5)
    assert row["labels"] == [str(mu) for mu in range(1, 9)]
    strips = found["/scene/net/threads"].last("strips")
    assert sum(len(strip) - 1 for strip in strips) == system.net.thread_count
    assert len(found["/plots/fuel"].last("scalars")) == len(found["/scene/units/thrust"].last("vectors")) == 8
    assert found["/plots/locked_pairs"].last("scalars") == [8.0]
    assert len(found["/scene/net/locked"].last("strips")) == 8
    assert found["/plots/fuel"].last("names") == [f"MU {mu}" for mu in range(1, 9)]
    assert len(found["/scene/aiming"].rows[0][1]["positions"]) == 8
    assert found["/scene/aiming"].last("positions") == [], "not any more, once the net closes"


def test_a_bag_that_is_none_and_a_system_that_it_is_not_are_told(shown, tmp_path, capsys):
    run, _ = shown
    output = tmp_path / "a.rrd"
    assert command_line.main([str(tmp_path), "--view", str(output)]) == 1
    assert "holds no bag" in capsys.readouterr().err
    assert command_line.main([str(run), "--view", str(output), "--system", "zenit_9mu"]) == 2
    assert "zenit_9mu" in capsys.readouterr().err
    assert not output.exists()
    assert command_line.main([str(run), "--view", str(output), "--system", "zenit_4mu"]) == 0
    assert "messages could not be used" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["passive_5m", "envisat_8mu", "hexagonal_6mu", "zenit_8mu_winch"])
def test_any_system_is_drawn(tmp_path, name):
    rerun = pytest.importorskip("rerun")
    from tethernet_bringup.view.drawing import Drawing
    from tethernet_bringup.view.recording import close, open_recording

    system, output = load_system(name), tmp_path / "a.rrd"
    observer = Observer(system)
    units = np.array([system.net.nodes[unit.node] for unit in system.units]).reshape(-1, 3)
    locked = np.arange(system.closing.max_locked_pairs) % 2 == 0
    observer.net(10, (0.0, 0.0, 0.0), system.net.nodes, units, locked)
    observer.body(DEBRIS, 10, (0.0, 0.0, -9.0), (0.0, 0.0, 0.0, 1.0))
    rerun.set_strict_mode(True)  # errors instead of warnings
    try:
        recording = open_recording(str(output), name)
        Drawing(recording, system).draw(observer.snapshot())
        close(recording, str(output))
    finally:
        rerun.set_strict_mode(False)
    found = read(output)
    assert sum(len(strip) - 1 for strip in found["/scene/net/threads"].last("strips")) == system.net.thread_count
    assert ("/scene/units" in found) == bool(system.units)
    assert ("/scene/net/masses" in found) == bool(system.net.point_masses)
    assert ("/plots/locked_pairs" in found) == bool(system.closing.ring)
    assert found["/plots/distance"].last("scalars") == [9.0]
    if system.closing.ring:
        assert len(found["/scene/net/locked"].last("strips")) == np.count_nonzero(locked)


@pytest.mark.parametrize("described", SHAPES, ids=lambda described: described["kind"])
def test_debris_of_any_shape_is_drawn_where_its_centre_of_mass_is(tmp_path, described):
    pytest.importorskip("rerun")
    from tethernet_bringup.view.drawing import Drawing
    from tethernet_bringup.view.recording import close, open_recording

    system, output = load_system("zenit_4mu"), tmp_path / "a.rrd"
    center = np.array([0.1, -0.2, 0.3])
    debris = dataclasses.replace(system.debris, shape=shape_from(described), center_of_mass=center)
    recording = open_recording(str(output), "debris")
    Drawing(recording, dataclasses.replace(system, debris=debris))
    close(recording, str(output))
    vertices, faces = debris.shape.triangles()
    drawn = np.array(read(output)["/scene/debris/shape"].last("vertex_positions")).reshape(-1, 3, 3)
    np.testing.assert_allclose(drawn, vertices[faces] - center, atol=1e-5)


def test_the_bag_is_only_read(shown):
    run, _ = shown
    assert list(open_bag(run).messages()), "and still whole"
    assert sorted(path.name for path in run.rglob("*")) == ["bag", "bag_0.mcap", "metadata.yaml"]


@pytest.mark.parametrize(
    ("phase", "hold_s", "stages", "ended"),
    [
        (MissionState.CLOSING, 0.0, [2], False),
        (MissionState.COMPLETE, 0.0, [1], False),
        (MissionState.COMPLETE, 0.0, [2], True),
        (MissionState.COMPLETE, 60.0, [2], False),
        (MissionState.COMPLETE, 60.0, [2, 3], True),
        (MissionState.MISSED, 60.0, [2], True),
        (MissionState.ABORTED, 60.0, [], True),
    ],
)
def test_it_knows_when_all_has_been_told(phase, hold_s, stages, ended):
    observer = Observer(load_system("zenit_4mu"))
    assert not observer.ended
    observer.state(MissionState(mu_count=4, phase=phase, hold_duration=hold_s))
    for stage in stages:
        observer.assessment(CaptureAssessment(stage=stage))
    assert observer.ended == ended
