"""A mission's bag, read as RViz, Foxglove, Lichtblick and PlotJuggler do, with the layouts shipped for them."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Nodetype

import tethernet_bringup
from tests import foreign_bags, rviz_rules
from tests.ros.mission_command import MissionCommand
from tests.ros.test_mission_faults import LOCKSTEP, short
from tethernet_bringup.analysis.command_line import main as analyse

pytestmark = pytest.mark.ros

CONFIG = Path(tethernet_bringup.__file__).parent.parent / "config"
FLOWN_S = 3.0
CONTROL_PERIOD_S, MARKERS_EVERY = 0.05, 10
RVIZ_TYPES = {
    "rviz_default_plugins/MarkerArray": "visualization_msgs/msg/MarkerArray",
    "rviz_default_plugins/PointCloud2": "sensor_msgs/msg/PointCloud2",
    "rviz_default_plugins/Odometry": "nav_msgs/msg/Odometry",
}
WITHOUT_TOPIC = {"rviz_default_plugins/Grid", "rviz_default_plugins/TF"}


@pytest.fixture(scope="module")
def run(tmp_path_factory, module_domain_id):
    """The run's folder of a mission that is given up after some seconds."""
    folder = tmp_path_factory.mktemp("viewed")
    with MissionCommand(folder / "runs", module_domain_id, *LOCKSTEP, *short(folder, FLOWN_S)) as mission:
        assert mission.finish() == 3, mission.text
        return mission.run


@pytest.fixture(scope="module")
def bag(run):
    """Types by topic, decoded messages with their time by topic, fields of types, offered quality of service."""
    with AnyReader([run / "bag"]) as reader:
        found = {connection.topic: [] for connection in reader.connections}
        for connection, time_ns, raw in reader.messages():
            found[connection.topic].append((time_ns, reader.deserialize(raw, connection.msgtype)))
        return SimpleNamespace(
            types={connection.topic: connection.msgtype for connection in reader.connections},
            messages=found,
            fields=dict(reader.typestore.fielddefs),
            qos={connection.topic: connection.ext.offered_qos_profiles[0] for connection in reader.connections},
        )


