"""Rows of numbers in memory: how long they are, and that they begin where a cache line does."""

from __future__ import annotations

import numpy as np

from tethernet_sim.kernels.options import inlined, kernel

LINE = 8
"""Numbers (of 8 bytes) in a cache line, and in a vector of the widest processors."""
VECTORS = 32
"""Numbers that an unrolled loop takes at once: loops over whole rows run to a multiple, and leave no remainder, which
would be done one by one."""
_PAGE = 512
"""Numbers in a page of memory."""
_APART = 32
"""Rows that lie a whole number of pages apart, within so many numbers, get in each other's way in the cache."""


@inlined
def padded(count):
    """The next multiple of :data:`VECTORS`."""
    return (count + (VECTORS - 1)) // VECTORS * VECTORS


@inlined
def row_width(nodes, units):
    """Room of a row with a number for each node, or for each node and unit: loops over padded rows may read beyond the
    last node, and indices of all particles fit with one to spare.
    """
    width = padded(nodes + units) + VECTORS
    beyond = width % _PAGE
    if beyond < _APART or beyond > _PAGE - _APART:
        width += 2 * _APART
    return width


@kernel
def aligned_rows(width):
    """Three rows of zeros, as wide as whole cache lines, each beginning where a line does.

    Loading a whole vector across the border of two lines costs twice as much.
    """
    store = np.zeros(3 * width + LINE)
    begin = (-(store.ctypes.data // 8)) % LINE
    return store[begin : begin + 3 * width].reshape(3, width)
