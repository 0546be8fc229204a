"""Which threads of a system touch the debris, and how hard their contact is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tethernet_core.system import System

KNOT_SHARE = 0.2
"""Of the stiffness of contact that is a knot's where threads touch too; its threads have the rest together: as much
each in a net of squares.
"""
LONGEST_STRETCH = 1.1
"""No thread is longer than this factor times its rest length: what nets are made of breaks at 3 to 5 %."""


@dataclass(frozen=True)
class TouchingThreads:
    """The net's threads, the units' threads, then the closing threads from one node of the ring to the next."""

    ends: np.ndarray  # (S, 2) particles
    share: np.ndarray  # (S,) stiffness of its contact as a share of what physics.contact_stiffness_n_m says
    """A knot with all its threads is as hard as a knot that touches alone, so that threads need no smaller step."""
    knot_share: float
    """Stiffness of a knot's own contact, likewise."""
    damping_share: float
    """Of physics.contact_damping_ratio that each of these contacts has: together they dampen a knot as one alone."""
    open_count: int
    """Without the closing threads."""
    longest_m: float
    """Of the longest one, stretched as far as any [m]."""

    @classmethod
    def none(cls) -> TouchingThreads:
        """Where only knots and units touch."""
        return cls(np.zeros((0, 2), np.int64), np.zeros(0), 1.0, 1.0, 0, 0.0)


def touching_threads(system: System) -> TouchingThreads:
    """The threads of a system that touch its debris."""
    net, nodes = system.net, system.net.node_count
    units = [(unit.node, nodes + m) for m, unit in enumerate(system.units)]
    own = np.concatenate([np.array(net.threads, np.int64), np.array(units, np.int64).reshape(-1, 2)])
    rest = np.concatenate([net.rest_lengths, [unit.thread_length_m for unit in system.units]])
    winches = system.closing.kind == "winch"
    closing = np.array(system.closing.pairs, np.int64) if winches else np.zeros((0, 2), np.int64)
    ends = np.concatenate([own, closing])
    place = np.concatenate([net.nodes, [net.nodes[unit.node] for unit in system.units] or np.zeros((0, 3))])
    flat = np.linalg.norm(place[closing[:, 1]] - place[closing[:, 0]], axis=1)
    degree = np.bincount(ends.ravel(), minlength=nodes + len(units))
    return TouchingThreads(
        ends=ends,
        share=(1.0 - KNOT_SHARE) / degree[ends].max(axis=1),
        knot_share=KNOT_SHARE,
        # Dampers go with the roots of the stiffnesses, and n threads share theirs.
        damping_share=1.0 / (math.sqrt(KNOT_SHARE) + math.sqrt((1.0 - KNOT_SHARE) * degree.max())),
        open_count=len(own),
        longest_m=LONGEST_STRETCH * float(np.concatenate([rest, flat]).max()),
    )
