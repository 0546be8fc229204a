"""``make ros2cli``: what it says where git or network is missing, what it installs, and that it stays."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from bootstrap import environment, ros2cli, steps
from bootstrap.environment import ensure
from bootstrap.errors import SetupError
from bootstrap.places import ROOT, Places
from bootstrap.report import Report
from bootstrap.state import State, interpreter_of, load
from bootstrap.steps import PROFILES, ROS2CLI, Step
from tests.unit.setup_steps import done, places_in
from tests.unit.setup_steps import steps as toy_steps

NEEDED = {
    "rosidl_runtime_py", "ros2cli", "ros2interface", "ros2node", "ros2param", "ros2pkg", "ros2run", "ros2service",
    "ros2topic",
}  # fmt: skip


def with_files(folder: Path) -> Places:
    """Places in a folder that has the requirements, and what is installed with the stock command."""
    places = places_in(folder)
    shutil.copytree(ROOT / "requirements", places.requirements)
    shutil.copytree(ROOT / "ros2_ws/fallback/ros2cli_wheels", places.ros2cli)
    return places


def lead_git_to(monkeypatch: pytest.MonkeyPatch, address: str, instead_of: str) -> None:
    """git's own way to a mirror."""
    monkeypatch.setenv("GIT_CONFIG_COUNT", "1")
    monkeypatch.setenv("GIT_CONFIG_KEY_0", f"url.{address}.insteadOf")
    monkeypatch.setenv("GIT_CONFIG_VALUE_0", instead_of)


def test_every_source_is_pinned_to_a_commit_and_repositories_agree():
    lines = (ROOT / "requirements" / ros2cli.SOURCES_FILE).read_text().splitlines()
    sources = [line for line in lines if not line.startswith("#")]
    pattern = r"(\w+) @ git\+(https://github\.com/ros2/\w+)@([0-9a-f]{40})(?:#subdirectory=(\w+))?"
    found = [re.fullmatch(pattern, line) for line in sources]
    assert all(found), sources
    assert {match[1] for match in found} == NEEDED
    assert all(match[4] in (None, match[1]) for match in found)
    assert len({(match[2], match[3]) for match in found}) == 2, "one commit a repository"
    assert ros2cli.repositories(places_in(ROOT)) == list(dict.fromkeys(match[2] for match in found))


def test_without_git_it_says_so_and_nothing_is_touched(tmp_path, monkeypatch):
    places = with_files(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path / "nothing"))
    with pytest.raises(SetupError, match=r"git is not found on PATH.* install git.*\n.*docker/README\.md"):
        ensure(places, [*toy_steps(), ROS2CLI], Report(io.StringIO()))
    assert not places.venv.exists()
    assert done(tmp_path) == []


def test_without_network_it_says_so_and_the_environment_is_as_it_was(tmp_path, monkeypatch):
    places = with_files(tmp_path)
    ensure(places, toy_steps(), Report(io.StringIO()))
    before = {path: path.stat().st_mtime_ns for path in places.venv.rglob("*")}
    lead_git_to(monkeypatch, f"file://{tmp_path}/no/network/", "https://github.com/")
    with pytest.raises(SetupError) as raised:
        ensure(places, [*toy_steps(), ROS2CLI], Report(io.StringIO()))
    first, second = str(raised.value).splitlines()
    assert re.fullmatch(
        r"git does not reach https://github\.com/ros2/\w+ \(.+\), and no package index has the ros2 command; "
        rf"{re.escape(str(places.venv))} is as it was\.",
        first,
    )
    assert "insteadOf" in second and "docker/README.md" in second
    assert {path: path.stat().st_mtime_ns for path in places.venv.rglob("*")} == before


