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

from bootstrap import pins as locks
from bootstrap import steps
from bootstrap.clashes import clashes, normal, own_packages
from bootstrap.places import MESSAGE_PACKAGES, PYTHON_PACKAGES, ROOT, Places, venv_places
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


@pytest.mark.parametrize("name", ["installer", "run", "build", "test", "bench", "learning", "cluster", "ros2cli"])
def test_all_requirements_are_pinned_as_the_lock_says(name):
    lock = pins("constraints")
    assert {package: lock.get(package) for package in pins(name)} == pins(name)


def test_a_lock_has_the_version_that_an_index_knows_of_each_package():
    versions = {"torch": "2.13.0+cpu", "PyYAML": "6.0.3", "ros_jazzy.rclpy": "7.1.6"}
    report = {"install": [{"metadata": {"name": name, "version": found}} for name, found in versions.items()]}
    assert locks.lines(report) == ["pyyaml==6.0.3", "ros-jazzy-rclpy==7.1.6", "torch==2.13.0"]


def test_what_shows_missions_adds_no_package_that_is_not_pinned():
    pytest.importorskip("rerun")
    lines = [line for name in pins("view") for line in importlib.metadata.requires(name) or ()]
    needed = {normal(re.match(r"[\w.-]+", line)[0]) for line in lines if "extra ==" not in line}
    assert needed <= set(pins("constraints") | pins("view"))


@pytest.mark.parametrize("name", ["ros-jazzy"])
def test_requirements_of_other_environments_are_pinned(name):
    assert pins(name)


def differing(lock: dict[str, str], installed: dict[str, str]) -> dict[str, str]:
    """What is installed in another version than the lock names. What it does not name is the user's own business."""
    return {name: version for name, version in installed.items() if lock.get(name, version) != version}


def test_what_is_installed_is_what_the_lock_says():
    if Path(sys.prefix) != venv_places().venv:
        pytest.skip("this Python is not that of the set-up")
    installed = {
        normal(found.metadata["Name"]): found.version.partition("+")[0]
        for found in importlib.metadata.distributions()
        # The ROS wheels carry more metadata folders, without INSTALLER.
        if found.read_text("INSTALLER")
    }
    assert differing(pins("constraints"), installed) == {}
    assert set(pins("run")) <= set(installed), "what a mission needs is there"


def test_the_lock_is_held_against_what_it_names_and_nothing_else():
    lock = {"numpy": "2.4.6", "scipy": "1.17.1"}
    assert differing(lock, {"numpy": "2.4.6", "ros2cli": "0.32.9"}) == {}, "a user may install more"
    assert differing(lock, {"numpy": "2.4.5", "ros2cli": "0.32.9"}) == {"numpy": "2.4.5"}


def test_nothing_clashes():
    checked = subprocess.run(
        [sys.executable, "-m", "pip", "check"], capture_output=True, text=True, check=False, timeout=120
    )
    assert clashes(checked.stdout, own_packages(REQUIREMENTS.glob("*.txt"))) == []
    assert checked.returncode in (0, 1), checked.stderr


def test_only_clashes_of_own_packages_count():
    said = "numba 0.68.1 has requirement numpy<2.5, but you have numpy 2.6.\nros2cli 0.32 requires argcomplete"
    assert clashes(said, {"numba", "numpy"}) == ["numba 0.68.1 has requirement numpy<2.5, but you have numpy 2.6."]
    assert clashes("No broken requirements found.", {"numba"}) == []


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
    scripts = ast.literal_eval(told["entry_points"])["console_scripts"] if "entry_points" in told else []
    for script in scripts:
        module, function = script.split(" = ")[1].split(":")
        path = folder / Path(*module.split(".")).with_suffix(".py")
        assert path.exists(), f"{script}: no {path}"
        assert re.search(rf"^def {function}\(", path.read_text(), re.MULTILINE), script


