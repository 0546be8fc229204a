"""Environment variables under which the environment's Python flies a mission."""

from __future__ import annotations

import os
import pwd
from collections.abc import Mapping

from .places import Places

OTHER_ROS = (
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "ROS_DISTRO",
    "ROS_PYTHON_VERSION",
    "ROS_VERSION",
)
"""Set by sourcing a ROS 2 of the machine, which must not be mixed with the one from wheels."""

SEARCH_PATHS = ("LD_LIBRARY_PATH", "PYTHONPATH")
RMW = "rmw_fastrtps_cpp"
"""The only middleware among the wheels."""

BOOTSTRAP_MARK = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
"""The wheels' start-up hook replaces the process by itself with LD_LIBRARY_PATH set, unless it finds this mark."""


def environment(places: Places, given: Mapping[str, str]) -> dict[str, str]:
    """What the environment's Python and all its children need, from what this process was given.

    Sets LD_LIBRARY_PATH as the wheels' start-up hook would, so that no process of a mission starts twice; takes out
    what a sourced ROS 2 of another kind has put in; makes sure of HOME, where rcl keeps its logs.
    """
    result = {key: value for key, value in given.items() if key not in OTHER_ROS and key != "PYTHONHOME"}
    prefixes = [path for key in OTHER_ROS[:3] for path in given.get(key, "").split(os.pathsep) if path] + ["/opt/ros/"]
    for key in SEARCH_PATHS:
        kept = [path for path in given.get(key, "").split(os.pathsep) if path and not path.startswith(tuple(prefixes))]
        result.pop(key, None)
        if kept:
            result[key] = os.pathsep.join(kept)
    own = [
        str(places.venv / "lib"),
        *sorted(str(path) for path in places.venv.glob("lib/python3.*/site-packages/ros_*.libs")),
    ]
    others = [path for path in result.get("LD_LIBRARY_PATH", "").split(os.pathsep) if path and path not in own]
    result["LD_LIBRARY_PATH"] = os.pathsep.join([*own, *others])
    result[BOOTSTRAP_MARK] = "1"
    if result.get("RMW_IMPLEMENTATION", RMW) != RMW:
        del result["RMW_IMPLEMENTATION"]
    if not result.get("HOME"):
        result["HOME"] = _home(places)
    return result


def _home(places: Places) -> str:
    try:
        home = pwd.getpwuid(os.getuid()).pw_dir
    except KeyError:
        home = ""
    return home if os.access(home, os.W_OK) else str(places.venv)
