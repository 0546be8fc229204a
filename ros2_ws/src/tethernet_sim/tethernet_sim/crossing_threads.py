"""Which threads of a net touch each other, in an order in which neighbours stand together."""

from __future__ import annotations

import numpy as np

from tethernet_core.system import System
from tethernet_sim.kernels.crossing_kinds import CrossingThreads

GRIP_SHARE = 0.03
"""Stiffness of the friction between two threads, as a share of their contact's: it acts along the threads too, where
the step has little to spare for it, see stability.py."""
AT_ONCE = 8
"""Threads that press on one thread at the same time, at most, as far as the largest stable step is concerned."""
_BITS = 10
"""Of a place along one axis."""


def crossing_threads(system: System) -> CrossingThreads:
    """All threads of the net: along a curve that fills space (Morton 1966), so that those that follow each other are
    near each other while the net is flat.
    """
    threads = np.array(system.net.threads, np.int64).reshape(-1, 2)
    middle = system.net.nodes[threads].mean(axis=1)
    low = middle.min(axis=0, initial=np.inf)
    size = max(float((middle.max(axis=0, initial=-np.inf) - low).max()), 1e-9) if len(threads) else 1.0
    place = ((middle - low) / size * (2**_BITS - 1)).astype(np.int64)
    code = np.zeros(len(threads), np.int64)
    for bit in range(_BITS):
        for axis in range(3):
            code |= (place[:, axis] >> bit & 1) << (3 * bit + axis)
    return CrossingThreads(threads[np.argsort(code, kind="stable")])