ROSDEP = {
    "matplotlib": "python3-matplotlib",
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "tqdm": "python3-tqdm",
    "trimesh": "python3-trimesh-pip",
    "yaml": "python3-yaml",
}
"""Keys that rosdep has, by the name of the import."""
PIP_ONLY = {"lz4", "mcap", "pyarrow", "safetensors", "zstandard"}
"""For these rosdep has none; package.xml says so in words."""
EXTRAS = {
    "learning": {"cma", "gymnasium", "sklearn", "stable_baselines3", "torch"},
    "cluster": {"ray"},
    "view": {"rerun"},
}
"""What a mission never imports."""
DISTRIBUTION = {
    "rerun": "rerun-sdk",
    "sklearn": "scikit-learn",
    "stable_baselines3": "stable-baselines3",
    "yaml": "pyyaml",
}
"""Where pip calls it otherwise."""
COMES_WITH = {"llvmlite": "numba", "mpl_toolkits": "matplotlib"}
"""Imports that another library brings, in the version that fits it."""


def imported(package: str) -> set[str]:
    """What the modules of a package import from outside of it and of the standard library, and which other package's
    messages they name as PACKAGE/msg/TYPE."""
    found = set()
    for path in (SOURCES / package / package).rglob("*.py"):
        text = path.read_text()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(node.module.partition(".")[0])
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                found |= set(re.findall(r"^(\w+)/msg/[A-Z]\w+$", node.value))
    found = {COMES_WITH.get(name, name) for name in found}
    return found - set(sys.stdlib_module_names) - {package, "_typeshed"}  # that one exists for the type checker alone


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_what_is_imported_is_asked_for_and_nothing_else(package):
    """colcon and rosdep read package.xml, pip reads setup.py."""
    text = (SOURCES / package / "package.xml").read_text()
    manifest = ET.fromstring(text)
    asked = {node.text for node in manifest if node.tag in ("depend", "exec_depend")}
    calls = ast.walk(ast.parse((SOURCES / package / "setup.py").read_text()))
    told = {word.arg: word.value for call in calls if isinstance(call, ast.Call) for word in call.keywords}
    needs, extras = imported(package), set.union(*EXTRAS.values())

    libraries = {name for name in needs if name in ROSDEP}
    unknown_to_rosdep = needs & PIP_ONLY
    ros = needs - libraries - PIP_ONLY - extras
    assert asked == ros | {ROSDEP[name] for name in libraries}
    said = re.search(r"rosdep has no key for these, pip installs them: ([^.]*)\.", text)
    assert set(said[1].split(", ") if said else []) == unknown_to_rosdep

    required = set(ast.literal_eval(told["install_requires"]))
    own = needs & set(PYTHON_PACKAGES)
    assert required == own | {DISTRIBUTION.get(name, name) for name in libraries | unknown_to_rosdep}
    offered = ast.literal_eval(told["extras_require"]) if "extras_require" in told else {}
    assert offered["test"] == ["pytest"], "by this colcon knows how to test a package"
    for extra, names in EXTRAS.items():
        assert set(offered.get(extra, [])) == {DISTRIBUTION.get(name, name) for name in needs & names}


@pytest.mark.parametrize("name", ["run", "ros-jazzy"])
def test_requirements_name_what_a_mission_imports_and_nothing_else(name):
    needs = set.union(*map(imported, PYTHON_PACKAGES)) & {*ROSDEP, *PIP_ONLY}
    named = {package for package in pins(name) if not package.startswith("ros-jazzy-")}
    assert named == {normal(DISTRIBUTION.get(library, library)) for library in needs}


def test_every_library_that_is_imported_is_known_here():
    """So that a new one is put into package.xml, setup.py and requirements/ on purpose."""
    known = {*ROSDEP, *PIP_ONLY, *set.union(*EXTRAS.values())}
    ros = {*PYTHON_PACKAGES, "tethernet_msgs", "rclpy", "rosidl_parser"}
    others = set.union(*map(imported, PYTHON_PACKAGES)) - known - ros
    assert {name for name in others if not name.endswith(("_msgs", "_srvs", "_interfaces"))} == set()


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


def test_commands_of_an_earlier_installation_go(tmp_path):
    places = Places(ROOT, tmp_path)
    (tmp_path / "bin").mkdir()
    for name in ("salvage", "check-driver", "python"):
        (tmp_path / "bin" / name).touch()
    listed = tmp_path / "entry_points.txt"
    listed.write_text("[console_scripts]\nsalvage = a.b:main\ncheck-driver = c:main\ngone = d:main\n")
    steps._remove_commands(places, tmp_path)
    assert [path.name for path in (tmp_path / "bin").iterdir()] == ["python"]
    steps._remove_commands(places, tmp_path / "not there")
