#!/usr/bin/env python3
"""Show the bag of a mission in three dimensions: ``python view_mission.py --help``."""

import sys

from bootstrap.first import begin

if __name__ == "__main__":
    begin(__file__)
    from bootstrap.python_version import require_allowed

    require_allowed(sys.argv)
    from bootstrap.launch import launch

    launch(
        "tethernet_bringup.view.command_line",
        "analysis",
        "tethernet_bringup.view.arguments",
        sys.argv[1:],
    )
