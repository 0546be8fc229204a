"""On how many cores a batch is flown, and the threads that do it.

The kernels give up the interpreter's lock, so threads are enough. numba's own parallel loops are not used: they compile
the whole step several times over, and each of their threading layers has a rule of its own on who may call it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import config

_limit: int | None = None
_pool: ThreadPoolExecutor | None = None


def count() -> int:
    """How many cores a batch is flown on: all there are, unless NUMBA_NUM_THREADS or :func:`use` say otherwise."""
    found: int = config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]  # numba puts it there when it is imported
    return found if _limit is None else _limit


def told() -> str:
    """The same in words."""
    return "1 core" if count() == 1 else f"{count()} cores"


def use(number: int) -> None:
    """Fly the batches of this process on so many cores from now on.

    Raises:
        ValueError: for less than one.
    """
    global _limit, _pool
    if number < 1:
        raise ValueError(f"{number} cores: allowed: 1 or more")
    if _pool is not None:
        _pool.shutdown()
    _limit, _pool = number, None


def share(work: Callable[[np.ndarray], None], indices: np.ndarray) -> None:
    """Do ``work`` on all ``indices``, a part of them on each core; what one part raises is raised here.

    Args:
        work: called with a part of the indices, in several threads at once.
        indices: shape (n,).
    """
    global _pool
    parts = min(count(), len(indices))
    if parts <= 1:
        work(indices)
        return
    if _pool is None:
        _pool = ThreadPoolExecutor(count() - 1, thread_name_prefix="tethernet")
    others = [_pool.submit(work, indices[part::parts]) for part in range(1, parts)]
    try:
        work(indices[::parts])
    finally:
        for other in others:
            other.result()


def _forget() -> None:
    """A forked process has none of its parent's threads."""
    global _pool
    _pool = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
