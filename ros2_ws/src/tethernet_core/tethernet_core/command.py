"""How the commands of this project begin and end, whatever their streams are and whenever Ctrl-C comes.

A command's process calls :func:`tethernet_core.quiet_start.command_start` before anything else is imported, and its
``main`` is decorated with :func:`command`.
"""

import errno
import functools
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec

from tethernet_core.quiet_start import end_quiet_start, open_standard_streams
from tethernet_core.shown import shown

FAULT, USAGE = 1, 2
INTERRUPTED = 128 + signal.SIGINT
TERMINATED = 128 + signal.SIGTERM
READER_GONE = 128 + signal.SIGPIPE
LONGEST_COMPLAINT = 2000
"""[characters]."""

P = ParamSpec("P")


def command(main: Callable[P, int]) -> Callable[P, int]:
    """Decorate a command's main function: every end that is no mistake of the program is one without a traceback.

    Ctrl-C ends it with status 130, after its own cleaning up. A reader of its output that has gone away, as ``head``
    does, ends it with status 141. An operating system that refuses (a full disk, a name that is too long) is told of in
    one sentence, with status 1, or 2 where the name itself cannot be meant. Closed streams are no reason to end at all.
    """

    @functools.wraps(main)
    def run(*args: P.args, **kwargs: P.kwargs) -> int:
        open_standard_streams()
        end_quiet_start()
        try:
            status = main(*args, **kwargs)
            sys.stdout.flush()
        except KeyboardInterrupt:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second one must not turn the end into a traceback
            complain("interrupted")
            status = INTERRUPTED
        except BrokenPipeError:
            status = READER_GONE
        except OSError as error:
            complain(explain(error))
            status = USAGE if is_bad_name(error) else FAULT
        finally:  # argparse ends by SystemExit
            let_go_of_closed_streams()
        return status

    return run


def is_bad_name(error: OSError) -> bool:
    """Whether the operating system says that a name can be no file's, whatever the disk holds."""
    return error.errno in (errno.ENAMETOOLONG, errno.ELOOP, errno.EILSEQ)


def explain(error: OSError) -> str:
    """What the operating system has refused, and of what."""
    if error.filename is None:
        return str(error)
    return f"{shown(error.filename)}: {error.strerror}"


def complain(sentence: str, program: str = "") -> None:
    """Say on stderr what is wrong, under the command's name; no fault where nobody can hear it.

    Args:
        sentence: may hold what users or files have given: it is escaped and cut.
        program: the command's name; default: this process'.
    """
    name = program or Path(sys.argv[0] if sys.argv else "").name
    try:
        print(f"{name}: {shown(sentence, LONGEST_COMPLAINT)}", file=sys.stderr, flush=True)
    except OSError:
        pass


def let_go_of_closed_streams() -> None:
    """Keep the interpreter from complaining at its end about a reader that went away or a disk that is full."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            try:
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
            except (OSError, ValueError):
                continue
