"""Fast DDS keeps its shared-memory segments in /dev/shm and leaves them there when a process is killed.

Only segments that our own processes held are removed, and only once no living process holds them. The ports below 7400
belong to no domain: whatever runs on this machine takes the next free one and puts a dead one right, so they stay.
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from collections.abc import Iterable
from pathlib import Path

FOLDER = Path("/dev/shm")
_FIRST_DOMAIN_PORT = 7400
YOUNG_S = 1.0
"""[s] A segment that is younger may not have been locked by its owner yet."""
_TICK_S = 0.02
"""[s] Times of files are those of the kernel's last tick: at most so much earlier than the clock."""
_NAME = re.compile(r"/(fastrtps_(?:[0-9a-f]{16}|port(\d+)))$")


def held_by(pids: Iterable[int]) -> set[str]:
    """Names of the segments that these processes map."""
    names = set()
    for pid in pids:
        try:
            with Path(f"/proc/{pid}/maps").open(encoding="utf-8", errors="replace") as file:
                paths = {line.split(None, 5)[-1].rstrip("\n") for line in file if "/fastrtps_" in line}
        except OSError:  # gone meanwhile
            continue
        for found in filter(None, (_NAME.search(path) for path in paths if path.startswith(f"{FOLDER}/"))):
            if found[2] is None or int(found[2]) >= _FIRST_DOMAIN_PORT:
                names.add(found[1])
    return names


def made_since(time_s: float, least_age_s: float | None = None) -> set[str]:
    """Names of this user's segments and domain ports that were made after a time, and not just now.

    Where a process was killed before anybody noted its segment, or came no further than half a port for want of file
    handles, only the age tells whose mission it was. A living owner's is kept by :func:`clean`.

    Args:
        time_s: seconds since the epoch.
        least_age_s: what is younger is left out [s], by default :data:`YOUNG_S`.
    """
    found = set()
    newest_s = time.time() - (YOUNG_S if least_age_s is None else least_age_s)
    for path in FOLDER.glob("fastrtps_*"):
        name = _NAME.search(f"/{path.name}")
        try:
            there = path.stat()
        except OSError:  # gone meanwhile
            continue
        ours = name and (name[2] is None or int(name[2]) >= _FIRST_DOMAIN_PORT) and there.st_uid == os.getuid()
        if ours and time_s - _TICK_S < there.st_ctime < newest_s:
            found.add(path.name)
    return found


def left_since(time_s: float) -> set[str]:
    """Names of all that may be left of processes of which nobody has noted what they hold, see the functions below.

    Args:
        time_s: seconds since the epoch, before the first of them was started.
    """
    return made_since(time_s) | abandoned_locks()


def abandoned_locks() -> set[str]:
    """Names of this user's domain ports of which only a lock is there, as a goodbye to a dead process makes it."""
    found = set()
    for path in FOLDER.glob("fastrtps_port*_el"):
        name = _NAME.search(f"/{path.name.removesuffix('_el')}")
        if name and name[2] is not None and int(name[2]) >= _FIRST_DOMAIN_PORT and not (FOLDER / name[1]).exists():
            try:
                if path.stat().st_uid == os.getuid():
                    found.add(name[1])
            except OSError:  # gone meanwhile
                continue
    return found


def clean(names: Iterable[str]) -> list[str]:
    """Remove those segments that nobody holds any more, with their lock and semaphore files.

    Args:
        names: from :func:`held_by`, when the processes were alive.

    Returns:
        The names of the segments removed.
    """
    removed = sorted(_unheld(names))
    for name in removed:
        for path in _files(name):
            try:
                path.unlink(missing_ok=True)
            except OSError:  # another user's
                continue
    return removed


def clean_with_the_young(names: Iterable[str], time_s: float) -> list[str]:
    """Remove those segments that nobody holds any more, and all that is left of the time since then; where something
    was made just now and nobody seems to hold it, as by a node that was killed at once, wait until that is sure.

    Args:
        names: as of :func:`clean`.
        time_s: as of :func:`left_since`.

    Returns:
        The names of the segments removed.
    """
    known = set(names)
    if _unheld(made_since(time_s, -_TICK_S) - known - left_since(time_s)):
        time.sleep(YOUNG_S + _TICK_S)
    return clean(known | left_since(time_s))


def _unheld(names: Iterable[str]) -> set[str]:
    """Those of the segments of which something is there that no other process maps and none owns."""
    # A node's goodbye to one that was killed may make a lock's file anew, and nothing else.
    left = {name for name in names if any(path.exists() for path in _files(name))}
    if not left:
        return left
    # This process may still map what belonged to the dead; what it owns itself is locked.
    others = {int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit()} - {os.getpid()}
    return {name for name in left - held_by(others) if not _locked(name)}


def _files(name: str) -> list[Path]:
    return [FOLDER / name, *_locks(name), FOLDER / f"sem.{name}_mutex"]


def _locks(name: str) -> list[Path]:
    return [FOLDER / f"{name}_el", FOLDER / f"{name}_sl"]


def _locked(name: str) -> bool:
    """Whether a living process, perhaps one that this user or container does not see, owns the segment."""
    for path in _locks(name):
        try:
            with path.open("rb") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except FileNotFoundError:
            continue
        except OSError:
            return True
    return False
