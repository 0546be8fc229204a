from tethernet_control.quiet_start import command_start

command_start()

import sys  # noqa: E402

from .cli import main  # noqa: E402

sys.exit(main())
