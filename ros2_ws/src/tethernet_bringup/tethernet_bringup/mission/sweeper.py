"""Ends what is left of a mission whose command was killed: nodes that cannot end themselves, then its shared memory.

A node that was halted, or hangs with the interpreter's lock, never learns that the command is gone.

The command does all that itself where it can (:mod:`tethernet_bringup.mission.supervisor`). Where it cannot, the first
node that notices starts this process, which needs nothing from the command: the mission's nodes are those that have the
same pipe for their standard input, and what belongs to the mission is what they map, the command's own segment among
it.
"""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from tethernet_bringup.mission import shared_memory

PATIENCE_S = 20.0
"""All has come to its end after this time [s]."""
NODE_PATIENCE_S = 5.0
"""A node without a supervisor ends within this time [s], or is made to: by itself, where it cannot, from here."""
HEAD_START_S = 0.5
_POLL_S = 0.05


def start(began_s: float) -> None:
    """Start the sweeper of this process' mission, unless another node has done so.

    It is known by then what the nodes map, if all of them wait for :data:`HEAD_START_S` before they end.

    Args:
        began_s: seconds since the epoch, before any process of the mission made a segment.
    """
    try:
        place = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        # A name without a file, which the kernel frees with the sweeper.
        pipe = _pipe_of("self")
        place.bind(f"\0tethernet-sweeper-{pipe}-{os.getuid()}")
    except OSError:
        return
    names = shared_memory.held_by(_family(pipe))  # now: the nodes end faster than a process starts
    subprocess.Popen(
        [sys.executable, "-P", "-m", "tethernet_bringup.mission.sweeper", f"{began_s:.3f}", *sorted(names)],
        stdin=0, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True, pass_fds=[place.fileno()],
    )  # fmt: skip


def main() -> None:
    """Wait for the end of the nodes, kill those that do not come to it, then remove what they have left.

    The command line tells when the mission began and what they map so far.
    """
    pipe, began_s, names = _pipe_of("self"), float(sys.argv[1]), set(sys.argv[2:])
    began = time.monotonic()
    deadline, due = began + PATIENCE_S, began + HEAD_START_S + NODE_PATIENCE_S
    while (family := [pid for pid in _family(pipe) if pid != os.getpid()]) and time.monotonic() < deadline:
        names |= shared_memory.held_by(family)
        if time.monotonic() >= due:
            _kill(family, pipe)
        time.sleep(_POLL_S)
    time.sleep(shared_memory.YOUNG_S)  # what was made last has to be old enough
    shared_memory.clean(names | shared_memory.left_since(began_s))


def _family(pipe: str) -> list[int]:
    """The living nodes of a mission."""
    others = (entry.name for entry in Path("/proc").iterdir() if entry.name.isdigit())
    return [int(pid) for pid in others if _pipe_of(pid) == pipe]


def _kill(pids: Iterable[int], pipe: str) -> None:
    """Kill those of the processes that still have this pipe: a number may be another process' by now."""
    for pid in pids:
        try:
            process = os.pidfd_open(pid)
        except OSError:  # gone
            continue
        try:
            if _pipe_of(str(pid)) == pipe:
                signal.pidfd_send_signal(process, signal.SIGKILL)
        except OSError:  # gone, or somebody else's
            continue
        finally:
            os.close(process)


def _pipe_of(pid: str) -> str:
    try:
        return str(Path(f"/proc/{pid}/fd/0").readlink())
    except OSError:  # gone, or somebody else's
        return ""


if __name__ == "__main__":
    main()
