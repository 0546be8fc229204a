"""``tethernet view``: the same as ``view_mission.py``, in an environment that is there."""

from __future__ import annotations

from tethernet_bringup.view import arguments
from tethernet_bringup.view.command_line import run
from tethernet_core.subcommand import Subcommand

COMMAND = Subcommand(
    "Show the bag of a mission in three dimensions and as time series, in Rerun.",
    ("runs/RUN", "runs/RUN --view web"), run, arguments.add_arguments,
    exit_status=arguments.EXIT_STATUS,
)  # fmt: skip
