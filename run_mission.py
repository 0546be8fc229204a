#!/usr/bin/env python3
"""Fly a tether-net capture mission over ROS 2, record it and print the verdict: ``python run_mission.py --help``."""

import sys

from bootstrap.first import begin

if __name__ == "__main__":
    begin(__file__)
    from bootstrap.python_version import require_allowed

    require_allowed(sys.argv)
    from bootstrap.launch import launch

    launch(
        "tethernet_bringup.mission.command_line",
        "mission",
        "tethernet_bringup.mission.arguments",
        sys.argv[1:],
    )
