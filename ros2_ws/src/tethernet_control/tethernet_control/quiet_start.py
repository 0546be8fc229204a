"""A quiet end while a process is still starting.

Importing takes a node some tenths of a second, on a busy machine seconds, and there is nothing to clean up yet. A
node's module calls this before its other imports, when it is run as a program.
"""

import os
import signal


def quiet_start() -> None:
    """From now on SIGINT and SIGTERM end the process at once, with status 0 and no traceback from inside an import.

    :func:`tethernet_control.ros.executor.run` replaces this as soon as there is something to clean up.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))
