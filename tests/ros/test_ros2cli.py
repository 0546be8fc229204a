"""The stock ``ros2`` command beside a flying mission, in a terminal in which no variable is set."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from bootstrap import ros2cli
from bootstrap.errors import SetupError
from bootstrap.places import venv_places
from bootstrap.report import Report
from tests.ros.mission_command import FLYING, MissionCommand

pytestmark = pytest.mark.ros
ANSWER_S = 60.0
LONG = ("--mus", "8", "--seed", "1", "--hold", "900")
"""A mission as it is by default, but for a test of holding that lasts until all commands are tried."""


class Terminal:
    """A second terminal: a home, a search path, and nothing else set."""

    def __init__(self, command: Sequence[str | Path], variables: dict[str, str]) -> None:
        self._command = command
        self._variables = {"PATH": os.environ["PATH"], "HOME": os.environ["HOME"], **variables}
        self.said = ""
        self.complaints = ""

    def domain(self, domain_id: int) -> Terminal:
        """Another terminal with the one variable that the stock command needs for another domain."""
        return Terminal(self._command, self._variables | {"ROS_DOMAIN_ID": str(domain_id)})

    def __call__(self, *words: str, status: int = 0) -> list[str]:
        """Lines of the answer to ``ros2 WORDS``."""
        ended = subprocess.run(
            [*self._command, *words], env=self._variables, capture_output=True, text=True, timeout=ANSWER_S, check=False
        )
        assert ended.returncode == status, ended.stdout + ended.stderr
        self.complaints = ended.stderr
        return ended.stdout.splitlines()

    def until(self, pattern: str, *words: str) -> None:
        """Run a command that does not end by itself until it has printed what is looked for."""
        process = subprocess.Popen(
            [*self._command, *words], env=self._variables, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        deadline = time.monotonic() + ANSWER_S
        lines = []
        try:
            for line in process.stdout:
                lines.append(line)
                if re.search(pattern, line):
                    return
                assert time.monotonic() < deadline, lines
            pytest.fail(f"{words} ended without {pattern!r}: {lines}")
        finally:
            process.send_signal(signal.SIGINT)
            process.stdout.close()
            process.wait(ANSWER_S)


@pytest.fixture(scope="module")
def ros2(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Terminal]:
    """The command as ``make ros2cli`` installs it; else, where its sources can be had, for these tests alone."""
    own = Path(sys.prefix, "bin", "ros2")
    if own.exists():
        yield Terminal([own], {})
        return
    places = venv_places()
    if places.venv != Path(sys.prefix):
        pytest.skip("NOT TESTED: the stock ros2 command; this Python is not that of the set-up")
    try:
        ros2cli.check(places)
    except SetupError as error:
        pytest.skip(f"NOT TESTED: the stock ros2 command beside a mission. {error}")
    if not ros2cli.wheels(places):
        ros2cli._build(places, Report())
    folder = tmp_path_factory.mktemp("ros2cli")
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", folder]
    subprocess.run([*pip, *ros2cli.wheels(places)], check=True)
    subprocess.run([*pip, "--upgrade", "--no-build-isolation", places.ros2cli], check=True)
    yield Terminal([folder / "bin" / "ros2"], {"PYTHONPATH": str(folder)})


@pytest.fixture
def default_domain(ros2: Terminal) -> Iterator[Terminal]:
    """The domain that a mission is in without any option, with nobody else in it."""
    ros2("daemon", "stop")
    others = ros2("node", "list", "--no-daemon", "--spin-time", "2")
    if others:
        pytest.skip(f"NOT TESTED: the stock ros2 command beside a default mission; somebody else is there: {others}")
    yield ros2
    ros2("daemon", "stop")


def test_the_commands_that_people_know_work_from_a_second_terminal(default_domain, tmp_path):
    ros2 = default_domain
    with MissionCommand(tmp_path, 0, *LONG) as mission:
        mission.wait_for(FLYING)
        looking = next(line for line in mission.lines if "look on with" in line)
        if (Path(sys.prefix) / "bin" / "ros2").exists():
            assert "bin/ros2 topic echo /mu1/thrust" in looking

        # The very first command, without a daemon: it must find what it asks for.
        message = "\n".join(ros2("topic", "echo", "/mu3/thrust", "--once"))
        assert re.search(r"frame_id: launch\nwrench:\n  force:\n    x: -?[\d.]+\n", message)
        assert message.endswith("---")
        forces = [float(number) for number in re.findall(r"^    [xyz]: (\S+)$", message, re.MULTILINE)]
        assert len(forces) == 6 and not any(forces[3:]), "a force, which may be zero, and no torque"

        listed = ros2("topic", "list", "-t")
        assert {"/mu3/thrust [geometry_msgs/msg/WrenchStamped]", "/mu8/odom [nav_msgs/msg/Odometry]"} <= set(listed)
        about = ros2("topic", "info", "/mu3/thrust")
        assert about[:2] == ["Type: geometry_msgs/msg/WrenchStamped", "Publisher count: 1"]
        ros2.until(r"average rate: \d+\.\d+", "topic", "hz", "/mu3/odom", "--window", "40")

        nodes = {f"/mu{mu}_controller" for mu in range(1, 9)} | {"/planner", "/assessor", "/sim", "/recorder"}
        assert nodes <= set(ros2("node", "list"))
        about = "\n".join(ros2("node", "info", "/mu3_controller"))
        assert re.search(r"Publishers:\n(    .+\n)*    /mu3/thrust: geometry_msgs/msg/WrenchStamped\n", about)

        assert "  closing_plan" in ros2("param", "list", "/planner")
        assert ros2("param", "get", "/mu3_controller", "use_sim_time") == ["Boolean value is: False"]

        assert "/planner/start" in ros2("service", "list")
        assert ros2("service", "type", "/planner/start") == ["std_srvs/srv/Trigger"]

        shown = ros2("interface", "show", "tethernet_msgs/msg/MuStatus")
        assert any(line.startswith("uint8 DEPLOYING=1") for line in shown)
        assert mission.stop(signal.SIGINT)[0] == 130
    held = "\n".join(ros2("bag", "info", str(mission.run / "bag")))
    assert re.search(r"Topic: /mu3/thrust \| Type: geometry_msgs/msg/WrenchStamped \| Count: \d+ \| ", held)
    warnings = [warning for warning in mission.outcome["warnings"] if "ros2" in warning]
    assert not warnings, "who only looks on is no stranger that the mission would have to tell of"


def test_another_domain_takes_the_variable_and_nothing_more(ros2, domain_id, tmp_path):
    there = ros2.domain(domain_id)
    try:
        with MissionCommand(tmp_path, domain_id, "--mus", "4", "--hold", "900") as mission:
            mission.wait_for(FLYING)
            said = next(line for line in mission.lines if "look on with" in line)
            assert f"look on with  ROS_DOMAIN_ID={domain_id} " in said
            assert "frame_id: launch" in "\n".join(there("topic", "echo", "/mu3/thrust", "--once"))
            assert "/mu4_controller" in there("node", "list")
            assert mission.stop(signal.SIGINT)[0] == 130
    finally:
        there("daemon", "stop")
