"""Run by ``colcon test``: what the build has installed lies where ROS 2 looks for it, and works."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory

from tethernet_core.system.loading import load_system, shipped_systems

SYSTEMS = Path(get_package_share_directory("tethernet_core"), "systems")


def test_the_descriptions_in_share_are_those_that_names_stand_for():
    assert {path.stem for path in SYSTEMS.glob("*.yaml")} == set(shipped_systems())
    for name in shipped_systems():
        assert load_system(SYSTEMS / f"{name}.yaml").digest == load_system(name).digest
