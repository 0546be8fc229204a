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
        self._samples: list[tuple[float, dict[str, float]]] = []
        self._names: dict[int, str] = {}
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
        return {name: seconds - first.get(name, 0.0) for name, seconds in last.items()}

    def _watch(self) -> None:
        while not self._done.wait(self._period):
            self._samples.append((time.monotonic(), self._look()))

    def _look(self) -> dict[str, float]:
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
        return {self._name(pid): used[pid] for pid in family if pid in used}

    def _name(self, pid: int) -> str:
        """The node's name where the process is one, from its command line; else what it is to this program."""
        if pid == self._pid:
            return "command"
        if pid not in self._names:
            try:
                words = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace")
            except OSError:
                words = ""
            node = _NODE.search(words)
            if node is None:
                return f"process {pid}"  # perhaps not yet what it is about to be
            self._names[pid] = node[1]
        return self._names[pid]
