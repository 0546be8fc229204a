"""CPU time of a command and all its descendants over time, from /proc."""

from __future__ import annotations

import os
import re
import threading
import time
from pathlib import Path

_TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
_NODE = re.compile(r"__node:=(\w+)")
"""Tells a node's name on its command line."""


class CpuSampler:
    """Watches a process and its descendants from a thread; a context manager."""

    def __init__(self, pid: int, period_s: float = 0.2):
        """Args:
        pid: of the command, which has just been started.
        period_s: between two looks [s].
        """
        self.began = time.monotonic()
        """When watching began [s], time.monotonic."""
        self._pid = pid
        self._period = period_s
        self._samples: list[tuple[float, dict[int, float]]] = []
        self._names = {pid: "command"}
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> CpuSampler:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()

    def between(self, begin: float, end: float) -> dict[str, float]:
        """CPU time that each process used from one time to another [s], by node; to a sampling period exactly.

        Args:
            begin: time.monotonic [s].
            end: time.monotonic [s].
        """
        if not self._samples:
            return {}
        known = [(self.began, {}), *self._samples]
        first = min(known, key=lambda sample: abs(sample[0] - begin))[1]
        last = min(self._samples, key=lambda sample: abs(sample[0] - end))[1]
        used: dict[str, float] = {}
        for pid, seconds in last.items():
            name = self._names.get(pid, f"process {pid}")
            used[name] = used.get(name, 0.0) + seconds - first.get(pid, 0.0)
        return used

    def _watch(self) -> None:
        used: dict[int, float] = {}
        while not self._done.wait(self._period):
            used |= self._look()  # what a process that has ended used stays
            self._samples.append((time.monotonic(), dict(used)))

    def _look(self) -> dict[int, float]:
        parents, used = {}, {}
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
                except (OSError, IndexError):
                    continue  # just ended
                pid = int(entry.name)
                parents[pid] = int(fields[1])
                used[pid] = (int(fields[11]) + int(fields[12])) * _TICK_S
        family = {self._pid}
        for pid in sorted(parents):
            ancestor = pid
            while ancestor in parents and ancestor not in family:
                ancestor = parents[ancestor]
            if ancestor in family:
                family.add(pid)
        for pid in family - self._names.keys():
            self._find_name(pid)
        return {pid: used[pid] for pid in family if pid in used}

    def _find_name(self, pid: int) -> None:
        """Note the node's name where the process is one, from its command line, or what it is to this program."""
        try:
            words = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace")
        except OSError:
            return
        if node := _NODE.search(words):  # else perhaps not yet what it is about to be
            self._names[pid] = node[1]
