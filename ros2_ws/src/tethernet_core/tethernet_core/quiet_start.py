"""The first moments of a process, before it imports anything else: nothing of the working folder gets in, no traceback
gets out.

Standard library only, and as little of it as possible: importing takes a node some tenths of a second, on a busy
machine seconds, and there is nothing to clean up yet. A module that may be run as a program calls :func:`quiet_start`
before its other imports, when it is.
"""

from __future__ import annotations

import os
import sys

# Nothing else here: it could be a file of the user's, until the working folder is left out.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping

_INTERRUPTED, _TERMINATED = 130, 143
SEARCH_PATHS = ("PYTHONPATH", "LD_LIBRARY_PATH")
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Environment variables with the number of threads that libraries for arithmetic start; read when those are loaded."""
_PACKAGES = (
    "tethernet_core",
    "tethernet_ros",
    "tethernet_control",
    "tethernet_planner",
    "tethernet_sim",
    "tethernet_learning",
    "tethernet_bringup",
)

_quiet = False
_ours: list[str] = []


def quiet_start(interrupted: int = 0, terminated: int = 0) -> None:
    """Leave the working folder out of the imports, repair the standard streams, end without a word on a signal.

    What does the work replaces the signals' handlers as soon as there is something to clean up:
    :func:`tethernet_ros.executor.run` for a node, :mod:`tethernet_core.command` for a command.

    Args:
        interrupted: exit status after SIGINT.
        terminated: exit status after SIGTERM.
    """
    global _quiet
    _quiet = True
    leave_out_working_folder()
    import signal

    for number, status in ((signal.SIGINT, interrupted), (signal.SIGTERM, terminated)):
        signal.signal(number, lambda *_, status=status: os._exit(status))
    open_standard_streams()


def command_start() -> None:
    """The same for a command: after a signal its exit status is what a shell expects."""
    quiet_start(_INTERRUPTED, _TERMINATED)
    unblock_signals()


def mission_start() -> None:
    """The same for the command of a mission, whose processes share the cores: no library makes threads of its own."""
    command_start()
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))


def unblock_signals() -> None:
    """Take the signals that ``bootstrap.launch`` holds back until there is somebody to take them."""
    import signal

    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, signal.SIGTERM, signal.SIGHUP))


def end_quiet_start() -> None:
    """Give the signals their usual effect again, where :func:`quiet_start` has changed it."""
    global _quiet
    if _quiet:
        import signal

        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        _quiet = False


def absolute_search_paths(given: Mapping[str, str]) -> dict[str, str]:
    """Environment variables without what depends on the working folder: empty and relative entries of search paths.

    A library would be looked for in the folder that the user happens to stand in.
    """
    result = dict(given)
    for name in SEARCH_PATHS:
        entries = [entry for entry in result.pop(name, "").split(os.pathsep) if os.path.isabs(entry)]
        if entries:
            result[name] = os.pathsep.join(entries)
    return result


def leave_out_working_folder() -> None:
    """Keep a file random.py in the user's working folder from being imported in a library's place.

    ``python -m`` puts that folder before all libraries, and so do empty and relative entries of PYTHONPATH. A folder
    with a package of this project in it stays, behind all others.
    """
    try:
        here = os.getcwd()
    except OSError:  # it is gone, and so is what was in it
        return
    if not sys.flags.safe_path and sys.path and os.path.join(here, sys.path[0]).rstrip(os.sep) == here.rstrip(os.sep):
        _leave_out(sys.path[0])
    pythonpath = os.environ.get("PYTHONPATH", "")
    for entry in pythonpath.split(os.pathsep) if pythonpath else []:
        while not os.path.isabs(entry) and os.path.abspath(entry) in sys.path:
            _leave_out(os.path.abspath(entry))
    sys.path += _ours
    _ours.clear()


def open_standard_streams() -> None:
    """Put the null device where standard input, output or error is closed.

    Otherwise the next file that is opened takes its number, and gets what the user should have read.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)  # the lowest free number; those below are open by now
            if null != number:
                os.dup2(null, number)
                os.close(null)
            os.set_inheritable(number, True)
        if getattr(sys, name) is None:
            stream = open(number, mode, encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
            setattr(sys, name, stream)


def _leave_out(entry: str) -> None:
    sys.path.remove(entry)
    if any(os.path.isdir(os.path.join(entry, name)) for name in _PACKAGES):
        _ours.append(entry)
