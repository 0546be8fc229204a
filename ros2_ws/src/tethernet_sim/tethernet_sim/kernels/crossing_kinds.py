"""Whether the threads of a net touch each other, as a type: what is compiled hangs on it, nothing is compiled here."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class CrossingThreads(NamedTuple):
    """The threads of a net that touch each other."""

    ends: np.ndarray  # (X, 2) knots at the ends of each


class NoCrossings(NamedTuple):
    """The same of a net whose threads pass through each other: of a type of its own, so that a flight of such a net is
    compiled without their contact.
    """

    ends: np.ndarray  # (0, 2)


Crossings = CrossingThreads | NoCrossings


def no_crossings() -> NoCrossings:
    """No threads."""
    return NoCrossings(np.zeros((0, 2), np.int64))
