"""The whole set-up in a fresh copy of the repository, killed on the way: minutes, and a package index."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bootstrap.places import ROOT

pytestmark = [pytest.mark.slow, pytest.mark.network, pytest.mark.timeout(1500)]

USES = "import rclpy, numba, scipy, matplotlib, mcap, rosbags, tf2_msgs.msg, tethernet_msgs.msg, tethernet_bringup"


@pytest.fixture
def copy(tmp_path) -> Path:
    """What a clone would bring, in a path with a space."""
    folder = tmp_path / "a clone"
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout
    for name in filter(None, listed.decode().split("\0")):
        if (ROOT / name).is_file():  # not one that is deleted and not yet committed
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    return folder


def start(copy: Path) -> subprocess.Popen:
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("TETHERNET_", "ROS_DISTRO"))}
    return subprocess.Popen(
        [sys.executable, copy / "run_mission.py", "--setup-only"], cwd="/", env=clean, stderr=subprocess.PIPE, text=True
    )


def kill_in(copy: Path, title: str, seconds: float) -> None:
    """Kill a set-up so long after a step has begun: the time says where in the step the kill falls."""
    process = start(copy)
    for line in process.stderr:
        if title in line:
            break
    else:
        pytest.fail(f"the set-up ended with status {process.wait()} before {title!r}")
    time.sleep(seconds)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL


def test_a_fresh_copy_sets_itself_up_whatever_kills_it_on_the_way(copy):
    kill_in(copy, "Making the environment", 1.0)
    kill_in(copy, "pinned wheels", 15.0)
    kill_in(copy, "own packages", 0.5)
    kill_in(copy, "Building the messages", 10.0)
    kill_in(copy, "physics kernels", 1.0)

    process = start(copy)
    told = process.communicate()[1]
    assert process.returncode == 0, told
    python = copy / ".venv" / "bin" / "python"
    for command in (["-m", "pip", "check"], ["-c", USES]):
        ended = subprocess.run([python, *command], cwd="/", capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stdout + ended.stderr

    began = time.monotonic()
    process = start(copy)
    assert process.communicate()[1] == ""
    assert time.monotonic() - began < 3.0, "a second start must take no set-up time"

    message = copy / "ros2_ws/src/tethernet_msgs/msg/MuStatus.msg"
    message.write_text(message.read_text() + "bool added_by_a_test\n")
    process = start(copy)
    told = process.communicate()[1]
    assert process.returncode == 0 and "[1/1] Building the messages" in told, told
    uses_field = "from tethernet_msgs.msg import MuStatus; MuStatus(added_by_a_test=True)"
    assert subprocess.run([python, "-c", uses_field], check=False).returncode == 0
