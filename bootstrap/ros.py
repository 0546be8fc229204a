"""A machine's own ROS 2: what is sourced, and whether the workspace is built for it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from .places import PYTHON_PACKAGES

DISTRIBUTION = "jazzy"
BUILD_COMMANDS = "cd ros2_ws && colcon build && . install/setup.sh"


def sourced(given: Mapping[str, str]) -> str:
    """Name of the ROS 2 distribution that is sourced, "" for none."""
    return given.get("ROS_DISTRO", "") if given.get("AMENT_PREFIX_PATH") else ""


def unbuilt(given: Mapping[str, str]) -> list[str]:
    """Packages of the workspace that the sourced ROS 2 does not know."""
    prefixes = [Path(prefix) for prefix in given.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
    index = "share/ament_index/resource_index/packages"
    wanted = ("tethernet_msgs", *PYTHON_PACKAGES)
    return [package for package in wanted if not any((prefix / index / package).exists() for prefix in prefixes)]
