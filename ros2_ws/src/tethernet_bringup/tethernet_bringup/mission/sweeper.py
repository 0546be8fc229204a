"""Ends what is left of a mission whose command was killed: nodes that cannot end themselves, then its shared memory.

A node that was halted, or hangs with the interpreter's lock, never learns that the command is gone.

The command does all that itself where it can (:mod:`tethernet_bringup.mission.supervisor`). Where it cannot, the first
node that notices starts this process, which needs nothing from the command: the mission's nodes are those that have the
same pipe for their standard input, and what belongs to the mission is what they map, the command's own segment among
it. When the nodes end, and the command has yet to tell how it went and to leave the graph, such a process stands by.
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
_STANDING_BY = "--standing-by"
_MODULE = "tethernet_bringup.mission.sweeper"
_ATTEMPTS = 2
"""To start a sweeper: a node that is halted in the first one has the name and never starts any."""


def start(began_s: float) -> None:
    """Start the sweeper of this process' mission, unless another node has done so.

    It is known by then what the nodes map, if all of them wait for :data:`HEAD_START_S` before they end.

    Args:
        began_s: seconds since the epoch, before any process of the mission made a segment.
    """
    pipe = _pipe_of("self")
    for attempt in range(_ATTEMPTS):
        place = _take(pipe, attempt)
        if place is not None:
            names = shared_memory.held_by(_family(pipe))  # now: the nodes end faster than a process starts
            _run([pipe, f"{began_s:.3f}", *sorted(names)], 0, place.fileno())
            return
        # Another node does it, or has been halted before it could.
        patience = time.monotonic() + HEAD_START_S
        while time.monotonic() < patience:
            if any(map(_sweeps, _family(pipe))):
                return
            time.sleep(_POLL_S)


def _take(pipe: str, attempt: int) -> socket.socket | None:
    """What only one of a mission's nodes can have; None where another has it."""
    place = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        # A name without a file, which the kernel frees with the sweeper.
        place.bind(f"\0tethernet-sweeper-{pipe}-{os.getuid()}-{attempt}")
    except OSError:
        place.close()
        return None
    return place


def stand_by(nodes_stdin: int, began_s: float, names: Iterable[str]) -> int:
    """Start a sweeper that begins where the calling process ends without having called it off.

    Args:
        nodes_stdin: descriptor of the pipe that the nodes have for their standard input.
        began_s: as of :func:`start`.
        names: of the segments that nodes and the calling process map.

    Returns:
        Descriptor of a pipe that the caller keeps open as long as it lives; any byte that is written into it calls the
        sweeper off.

    Raises:
        OSError: when the process cannot be made.
    """
    pipe = str(Path(f"/proc/self/fd/{nodes_stdin}").readlink())
    reading, writing = os.pipe()
    try:
        _run([_STANDING_BY, pipe, f"{began_s:.3f}", *sorted(names)], reading)
    except OSError:
        os.close(writing)
        raise
    finally:
        os.close(reading)
    return writing


def _run(words: list[str], stdin: int, *kept: int) -> None:
    subprocess.Popen(
        [sys.executable, "-P", "-m", _MODULE, *words],
        stdin=stdin, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True, pass_fds=kept,
    )  # fmt: skip


def main() -> None:
    """Wait for the end of the nodes, kill those that do not come to it, then remove what they have left.

    The command line tells which pipe they have, when the mission began, and what they map so far.
    """
    words = sys.argv[1:]
    if words[0] == _STANDING_BY:
        words = words[1:]
        if os.read(0, 1):
            return  # called off
    pipe, began_s, names = words[0], float(words[1]), set(words[2:])
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


def _sweeps(pid: int) -> bool:
    """Whether a process is a sweeper."""
    try:
        return _MODULE.encode() in Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:  # gone
        return False


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
