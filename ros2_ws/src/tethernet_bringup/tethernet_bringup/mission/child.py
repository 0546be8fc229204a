"""Runs one node's module for the supervisor, and ends it when the supervisor is gone.

    python -m tethernet_bringup.mission.child MODULE [ARGUMENT ...]

Standard input is a pipe into which nobody ever writes. It ends when the supervisor does, however that died; then this
process ends like after Ctrl-C, and by force where that takes too long. So not even ``kill -9`` of the supervisor leaves
a node behind, nor the mission's shared memory, see :mod:`tethernet_bringup.mission.sweeper`.
"""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import quiet_start, unblock_signals

    quiet_start()
    unblock_signals()

import os
import runpy
import signal
import sys
import threading
import time

from tethernet_bringup.mission import sweeper

PATIENCE_S = 5.0


def _end_with_supervisor(began_s: float) -> None:
    while os.read(0, 1):
        pass
    try:
        sweeper.start(began_s)  # nobody else is left to do that
        time.sleep(sweeper.HEAD_START_S)
    except Exception as error:  # whatever it is, this process has to end
        print(f"the shared memory stays behind: {error}", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(PATIENCE_S)  # the process ends within this time, or is made to
    os.kill(os.getpid(), signal.SIGKILL)


def main() -> None:
    """Run the module that the command line names as ``python -m`` would."""
    threading.Thread(target=_end_with_supervisor, args=(time.time(),), name="supervisor-watch", daemon=True).start()
    module = sys.argv[1]
    del sys.argv[1]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
