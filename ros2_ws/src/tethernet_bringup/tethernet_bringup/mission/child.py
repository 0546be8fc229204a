"""A node's process, forked from the command's: what the command has imported by then no node need import again.

Importing is most of what a node does until it is there: 0.29 s of CPU time for a controller that is started as a
program of its own, 0.09 s for one that is forked. The command must not have loaded the middleware yet, which has
threads from the moment on that it is loaded, and threads are not forked.

Standard input is a pipe into which nobody ever writes. It ends when the supervisor does, however that died; then this
process ends like after Ctrl-C, and by force where that takes too long; :mod:`tethernet_bringup.mission.sweeper` ends
nodes that hang. So not even ``kill -9`` of the supervisor leaves a node behind, nor the mission's shared memory.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import os
import runpy
import signal
import sys
import threading
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from tethernet_bringup.mission import process_title, sweeper
from tethernet_core.quiet_start import SEARCH_PATHS, quiet_start, unblock_signals
from tethernet_ros.start_gate import close_gate

HELD_BACK = (signal.SIGINT, signal.SIGTERM)
"""Signals that a node takes from the moment on that it can."""
_STREAMS = 3
_FAULT = 1


class ForkedProcess:
    """A child of this process."""

    def __init__(self, pid: int):
        """Args:
        pid: its process id.
        """
        self.pid = pid
        self.returncode: int | None = None
        """Exit code, negative: killed by that signal; None while it lives, as far as is known."""

    def poll(self) -> int | None:
        """Look whether it lives; returns the exit code when it does not."""
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode


@dataclass(frozen=True)
class Surroundings:
    """What a node's process is given."""

    stdin: int
    """Descriptor of the pipe that ends with the supervisor."""
    log: int
    """Descriptor of the file for what it prints."""
    gate: int
    """Descriptor of the pipe from which it is let into the graph."""
    environment: Mapping[str, str]
    """Its environment variables."""
    began_s: float
    """When the supervisor began, before any process of the mission made shared memory: seconds since the epoch."""
    batch: bool = False
    """Whether its threads interrupt nobody when they are woken."""


def fork(name: str, module: str, arguments: Sequence[str], surroundings: Surroundings) -> ForkedProcess:
    """Run a module in a process of its own, as ``python -m`` would.

    Args:
        name: of the node.
        module: what it runs.
        arguments: further words of its command line.
        surroundings: what it is given.

    Raises:
        OSError: when the process cannot be made.
    """
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()  # else the child would print it too
    gc.freeze()  # what is there stays where it is: a collection would copy every page that the child shares
    # Signals wait until the child has somebody to take them.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, HELD_BACK)
    try:
        pid = os.fork()
        if not pid:
            _live(name, module, arguments, surroundings)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return ForkedProcess(pid)


def _live(name: str, module: str, arguments: Sequence[str], surroundings: Surroundings) -> NoReturn:
    """All of the child's life: nothing of the frames that it has inherited is ever run by it."""
    code = _FAULT
    try:
        _settle(surroundings)
        process_title.show([sys.executable, "-P", "-m", module, *arguments], name)
        watch = threading.Thread(target=_end_with_supervisor, args=(surroundings.began_s,), name="supervisor-watch")
        watch.daemon = True
        watch.start()
        sys.argv = [module, *arguments]
        runpy.run_module(module, run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as end:
        code = _exit_code(end)
    except BaseException:
        traceback.print_exc()
    finally:
        try:
            atexit._run_exitfuncs()
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            os._exit(code)


def _settle(surroundings: Surroundings) -> None:
    """Let go of all that is the parent's: handlers, descriptors, streams, environment, terminal."""
    atexit._clear()
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # as nohup asks for
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    os.setsid()  # Ctrl-C at the terminal reaches the supervisor alone
    gate = os.dup(surroundings.gate)
    for target, source in enumerate((surroundings.stdin, surroundings.log, surroundings.log)):
        os.dup2(source, target)
    os.dup2(gate, _STREAMS)
    os.closerange(_STREAMS + 1, max(int(entry.name) for entry in Path("/proc/self/fd").iterdir()) + 1)
    sys.stdin = open(0, encoding="utf-8", errors="surrogateescape", closefd=False)  # noqa: SIM115
    for number, stream in ((1, "stdout"), (2, "stderr")):
        log = open(number, "w", buffering=1, encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
        log.reconfigure(write_through=True)
        setattr(sys, stream, log)
    os.environ.clear()  # each one's copy is made here: the title is written to where the parent's were
    os.environ.update(surroundings.environment)
    for entry in reversed(surroundings.environment.get(SEARCH_PATHS[0], "").split(os.pathsep)):
        if entry and entry not in sys.path:
            sys.path.insert(0, entry)
    if surroundings.batch and os.sched_getscheduler(0) == os.SCHED_OTHER:  # else the user wants something else
        with contextlib.suppress(OSError):  # a sandbox may forbid it; the mission flies as well, only slower
            os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))  # threads that it starts inherit it
    close_gate(_STREAMS)
    quiet_start()
    unblock_signals()


def _exit_code(end: SystemExit) -> int:
    """The exit code as the interpreter would have it."""
    if end.code is None or isinstance(end.code, int):
        return (end.code or 0) & 0xFF
    print(end.code, file=sys.stderr, flush=True)
    return _FAULT


def _end_with_supervisor(began_s: float) -> None:
    while os.read(0, 1):
        pass
    try:
        sweeper.start(began_s)  # nobody else is left to do that
        time.sleep(sweeper.HEAD_START_S)
    except Exception as error:  # whatever it is, this process has to end
        print(f"the shared memory stays behind: {error}", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(sweeper.NODE_PATIENCE_S)  # the process ends within this time, or is made to
    os.kill(os.getpid(), signal.SIGKILL)
