"""Work space of the contact of net with net, and what a touching pair remembers in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tethernet_sim.kernels import lanes
from tethernet_sim.kernels.options import inlined, kernel
from tethernet_sim.kernels.rows import padded

BLOCK = lanes.COUNT
"""Threads in a block."""
PAIRS_PER_THREAD = 12
"""Listed pairs that there is room for at first; where a net that unfolds has more, room is made."""
LISTED, NEAR, MADE, LOOK_IN, TOUCHING, RECORDS = range(6)
"""Entries of the counts: listed pairs, near pairs, whether there are lists; steps until the next look, pairs that touch
in this step, records of touching pairs that are not in the lists yet."""
MEMORY = 7
"""Numbers that a touching pair remembers: its normal, x y z; the distance at which it touches [m], then the bristle of
its friction, x y z [m], launch frame."""
RECORD = 2 + MEMORY
"""Numbers of a touching pair in a state: its two threads and what it remembers."""


class CrossingWork(NamedTuple):
    """Work space of one scenario, for X threads and room for P pairs; two lists: 0 the listed, 1 the near pairs."""

    counts: np.ndarray  # (6,) see LISTED
    frame: np.ndarray  # (2, 6) velocity of the net when each list was made [m/s], how far it has come since [m]
    place: np.ndarray  # (2, 3, width) where the knots were then [m]
    leave: np.ndarray  # (2, width) how far from there, in that frame, each may come [m]
    thread_leave: np.ndarray  # (2, X) that of the thread's faster end [m]
    box: np.ndarray  # (6, blocks BLOCK) least and largest x, y, z of each thread, its leave included [m]
    block_box: np.ndarray  # (6, .) of each block; what fills up both overlaps with nothing
    close: np.ndarray  # (blocks + BLOCK,) blocks that overlap with the one that is looked at
    found: np.ndarray  # (blocks BLOCK + BLOCK,) threads that overlap with the one that is looked at
    candidates: np.ndarray  # (2, C) threads of pairs whose boxes overlap, until there are many
    candidate_ends: np.ndarray  # (4, C) their knots
    candidate_record: np.ndarray  # (C,) their records, -1: none
    head: np.ndarray  # (X,) first record of each thread that is the first of its pair, -1: none
    threads: np.ndarray  # (2, P) of each listed pair
    ends: np.ndarray  # (4, P) its knots: of the first thread, then of the second
    memory: np.ndarray  # (MEMORY, P)
    remembers: np.ndarray  # (P,) whether it touches
    near: np.ndarray  # (P + BLOCK,) listed pairs that are near
    near_ends: np.ndarray  # (4, P) their knots
    near_remembers: np.ndarray  # (P,) whether they touch
    hits: np.ndarray  # (P + BLOCK,) near pairs that touch
    push: np.ndarray  # (12, P) velocity that each end of these gains in one step [m/s], x y z of each
    records: np.ndarray  # (P, RECORD) touching pairs while the lists are made
    next: np.ndarray  # (P,) record of the same first thread, -1: none


@inlined
def blocks(count):
    """Blocks that hold so many."""
    return (count + (BLOCK - 1)) // BLOCK


@inlined
def fill_up(rows, count):
    """Let what stands behind the ``count`` numbers of each row, which are taken eight by eight, be indices too."""
    for row in range(len(rows)):
        for p in range(count, min(count + BLOCK, rows.shape[1])):
            rows[row, p] = 0


@inlined
def room(threads, records):
    """Pairs to begin with room for."""
    return PAIRS_PER_THREAD * threads + records


@kernel
def workspace(threads, width, pairs):
    """Work space for one scenario: so many threads and ``pairs``; ``width`` is the room of a row of coordinates."""
    count, room, some = blocks(threads), padded(pairs), padded(2 * threads + BLOCK)
    box, block_box = np.full((6, count * BLOCK), -np.inf), np.full((6, blocks(count) * BLOCK), -np.inf)
    box[::2], block_box[::2] = np.inf, np.inf
    return CrossingWork(
        np.zeros(6, np.int64), np.zeros((2, 6)), np.zeros((2, 3, width)), np.zeros((2, width)), np.zeros((2, threads)),
        box, block_box, np.empty(count + BLOCK, np.uint32), np.empty(count * BLOCK + BLOCK, np.uint32),
        np.empty((2, some), np.uint32), np.empty((4, some), np.uint32), np.empty(some),
        np.full(threads, -1, np.int64), np.empty((2, room), np.uint32),
        np.empty((4, room), np.uint32), np.empty((MEMORY, room)), np.empty(room, np.uint8),
        np.empty(room + BLOCK, np.uint32), np.empty((4, room), np.uint32), np.empty(room, np.uint8),
        np.empty(room + BLOCK, np.uint32), np.empty((12, room)), np.empty((room, RECORD)), np.empty(room, np.int64),
    )  # fmt: skip


@kernel
def with_room(work, pairs):
    """Work space with more room; the records are kept, lists have to be made."""
    width, threads, records = work.place.shape[2], len(work.head), work.counts[RECORDS]
    larger = workspace(threads, width, pairs)
    larger.counts[RECORDS] = records
    larger.records[:records] = work.records[:records]
    return larger


@inlined
def store(work, records):
    """Write the pairs that remember something to ``records`` (., RECORD), as many as there is room for.

    Returns:
        How many there are.
    """
    count, room = 0, len(records)
    for n in range(work.counts[NEAR]):
        if work.near_remembers[n]:
            if count < room:
                p = work.near[n]
                records[count, 0], records[count, 1] = work.threads[0, p], work.threads[1, p]
                for number in range(MEMORY):
                    records[count, 2 + number] = work.memory[number, p]
            count += 1
    return count
