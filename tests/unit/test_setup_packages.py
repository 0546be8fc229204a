"""What is installed: pinned versions, the project's own packages, the messages."""

from __future__ import annotations

import ast
import importlib.metadata
import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from bootstrap.places import MESSAGE_PACKAGES, PYTHON_PACKAGES, ROOT, venv_places
from bootstrap.steps import MESSAGES

REQUIREMENTS = ROOT / "requirements"
SOURCES = ROOT / "ros2_ws" / "src"
PIN = re.compile(r"([A-Za-z0-9._-]+)==([^=\s]+)")


def pins(name: str) -> dict[str, str]:
    """Packages of a requirements file with their versions; anything but a pin is an error."""
    lines = [
        line for line in (REQUIREMENTS / f"{name}.txt").read_text().splitlines() if line and not line.startswith("#")
    ]
    matches = {line: PIN.fullmatch(line) for line in lines}
    assert all(matches.values()), [line for line, match in matches.items() if not match]
    return {normal(match[1]): match[2] for match in matches.values()}


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


@pytest.mark.parametrize("name", ["installer", "run", "build", "test", "bench", "learning", "cluster"])
def test_all_requirements_are_pinned_as_the_lock_says(name):
    lock = pins("constraints")
    assert {package: lock.get(package) for package in pins(name)} == pins(name)


@pytest.mark.parametrize("name", ["ros-jazzy"])
def test_requirements_of_other_environments_are_pinned(name):
    assert pins(name)


def test_what_is_installed_is_what_the_lock_says():
    if Path(sys.prefix) != venv_places().venv:
        pytest.skip("this Python is not that of the set-up")
    lock = pins("constraints")
    wrong = {
        normal(found.metadata["Name"]): found.version.partition("+")[0]
        for found in importlib.metadata.distributions()
        # The ROS wheels carry more metadata folders, without INSTALLER; the own packages are of no index.
        if found.read_text("INSTALLER")
        and not found.metadata["Name"].startswith("tethernet")
        and lock.get(normal(found.metadata["Name"])) != found.version.partition("+")[0]
    }
    assert not wrong


def test_nothing_clashes():
    checked = subprocess.run(
        [sys.executable, "-m", "pip", "check"], capture_output=True, text=True, check=False, timeout=120
    )
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_colcon_and_pip_are_told_the_same(package):
    folder = SOURCES / package
    manifest = ET.parse(folder / "package.xml").getroot()
    calls = [node for node in ast.walk(ast.parse((folder / "setup.py").read_text())) if isinstance(node, ast.Call)]
    setup = next(call for call in calls if getattr(call.func, "id", "") == "setup")
    told = {word.arg: word.value for word in setup.keywords}
    assert manifest.findtext("name") == package
    assert manifest.findtext("version") == ast.literal_eval(told["version"])
    assert manifest.findtext("license") == ast.literal_eval(told["license"]) == "Apache-2.0"
    assert manifest.findtext("export/build_type") == "ament_python"
    assert (folder / "resource" / package).exists()
    for script in ast.literal_eval(told["entry_points"])["console_scripts"]:
        module, function = script.split(" = ")[1].split(":")
        path = folder / Path(*module.split(".")).with_suffix(".py")
        assert path.exists(), f"{script}: no {path}"
        assert re.search(rf"^def {function}\(", path.read_text(), re.MULTILINE), script


def test_packages_depend_on_each_other_in_one_direction():
    for number, package in enumerate(PYTHON_PACKAGES):
        manifest = ET.parse(SOURCES / package / "package.xml").getroot()
        above = set(PYTHON_PACKAGES[number:])
        assert not above & {node.text for node in manifest if node.tag.endswith("depend")}, package


def test_all_message_files_are_built():
    for folder in venv_places().message_sources:
        text = (folder / "CMakeLists.txt").read_text()
        files = {str(path.relative_to(folder)) for path in folder.glob("*/*") if path.suffix in (".msg", ".srv")}
        assert files == set(re.findall(r'"((?:msg|srv)/\w+\.(?:msg|srv))"', text))
        assert ET.parse(folder / "package.xml").getroot().findtext("name") in MESSAGE_PACKAGES


def test_messages_are_built_again_when_a_message_changes(tmp_path):
    places = venv_places()
    copy = type(places)(tmp_path, tmp_path / ".venv")
    for folder, target in zip(places.message_sources, copy.message_sources, strict=True):
        shutil.copytree(folder, target)
    before = MESSAGES.fingerprint(copy)
    assert before == MESSAGES.fingerprint(places)
    (copy.message_sources[0] / "msg" / "MuStatus.msg").open("a").write("bool another\n")
    assert MESSAGES.fingerprint(copy) != before


def test_the_fallback_never_meets_a_real_tf2_msgs():
    assert (ROOT / "ros2_ws" / "fallback" / "COLCON_IGNORE").exists(), "a colcon build of the workspace must not see it"
    assert not (SOURCES / "tf2_msgs").exists()


def test_the_fallback_is_the_real_type():
    tf2_msgs = pytest.importorskip("tf2_msgs")
    from rosbags.typesys import Stores, get_typestore

    described = next(Path(tf2_msgs.__file__).parents[4].glob("share/tf2_msgs/msg/TFMessage.json"))
    hashes = {entry["type_name"]: entry["hash_string"] for entry in json.loads(described.read_text())["type_hashes"]}
    # rosbags computes it from the definition as ROS 2 Jazzy ships it.
    assert hashes["tf2_msgs/msg/TFMessage"] == get_typestore(Stores.ROS2_JAZZY).hash_rihs01("tf2_msgs/msg/TFMessage")


def test_messages_travel():
    import rclpy.serialization

    from tethernet_msgs.msg import NetState

    state = NetState(rows=1, columns=2, knot_positions=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], locked=[True, False])
    assert rclpy.serialization.deserialize_message(rclpy.serialization.serialize_message(state), NetState) == state
