"""Runs a command in namespaces of its own: loopback network, processes, /dev/shm. Needs root and unshare."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence

_ENTER = 'ip link set lo up && mount -t tmpfs -o size=1g tmpfs /dev/shm && exec "$@"'
_UNSHARE = ["unshare", "-n", "-m", "-p", "--fork", "--mount-proc", "--kill-child", "--propagation", "private"]


def isolated(command: Sequence[str]) -> list[str]:
    """The command line that runs ``command`` in isolation; all its processes end with it."""
    return [*_UNSHARE, "bash", "-c", _ENTER, "isolated", *command]


def missing() -> str:
    """Why nothing can be isolated here; empty when it can."""
    if os.geteuid() != 0:
        return "needs root, for namespaces"
    for program in ("unshare", "ip", "mount"):
        if shutil.which(program) is None:
            return f"needs {program}"
    tried = subprocess.run(isolated(["true"]), capture_output=True, text=True, check=False)
    return "" if tried.returncode == 0 else f"namespaces are not to be had: {tried.stderr.strip()}"
