"""Which threads of a net the kernels take eight at a time, see :mod:`tethernet_sim.kernels.edge_list`."""

from __future__ import annotations

import numpy as np

from tethernet_sim.kernels.edge_list import SLACK_M, EdgeList
from tethernet_sim.kernels.lanes import COUNT

_LEAST = 3
"""Threads from which a block is faster than as many loose ones (measured)."""


def edge_list(
    nodes: int, threads: np.ndarray, rest: np.ndarray, stiffness: np.ndarray, damping: np.ndarray, dense_share: float
) -> EdgeList:
    """Order a net's threads into blocks of eight and loose ones.

    A block has threads that lead from eight nodes in a row, beginning at a multiple of eight, to nodes all the same
    number further on. Of threads between the same two nodes only the first is in a block.

    Args:
        nodes: how many there are.
        threads: nodes at both ends, shape (T, 2).
        rest: lengths [m], shape (T,).
        stiffness: [N/m], shape (T,).
        damping: [N s/m], shape (T,).
        dense_share: share of taut threads from which all blocks are evaluated.
    """
    ends = np.sort(threads, axis=1).astype(np.int64).reshape(-1, 2)
    first, lead = ends[:, 0], ends[:, 1] - ends[:, 0]
    _, once = np.unique(ends, axis=0, return_index=True)
    keys = np.stack([lead[once], first[once] // COUNT], axis=1)
    found, block_of, members = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    blocks = found[members >= _LEAST]
    number = np.cumsum(members >= _LEAST) - 1
    taken = members[block_of] >= _LEAST
    inside = once[taken]
    place = COUNT * number[block_of[taken]] + first[inside] % COUNT
    loose = np.setdiff1d(np.arange(len(ends)), inside)

    block_first = COUNT * blocks[:, 1]
    block_second = block_first + blocks[:, 0]
    begins = np.repeat(block_first, COUNT) + np.tile(np.arange(COUNT), len(blocks))
    leads = np.repeat(blocks[:, 0], COUNT)

    def placed(of_blocks: np.ndarray, values: np.ndarray) -> np.ndarray:
        filled = of_blocks.copy()
        filled[place] = values[inside]
        return np.concatenate([filled, values[loose]])

    filling = np.zeros(len(begins))
    rests = placed(filling + SLACK_M, rest)
    return EdgeList(
        nodes=nodes,
        dense_from=int(dense_share * len(inside)),
        block_first=block_first.astype(np.uint32),
        block_second=block_second.astype(np.uint32),
        first=np.concatenate([begins, ends[loose, 0]]).astype(np.uint32),
        second=np.concatenate([begins + leads, ends[loose, 1]]).astype(np.uint32),
        rest=rests,
        squared_rest=rests * rests,
        stiffness=placed(filling, stiffness),
        damping=placed(filling, damping),
    )
