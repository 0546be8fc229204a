"""Lines that tell how far a long run has come, how fast it is and how long it will take."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable


class Progress:
    """Tells on standard error, not more often than every ``every_s``."""

    def __init__(
        self, what: str, total: int, done: int = 0, every_s: float = 10.0, clock: Callable[[], float] = time.monotonic
    ):
        """Args:
        what: is counted, in the plural.
        total: how many there will be.
        done: how many were done before this run.
        every_s: at least so long between two lines [s].
        clock: [s].
        """
        self._what, self._total, self._before, self._every_s, self._clock = what, total, done, every_s, clock
        self._began = self._reported = clock()

    def tell(self, done: int, more: str = "") -> None:
        """Args:
        done: how many are done, those before this run included.
        more: to be told too.
        """
        now = self._clock()
        if done < self._total and now - self._reported < self._every_s:
            return
        self._reported = now
        rate = (done - self._before) / max(now - self._began, 1e-9)
        left = (self._total - done) / rate if rate > 0 else float("nan")
        line = f"{done} of {self._total} {self._what}, {rate:.2f} per s, about {left:.0f} s left"
        print(f"{line}, {more}" if more else line, file=sys.stderr, flush=True)
