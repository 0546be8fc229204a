"""Saying that the kernels are being compiled: for a minute nothing else would tell a busy process from a dead one."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

COMPILING = "compiling the physics kernels"
COMPILED = "compiled the physics kernels"

_said = False
"""Whether such a block is open."""


@contextlib.contextmanager
def compiling_said(say: Callable[[str], None] | None = None) -> Iterator[None]:
    """Say it when a kernel is compiled within this block, which numba's cache does not have; within another such block
    that one says it.

    Args:
        say: called with :data:`COMPILING` before the first one is compiled, with :data:`COMPILED` at the end of the
            block, and not at all where all are in the cache; None: a line each on standard error.
    """
    from numba.core import event

    global _said
    if _said:
        yield
        return
    told = _to_stderr if say is None else say

    class Watch(event.Listener):
        began: float | None = None

        def on_start(self, _: Any) -> None:
            if self.began is None:
                self.began = time.perf_counter()
                told(f"{COMPILING}: about a minute, this once")

        def on_end(self, _: Any) -> None:
            pass

    watch, _said = Watch(), True
    try:
        with event.install_listener("numba:compile", watch):
            yield
    finally:
        _said = False
        if watch.began is not None:
            told(f"{COMPILED} in {time.perf_counter() - watch.began:.0f} s")


def _to_stderr(text: str) -> None:
    if sys.stderr is not None:
        print(text, file=sys.stderr, flush=True)
