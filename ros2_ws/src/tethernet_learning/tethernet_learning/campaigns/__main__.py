from tethernet_core.quiet_start import command_start

command_start()

import sys  # noqa: E402

from tethernet_learning.campaigns.cli import main  # noqa: E402

sys.exit(main())
