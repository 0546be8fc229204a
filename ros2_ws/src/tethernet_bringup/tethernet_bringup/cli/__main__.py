"""The command where no console script is on the path: ``python3 -m bootstrap PROFILE -- -m tethernet_bringup.cli``."""

from tethernet_bringup.cli.start import start

raise SystemExit(start())
