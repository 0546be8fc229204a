"""The banner's example of looking on: a command that exists on this machine, or how to get one."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tethernet_bringup.mission.look_on import look_on


@pytest.fixture
def prefix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An environment without ros2, on a machine without ros2, looked at from the folder that it lies in."""
    environment = tmp_path / ".venv"
    (environment / "bin").mkdir(parents=True)
    (environment / "setup.json").touch()
    monkeypatch.setattr(sys, "prefix", str(environment))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.chdir(tmp_path)
    return environment


def program(path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    path.touch()
    path.chmod(0o755)


def test_the_command_of_the_environment_is_named_as_it_is_typed(prefix, monkeypatch, tmp_path):
    program(prefix / "bin" / "ros2")
    assert look_on("/mu1/thrust", 0) == "look on with  .venv/bin/ros2 topic echo /mu1/thrust"
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert look_on("/mu1/thrust", 0) == f"look on with  {prefix}/bin/ros2 topic echo /mu1/thrust"


def test_another_domain_is_told_by_the_variable(prefix):
    program(prefix / "bin" / "ros2")
    assert look_on("/mu1/thrust", 7) == "look on with  ROS_DOMAIN_ID=7 .venv/bin/ros2 topic echo /mu1/thrust"


def test_the_machines_own_command_serves(prefix, tmp_path):
    program(tmp_path / "bin" / "ros2")
    assert look_on("/debris/odom", 0) == "look on with  ros2 topic echo /debris/odom"


def test_without_any_the_banner_says_how_to_get_it(prefix):
    said = "look on with  .venv/bin/ros2 topic echo /mu1/thrust  (`make ros2cli` installs it)"
    assert look_on("/mu1/thrust", 0) == said


def test_an_environment_that_is_not_ours_is_not_told_to_use_our_makefile(prefix):
    (prefix / "setup.json").unlink()
    assert look_on("/mu1/thrust", 0) == "look on with  ros2 topic echo /mu1/thrust"
