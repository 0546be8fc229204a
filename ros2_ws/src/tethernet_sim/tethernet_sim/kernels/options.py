"""How the kernels are compiled: one place."""

from __future__ import annotations

import numba

FAST = {"contract", "nsz", "arcp", "reassoc"}
"""Relaxed arithmetic that keeps NaN and infinity visible: a diverging run must be seen, not optimised away."""


def kernel(function):
    """Compile a physics kernel; cached on disk, because compiling takes longer than a mission."""
    return numba.njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)(function)


def strict(function):
    """Compile with IEEE arithmetic: the same bits as the plain Python function."""
    return numba.njit(cache=True, error_model="numpy", nogil=True)(function)