def test_the_command_ends_with_a_status_and_no_traceback(tmp_path):
    """As `make ros2cli` starts it, with an empty environment and a git that reaches nobody."""
    mirror = {"GIT_CONFIG_COUNT": "1", "GIT_CONFIG_VALUE_0": "https://github.com/"}
    mirror["GIT_CONFIG_KEY_0"] = f"url.file://{tmp_path}/none/.insteadOf"
    given = {"PATH": os.environ["PATH"], "HOME": str(tmp_path), "TETHERNET_VENV": str(tmp_path / "venv"), **mirror}
    command = [sys.executable, "-m", "bootstrap", *PROFILE_OF_MAKE]
    ended = subprocess.run(command, cwd=ROOT, env=given, capture_output=True, text=True, check=False, timeout=60)
    assert ended.returncode == 1
    assert ended.stderr.startswith("Set-up failed: git does not reach ")
    assert "Traceback" not in ended.stderr
    assert not (tmp_path / "venv").exists()


PROFILE_OF_MAKE = re.search(
    r"^ros2cli:\n\t\$\(SETUP\) (.+)$", (ROOT / "Makefile").read_text(), re.MULTILINE
)[1].split()  # fmt: skip


def test_the_profile_has_the_messages_too():
    assert {"messages", "ros2cli"} <= {step.name for step in PROFILES["ros2cli"]}
    assert not ROS2CLI.installs, "a change of its pins must not cost the environment"
    assert ROS2CLI not in {step for name, profile in PROFILES.items() if name != "ros2cli" for step in profile}


def kept_step(at_hand: bool) -> Step:
    """In the place of the real one: writes a line."""

    def run(places: Places, report: Report) -> None:
        with open(places.root / "journal", "a") as journal:
            journal.write("ros2cli\n")

    return Step("ros2cli", "step ros2cli", lambda places: "1", run, at_hand=lambda places: at_hand)


@pytest.mark.parametrize("at_hand", [True, False])
def test_an_environment_that_is_made_anew_has_it_again_or_says_how(tmp_path, monkeypatch, at_hand):
    kept = kept_step(at_hand)
    monkeypatch.setattr(environment, "KEPT", (kept,))
    places = places_in(tmp_path)
    ensure(places, [*toy_steps(), kept], Report(io.StringIO()))
    ensure(places, toy_steps(), Report(io.StringIO()))
    assert done(tmp_path).count("ros2cli") == 1, "another use of the environment leaves it alone"
    assert "ros2cli" in load(places).done
    (tmp_path / "packages").write_text("other requirements")
    said = io.StringIO()
    ensure(places, toy_steps(), Report(said))
    assert done(tmp_path).count("packages") == 2
    assert done(tmp_path).count("ros2cli") == 1 + at_hand
    assert ("`make ros2cli` installs it anew" in said.getvalue()) is not at_hand


def test_wheels_of_other_sources_are_not_taken(tmp_path):
    places = with_files(tmp_path)
    places.ros2cli_wheels.mkdir()
    (places.ros2cli_wheels / "ros2cli-0-py3-none-any.whl").touch()
    assert ros2cli.wheels(places) == []
    (places.ros2cli_wheels / "built_of").write_text(ros2cli._wanted(places))
    assert [path.name for path in ros2cli.wheels(places)] == ["ros2cli-0-py3-none-any.whl"]
    (places.requirements / ros2cli.SOURCES_FILE).open("a").write("\n# changed\n")
    assert ros2cli.wheels(places) == []


