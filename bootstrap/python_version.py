"""Get onto a Python that the system runs on. Any Python since 2.7 can read this file, to say so clearly."""

from __future__ import print_function

import os
import subprocess
import sys

ALLOWED = ((3, 11), (3, 12))

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CANDIDATES = (os.path.join(ROOT, ".venv", "bin", "python"), "python3.12", "python3.11", "python3")


def require_allowed(arguments):
    """Return on an allowed Python; else go on with one that is found, by replacing this process, or exit with status 1.

    Args:
        arguments: what to give to the other Python, the script first.
    """
    if sys.version_info[:2] in ALLOWED:
        return
    found = "%d.%d.%d (%s)" % (sys.version_info[:3] + (sys.executable,))
    for candidate in CANDIDATES:
        if version_of(candidate) in ALLOWED:
            print("Python %s cannot run this; going on with %s" % (found, candidate), file=sys.stderr)
            sys.stderr.flush()
            os.execvp(candidate, [candidate] + list(arguments))
    allowed = " or ".join("%d.%d" % version for version in ALLOWED)
    sys.exit(
        "This is Python %s, and no other was found on PATH; allowed: Python %s.\n"
        "Install one, for example with `apt-get install python3.12 python3.12-venv python3.12-dev`, "
        "and start again with `python3.12 ...`." % (found, allowed)
    )


def version_of(python):
    """Major and minor version of an interpreter, None where it does not run."""
    try:
        process = subprocess.Popen(
            [python, "-c", "import sys; print('%d %d' % sys.version_info[:2])"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        output = process.communicate()[0].decode()
        return tuple(int(word) for word in output.split()) if process.returncode == 0 else None
    except (OSError, ValueError):
        return None
