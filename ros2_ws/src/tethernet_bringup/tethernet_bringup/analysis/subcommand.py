"""``tethernet analyse``: the same as ``analyse_mission.py``, in an environment that is there."""

from __future__ import annotations

from tethernet_bringup.analysis import arguments
from tethernet_bringup.analysis.command_line import run
from tethernet_core.subcommand import Subcommand

COMMAND = Subcommand(
    "Make a table, pictures and a report (one HTML file) from the bag of a mission, whole or torn.",
    ("runs/RUN", "runs/RUN --json --no-plots"), run, arguments.add_arguments,
    exit_status=arguments.EXIT_STATUS,
)  # fmt: skip
