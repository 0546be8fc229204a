"""What ``ps`` shows of a process that was forked: its own command line instead of its parent's.

The kernel shows what lies in the memory where a process found its arguments, and reads on into the environment behind
them where the last byte of the arguments is not zero, for those who write a longer title there. A process that writes
there must have copied its environment before.

The library setproctitle does the same, but finds the place only while nothing has been added to the environment since
the process began; commands and tests have by then, and it changes nothing without a word.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

_ARG_START, _ARG_END, _ENV_START, _ENV_END = 45, 46, 47, 48
"""Places of the addresses in /proc/self/stat behind the program's name, see proc(5)."""
_LONGEST_NAME = 15  # [bytes] of a thread's name


def show(words: Sequence[str], name: str) -> None:
    """Show a command line, cut where there is no room for it, and a short name.

    Args:
        words: of the command line.
        name: of the process.
    """
    Path("/proc/self/comm").write_bytes(name.encode()[:_LONGEST_NAME])
    fields = Path("/proc/self/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    start, end, env_start, env_end = (int(fields[at]) for at in (_ARG_START, _ARG_END, _ENV_START, _ENV_END))
    if not 0 < start < end:
        return  # the kernel does not tell
    encoded = [word.encode(errors="surrogateescape") for word in words]
    room = end - start
    text = b"\0".join(encoded)
    if len(text) >= room and env_start == end:
        room = env_end - start
        text = b" ".join(encoded)
    ctypes.memmove(start, text[: room - 1].ljust(room, b"\0"), room)
