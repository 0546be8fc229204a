"""The first thing that a script for users does. Any Python since 2.7 can read this file."""

import os
import sys


def begin(script):
    """Leave the script's and the user's folder out of the imports, and end without a traceback on Ctrl-C.

    Python puts the script's folder before all libraries, and empty or relative entries of PYTHONPATH after it: a file
    random.py there must not be imported in a library's place. The modules of this package are found all the same,
    because the package itself is imported by now.

    Args:
        script: the file that the user has started.
    """
    relative = [entry for entry in os.environ.get("PYTHONPATH", "").split(os.pathsep) if not os.path.isabs(entry)]
    try:
        doomed = [os.path.dirname(os.path.abspath(script))] + [os.path.abspath(entry) for entry in relative]
    except OSError:  # the working folder is gone, and so is what was in it
        doomed = []
    sys.path[:] = [entry for entry in sys.path if entry not in doomed]

    import signal  # only now: it must be the library's

    signal.signal(signal.SIGINT, lambda *_: os._exit(128 + signal.SIGINT))
