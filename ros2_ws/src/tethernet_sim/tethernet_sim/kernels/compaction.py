"""Compaction: the indices of what is flagged."""

from __future__ import annotations

import numpy as np

from tethernet_sim.kernels.options import inlined


@inlined
def list_busy(masks, busy):
    """List in ``busy`` which masks are not 0. Return how many there are.

    After all masks have been found, not while: where an index goes is known late, and loads of what comes next would
    have to wait for it, half the time (measured).
    """
    some = np.uint64(0)
    for block in range(np.uint64(len(masks))):
        busy[some] = block
        some += np.uint64(masks[block] != 0)
    return some


@inlined
def compact_indices(flags, blocks, busy, found):
    """List where ``flags`` are set. Return how many are listed.

    Without branches on single flags: which threads are taut changes so often that a processor guesses wrong (three
    times slower). Eight at a time are looked at first, because most blocks of eight have none.

    Args:
        flags: one byte each, 0 or 1, as many as a multiple of eight, (N,).
        blocks: the same bytes, eight in one, (N / 8,).
        busy: work space, unsigned, (N / 8 + 1,).
        found: output, unsigned, (N + 1,).
    """
    # Unsigned counters: numba makes sure of every signed index that it is not negative.
    some = np.uint64(0)
    for i in range(len(blocks)):
        busy[some] = i
        some += np.uint64(blocks[i] != 0)
    count = np.uint64(0)
    for j in range(some):
        begin = np.uint64(8) * np.uint64(busy[j])
        for i in range(np.uint64(8)):
            found[count] = begin + i
            count += np.uint64(flags[begin + i])
    return np.int64(count)
