"""Run by ``colcon test``: what the build has installed lies where ROS 2 looks for it, and works."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_prefix, get_package_share_directory

from tethernet_planner.inference.shipped_models import FOLDER, shipped

PACKAGE = "tethernet_planner"


def test_nodes_parameters_and_models_are_installed():
    prefix = Path(get_package_prefix(PACKAGE), "lib", PACKAGE)
    assert all((prefix / name).is_file() for name in ("planner", "assessor"))
    config = Path(get_package_share_directory(PACKAGE), "config")
    assert {path.name for path in config.iterdir()} >= {"planner.yaml", "assessor.yaml"}
    assert shipped("policy") and FOLDER.is_dir()
