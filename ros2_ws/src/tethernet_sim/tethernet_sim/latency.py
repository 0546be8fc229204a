"""How long answers take, counted in bounded memory."""

from __future__ import annotations

import math

RESOLUTION = 0.02
"""Quantiles are right within 2 %."""

_SHORTEST_S, _LONGEST_S = 1e-6, 1e3
_BINS = math.ceil(math.log(_LONGEST_S / _SHORTEST_S) / math.log1p(RESOLUTION))


class LatencyCount:
    """Counts durations in bins that are 2 % wide, from a microsecond to a quarter of an hour; what is shorter or longer
    counts in the first or the last. It takes as much memory after an hour as after a second.
    """

    def __init__(self) -> None:
        self.count = 0
        self.longest_s = 0.0
        """Exact [s]."""
        self._bins = [0] * (_BINS + 1)

    def add(self, duration_s: float) -> None:
        """Count one duration [s]."""
        place = math.log(max(duration_s, _SHORTEST_S) / _SHORTEST_S) / math.log1p(RESOLUTION)
        self._bins[min(int(place), _BINS)] += 1
        self.count += 1
        self.longest_s = max(self.longest_s, duration_s)

    def quantile(self, share: float) -> float:
        """The duration [s] that ``share`` (0..1) of all do not exceed, within 2 %; never more than the longest; 0 where
        there is none.
        """
        wanted, seen = max(1, math.ceil(share * self.count)), 0
        for place, number in enumerate(self._bins):
            seen += number
            if seen >= wanted:
                return min(_SHORTEST_S * (1.0 + RESOLUTION) ** (place + 1), self.longest_s)
        return 0.0
