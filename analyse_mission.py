#!/usr/bin/env python3
"""Make a table and pictures from the bag of a mission: ``python analyse_mission.py --help``."""

import sys

from bootstrap.first import begin

if __name__ == "__main__":
    begin(__file__)
    from bootstrap.python_version import require_allowed

    require_allowed(sys.argv)
    from bootstrap.launch import launch

    launch(
        "tethernet_bringup.analysis.command_line",
        "analysis",
        "tethernet_bringup.analysis.arguments",
        sys.argv[1:],
    )