def stamp_ns(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def leaf(bag, topic, path):
    """The kind of what a path of fields leads to in the messages of a topic; None where it leads nowhere."""
    kind = bag.types.get(topic)
    for name in path:
        field = dict(bag.fields[kind][1]).get(name) if kind else None
        if field is None:
            return None
        kind = field[1] if field[0] == Nodetype.NAME else None
        last = field
    return last[1][0] if last[0] == Nodetype.BASE else None


def test_rviz_has_nothing_to_say_of_any_marker(bag):
    arrays = [message for _, message in bag.messages["/net/markers"]]
    assert len(arrays) >= FLOWN_S / (CONTROL_PERIOD_S * MARKERS_EVERY)
    assert {name for array in arrays for name in rviz_rules.array_warnings(array.markers)} == set()
    assert {tuple(marker.ns for marker in array.markers) for array in arrays} == {
        ("net", "debris", "chaser", "unit_threads", "units", "tether")
    }
    lifetimes = {marker.lifetime.sec + 1e-9 * marker.lifetime.nanosec for array in arrays for marker in array.markers}
    assert lifetimes == {10 * MARKERS_EVERY * CONTROL_PERIOD_S}


def test_all_frames_are_connected_in_one_tree(bag):
    transforms = [transform for _, message in bag.messages["/tf"] for transform in message.transforms]
    parents = rviz_rules.tree((transform.header.frame_id, transform.child_frame_id) for transform in transforms)
    assert set(parents) == {"net", "debris", "chaser", *(f"mu{mu}" for mu in range(1, 9))}
    assert {rviz_rules.root(parents, frame) for frame in parents} == {"launch"}
    assert all(rviz_rules.is_normalised(transform.transform.rotation) for transform in transforms)
    named = {
        (topic, frame)
        for topic, messages in bag.messages.items()
        for _, message in messages
        for frame in rviz_rules.frames(message)
    }
    assert {frame for topic, frame in named if topic != "/diagnostics"} == {"launch", *parents}
    assert {frame for topic, frame in named if topic == "/diagnostics"} <= {"", "launch"}, "they are at no place"


def test_points_are_the_knots_of_the_net_at_the_same_time(bag):
    states = {stamp_ns(message): message for _, message in bag.messages["/net/state"]}
    clouds = [message for _, message in bag.messages["/net/points"]]
    assert len(clouds) == len(bag.messages["/net/markers"])
    for cloud in clouds:
        state = states[stamp_ns(cloud)]
        count = len(state.knot_positions) // 3
        assert cloud.header.frame_id == "launch"
        assert (cloud.height, cloud.width, cloud.point_step, cloud.row_step) == (1, count, 12, 12 * count)
        assert (cloud.is_dense, cloud.is_bigendian) == (True, False)
        assert [(f.name, f.offset, f.datatype, f.count) for f in cloud.fields] == [
            ("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1),
        ]  # fmt: skip
        assert np.array_equal(np.frombuffer(cloud.data.tobytes(), "<f4"), state.knot_positions)


def test_every_topic_of_the_rviz_configuration_is_there_with_its_type(bag):
    config = yaml.safe_load((CONFIG / "tethernet.rviz").read_text())["Visualization Manager"]
    frames = {"launch"} | {t.child_frame_id for _, message in bag.messages["/tf"] for t in message.transforms}
    assert config["Global Options"]["Fixed Frame"] in frames
    assert config["Views"]["Current"]["Target Frame"] in frames
    shown = set()
    for display in config["Displays"]:
        if display["Class"] in WITHOUT_TOPIC:
            continue
        topic = display["Topic"]
        assert bag.types[topic["Value"]] == RVIZ_TYPES[display["Class"]]
        offered = bag.qos[topic["Value"]]
        assert offered.reliability.name == "RELIABLE"
        if topic["Durability Policy"] == "Transient Local":
            assert offered.durability.name == "TRANSIENT_LOCAL", "RViz would hear nothing"
        shown |= {topic["Value"]} if display["Enabled"] else set()
    assert shown == {"/net/markers", "/net/points"}


def panels_of(layout):
    return [layout] if isinstance(layout, str) else panels_of(layout["first"]) + panels_of(layout["second"])


def test_every_topic_and_field_of_the_foxglove_layout_is_there(bag):
    layout = json.loads((CONFIG / "foxglove.json").read_text())
    panels = layout["configById"]
    assert sorted(panels_of(layout["layout"])) == sorted(panels)
    kinds, paths = {}, []
    for name, panel in panels.items():
        kinds.setdefault(name.partition("!")[0], []).append(panel)
        paths += [path["value"] for path in panel.get("paths", ())]
    for path in paths:
        topic, *fields = path.split(".")
        assert leaf(bag, topic, fields) not in (None, "string"), path
    [scene] = kinds["3D"]
    assert scene["followTf"] == "launch"
    drawable = {"visualization_msgs/msg/MarkerArray", "sensor_msgs/msg/PointCloud2", "nav_msgs/msg/Odometry"}
    assert {bag.types[topic] for topic in scene["topics"]} <= drawable
    assert bag.types[kinds["RawMessages"][0]["topicPath"]] == "tethernet_msgs/msg/CaptureAssessment"
    assert bag.types[kinds["DiagnosticSummary"][0]["topicToRender"]] == "diagnostic_msgs/msg/DiagnosticArray"
    assert len(paths) > 20


def test_every_curve_of_the_plotjuggler_layout_is_there(bag):
    root = ElementTree.parse(CONFIG / "plotjuggler.xml").getroot()
    curves = [curve.get("name") for curve in root.iter("curve")]
    topics = set()
    for curve in curves:
        topic = next(name for name in bag.types if curve.startswith(name + "/"))
        assert leaf(bag, topic, curve.removeprefix(topic + "/").split("/")) not in (None, "string"), curve
        topics.add(topic)
    assert len(curves) > 30
    for plugin in root.iter("plugin"):
        assert set(plugin.find("selected_topics").get("value").split(";")) == topics
        assert plugin.find("use_header_stamp").get("value") == "true"


def test_the_layouts_are_installed_with_the_package():
    """As colcon installs it: ``ros2 pkg prefix --share tethernet_bringup`` is where people look."""
    code = (
        "import setuptools, json; setuptools.setup = lambda **words: print(json.dumps(words['data_files'])); "
        "exec(compile(open('setup.py').read(), 'setup.py', 'exec'))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=CONFIG.parent, capture_output=True, text=True, check=True)
    installed = dict(json.loads(done.stdout))
    shipped = {f"config/{path.name}" for path in CONFIG.iterdir()}
    assert shipped
    assert shipped <= set(installed["share/tethernet_bringup/config"])


def test_a_recorded_mission_that_others_have_converted_gives_the_same_table(run, tmp_path, capsys):
    def table(bag):
        assert analyse([str(bag), "--no-plots"]) == 0
        lines = capsys.readouterr().out.splitlines()[1:]
        return [line.replace("none lost on the way", "what was lost on the way is not counted") for line in lines]

    original = run / "bag"
    expected = table(original)
    assert not any(line.startswith("note:") for line in expected)
    assert table(foreign_bags.by_rosbags(original, tmp_path / "s", log_time=foreign_bags.wall_clock)) == expected
    stock = foreign_bags.compress_files(foreign_bags.by_stock_recorder(original, tmp_path / "m", parts=2), ".zstd")
    assert table(stock)[1:-2] == expected[1:], "what is left are the facts, and the note that says so"
