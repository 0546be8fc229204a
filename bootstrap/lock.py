"""One set-up of an environment at a time, and none of an earlier one left running."""

from __future__ import annotations

import contextlib
import fcntl
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

MARK = "TETHERNET_SETUP"
"""Environment variable by which the processes of a set-up are known, with the environment's folder as its value."""

LEFTOVERS_END_S = 5.0


@contextlib.contextmanager
def locked(path: Path, waiting: Callable[[], None]) -> Iterator[None]:
    """Hold the lock of an environment. The kernel frees it when this process ends, however it ends.

    Args:
        path: the lock file, made where missing and never removed.
        waiting: called once if somebody else holds the lock, before waiting for it.
    """
    with open(path, "a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            waiting()
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def end_leftovers(venv: Path) -> int:
    """Kill the tools of a set-up that was itself killed, with the lock held: they still write into the environment.

    Returns:
        How many processes were found.
    """
    mark = f"{MARK}={venv}".encode()
    found = 0
    deadline = time.monotonic() + LEFTOVERS_END_S
    while leftovers := [pid for pid in _pids() if mark in _environment(pid)]:
        found = max(found, len(leftovers))
        for pid in leftovers:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
        if time.monotonic() > deadline:
            break
        time.sleep(0.02)
    return found


def _pids() -> list[int]:
    return [int(name) for name in os.listdir("/proc") if name.isdigit() and int(name) != os.getpid()]  # noqa: PTH208


def _environment(pid: int) -> list[bytes]:
    """A process' environment; empty for a zombie and for somebody else's process."""
    try:
        return Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return []
