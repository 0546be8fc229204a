"""From the scripts for users to the environment's Python: which one, under which variables, and what comes first."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bootstrap import launch, runtime
from bootstrap.places import PYTHON_PACKAGES, ROOT, Places, venv_places


def run(script: str, *words: str, **variables: str) -> subprocess.CompletedProcess:
    """Start a script for users from another folder than its own, for an environment that is not there."""
    clean = {key: value for key, value in os.environ.items() if key not in ("ROS_DISTRO", "AMENT_PREFIX_PATH")}
    return subprocess.run(
        [sys.executable, ROOT / script, *words],
        cwd="/",
        env=clean | variables,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_help_and_bad_usage_need_no_set_up(tmp_path):
    venv = tmp_path / "not here"
    began = time.monotonic()
    told = run("run_mission.py", "--help", TETHERNET_VENV=str(venv))
    assert told.returncode == 0 and "--pace" in told.stdout and told.stderr == ""
    refused = run("run_mission.py", "--mus", "5", TETHERNET_VENV=str(venv))
    assert refused.returncode == 2 and "--mus 5" in refused.stderr and "4" in refused.stderr
    assert time.monotonic() - began < 5.0
    assert list(tmp_path.iterdir()) == []


def test_a_machine_without_tools_ends_with_status_1_and_says_what_to_install(tmp_path):
    failed = run("run_mission.py", TETHERNET_VENV=str(tmp_path / ".venv"), PATH="/nowhere")
    assert failed.returncode == 1
    assert "Set-up failed" in failed.stderr and "apt-get install cmake" in failed.stderr
    assert "Traceback" not in failed.stderr


def test_an_unknown_profile_is_refused_with_those_that_are():
    told = subprocess.run(
        [sys.executable, "-m", "bootstrap", "mision"], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
    )
    assert told.returncode == 2 and "mision" in told.stderr and "mission" in told.stderr


def test_the_wheels_libraries_come_first_and_the_process_starts_once(tmp_path):
    (tmp_path / "lib/python3.11/site-packages/ros_rclpy.libs").mkdir(parents=True)
    given = {"HOME": "/home/me", "LD_LIBRARY_PATH": f"/mine{os.pathsep}{tmp_path}/lib"}
    variables = runtime.environment(Places(ROOT, tmp_path), given)
    own = [f"{tmp_path}/lib", f"{tmp_path}/lib/python3.11/site-packages/ros_rclpy.libs"]
    assert variables["LD_LIBRARY_PATH"].split(os.pathsep) == [*own, "/mine"]
    assert variables[runtime.BOOTSTRAP_MARK] == "1"


def test_another_ros_is_kept_out(tmp_path):
    given = {
        "HOME": "/home/me",
        "ROS_DISTRO": "humble",
        "ROS_DOMAIN_ID": "7",
        "AMENT_PREFIX_PATH": "/home/me/ws/install:/opt/ros/humble",
        "PYTHONPATH": "/home/me/ws/install/lib/python3.10/site-packages:/opt/ros/humble/lib:/home/me/mine",
        "LD_LIBRARY_PATH": "/opt/ros/humble/lib",
        "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
    }
    variables = runtime.environment(Places(ROOT, tmp_path), given)
    assert variables["PYTHONPATH"] == "/home/me/mine"
    assert variables["LD_LIBRARY_PATH"] == f"{tmp_path}/lib"
    assert variables["ROS_DOMAIN_ID"] == "7"
    assert not {"ROS_DISTRO", "AMENT_PREFIX_PATH", "RMW_IMPLEMENTATION"} & set(variables)


def test_home_is_always_set(tmp_path):
    assert Path(runtime.environment(Places(ROOT, tmp_path), {})["HOME"]).is_dir()


def built_workspace(prefix: Path, packages=("tethernet_msgs", *PYTHON_PACKAGES)) -> None:
    index = prefix / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    for package in packages:
        (index / package).touch()


@pytest.fixture
def sourced(tmp_path, monkeypatch) -> Path:
    """The variables of a sourced ROS 2 Jazzy with an overlay."""
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path}{os.pathsep}/opt/ros/jazzy")
    monkeypatch.setenv("TETHERNET_VENV", str(tmp_path / ".venv"))
    monkeypatch.delenv("TETHERNET_ENVIRONMENT", raising=False)
    monkeypatch.setattr(launch, "pending", lambda places, steps: [])
    return tmp_path


def test_jazzy_of_the_machine_with_a_built_workspace_is_used(sourced):
    built_workspace(sourced)
    python, variables = launch.prepare(["mission"])
    assert python == str(ROOT / ".venv.ros" / "bin" / "python")
    assert variables["ROS_DISTRO"] == "jazzy" and variables["AMENT_PREFIX_PATH"] == os.environ["AMENT_PREFIX_PATH"]


def test_jazzy_without_the_workspace_is_told_how_to_build_it(sourced, capfd):
    built_workspace(sourced, ["tethernet_msgs"])
    python, variables = launch.prepare(["mission"])
    told = capfd.readouterr().err
    assert "lacks tethernet_core" in told and "colcon build" in told
    assert python == str(venv_places().python) and "ROS_DISTRO" not in variables


def test_another_distribution_is_told_and_not_used(sourced, monkeypatch, capfd):
    monkeypatch.setenv("ROS_DISTRO", "humble")
    python, _ = launch.prepare(["mission"])
    assert "ROS 2 humble is sourced, jazzy is needed" in capfd.readouterr().err
    assert python == str(venv_places().python)


def test_the_own_environment_can_be_asked_for(sourced, monkeypatch):
    built_workspace(sourced)
    monkeypatch.setenv("TETHERNET_ENVIRONMENT", "venv")
    assert launch.prepare(["mission"])[0] == str(venv_places().python)
