"""Run by ``colcon test``: what the build has installed lies where ROS 2 looks for it, and works."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory

from tethernet_learning.policies.reward import REFERENCES_FILE, references


def test_what_rewards_are_measured_against_is_installed():
    share = Path(get_package_share_directory("tethernet_learning"), "config", "references.json")
    assert share.read_bytes() == REFERENCES_FILE.read_bytes()
    assert references()
