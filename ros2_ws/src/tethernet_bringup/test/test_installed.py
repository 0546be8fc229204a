"""Run by ``colcon test``: what the build has installed lies where ROS 2 looks for it, and works."""

from __future__ import annotations

import subprocess
from pathlib import Path

from ament_index_python.packages import get_package_prefix, get_package_share_directory

PACKAGE = "tethernet_bringup"
COMMANDS = ("run_mission", "analyse_mission", "recorder", "tethernet")


def test_commands_and_parameters_are_installed():
    prefix = Path(get_package_prefix(PACKAGE), "lib", PACKAGE)
    assert all((prefix / name).is_file() for name in COMMANDS)
    shown = subprocess.run([prefix / "run_mission", "--help"], capture_output=True, text=True, check=True, timeout=60)
    assert "--system NAME|FILE" in shown.stdout
    config = Path(get_package_share_directory(PACKAGE), "config")
    assert {path.name for path in config.iterdir()} >= {"recorder.yaml", "supervisor.yaml"}
