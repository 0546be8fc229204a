"""Run by ``colcon test``: what the build has installed lies where ROS 2 looks for it, and works."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_prefix, get_package_share_directory

from tethernet_sim.scenario import Scenario

PACKAGE = "tethernet_sim"


def test_the_node_and_its_parameters_are_installed():
    assert Path(get_package_prefix(PACKAGE), "lib", PACKAGE, "sim").is_file()
    config = Path(get_package_share_directory(PACKAGE), "config")
    assert {path.name for path in config.iterdir()} >= {"physics.yaml", "scenario.yaml", "sim_node.yaml"}
    assert Scenario("zenit_8mu").debris_position
