"""Run by ``colcon test``: what the build has installed lies where ROS 2 looks for it, and works."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_prefix, get_package_share_directory

from tethernet_control.controller_node import main

PACKAGE = "tethernet_control"


def test_the_node_and_its_parameters_are_installed():
    assert callable(main)
    assert Path(get_package_prefix(PACKAGE), "lib", PACKAGE, "controller").is_file()
    assert Path(get_package_share_directory(PACKAGE), "config", "controller_node.yaml").is_file()