STAND_IN = """
import os, sys
from importlib.metadata import entry_points

def main():
    names = ("AMENT_PREFIX_PATH", "PYTHONPATH", "ROS_DISTRO")
    print(*(f"{name}={os.environ.get(name, '')}" for name in names), *sys.argv[1:], sep="\\n")
    print(sorted(point.name for point in entry_points(group="ros2cli.command")))
"""


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Places:
    """An environment in which a stand-in of the stock command is installed, from a repository on this machine."""
    repository = tmp_path / "upstream"
    for name in ("ros2cli", "ros2topic"):
        folder = repository / name / name
        folder.mkdir(parents=True)
        (folder / "__init__.py").touch()
        script = 'entry_points={"console_scripts": ["ros2 = ros2cli.cli:main"]}' if name == "ros2cli" else ""
        text = f'from setuptools import setup\nsetup(name="{name}", version="0", packages=["{name}"], {script})\n'
        (folder.parent / "setup.py").write_text(text)
    (repository / "ros2cli" / "ros2cli" / "cli.py").write_text(STAND_IN)
    (repository / "ros2cli" / "ros2cli" / "command.py").write_text("class CommandExtension: ...\n")
    author = ["-c", "user.name=test", "-c", "user.email=test@example.invalid"]
    for words in (["init", "-q"], ["add", "."], [*author, "commit", "-q", "-m", "first"]):
        subprocess.run(["git", *words], cwd=repository, check=True)
    commit = subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=repository, text=True).strip()

    places = with_files(tmp_path)
    address = "https://github.com/ros2/ros2cli"
    lines = [f"{name} @ git+{address}@{commit}#subdirectory={name}\n" for name in ("ros2cli", "ros2topic")]
    (places.requirements / ros2cli.SOURCES_FILE).write_text("".join(lines))
    shutil.copytree(ROOT / "bootstrap", tmp_path / "bootstrap", ignore=shutil.ignore_patterns("__pycache__"))
    lead_git_to(monkeypatch, f"file://{repository}", address)
    monkeypatch.setenv("PIP_NO_INDEX", "1")

    venv.create(places.venv, with_pip=False)
    own = next(places.venv.glob("lib/python3.*/site-packages"))
    (own / "of_the_tests.pth").write_text(sysconfig.get_paths()["purelib"])  # pip, setuptools, what is imported
    State(root=str(tmp_path), interpreter=interpreter_of(places)).save(places.state)
    ensure(places, [ROS2CLI], Report(io.StringIO()))
    return places


def answer(places: Places, *words: str, **variables: str) -> list[str]:
    given = {"PATH": os.environ["PATH"], "HOME": str(places.root), **variables}
    command = [places.venv / "bin" / "ros2", *words]
    ended = subprocess.run(command, env=given, capture_output=True, text=True, check=True, timeout=60)
    return ended.stdout.splitlines()


def test_it_is_fetched_by_git_installed_and_started_with_what_sourcing_would_set(installed, tmp_path, monkeypatch):
    prefix = str(installed.venv)
    said = answer(installed, "interface", "list")
    assert said[:5] == [f"AMENT_PREFIX_PATH={prefix}", "PYTHONPATH=", "ROS_DISTRO=", "interface", "list"]
    assert "'bag'" in said[5], "what rosbags does in the place of the stock command's extension is there"

    workspace = answer(installed, "run", AMENT_PREFIX_PATH="/ws/install", PYTHONPATH="/ws/install/lib")
    assert workspace[:2] == [f"AMENT_PREFIX_PATH=/ws/install:{prefix}", "PYTHONPATH=/ws/install/lib"]

    humble = {"AMENT_PREFIX_PATH": "/opt/ros/humble", "PYTHONPATH": "/opt/ros/humble/lib", "ROS_DISTRO": "humble"}
    assert answer(installed, "run", **humble)[:3] == [f"AMENT_PREFIX_PATH={prefix}", "PYTHONPATH=", "ROS_DISTRO="]

    # Made anew without any network: the wheels lie beside the environment.
    assert installed.ros2cli_wheels.is_dir()
    lead_git_to(monkeypatch, f"file://{tmp_path}/no/network/", "https://github.com/")
    (installed.venv / "bin" / "ros2").unlink()
    steps.ROS2CLI.check(installed)
    steps.ROS2CLI.run(installed, Report(io.StringIO()))
    assert answer(installed, "topic")[3] == "topic"
    assert json.loads(installed.state.read_text())["done"].keys() == {"ros2cli"}
