"""How far a campaign is, on standard error."""

from __future__ import annotations

import sys
import time
from typing import TextIO


class Progress:
    """Says after each chunk how much is flown and how long the rest will take."""

    def __init__(self, total: int, done: int = 0, stream: TextIO | None = None):
        """Args:
        total: missions in all.
        done: of these flown earlier.
        stream: where to write; None for standard error.
        """
        self._total, self._done, self._begun_with = total, done, done
        self._errors = 0
        self._stream = stream or sys.stderr
        self._began = time.monotonic()

    def add(self, flown: int, errors: int) -> None:
        """Count missions and say where it stands.

        Args:
            flown: missions ended since the last call.
            errors: of these in error.
        """
        self._done += flown
        self._errors += errors
        elapsed = time.monotonic() - self._began
        rate = (self._done - self._begun_with) / max(elapsed, 1e-9)
        left = (self._total - self._done) / max(rate, 1e-9)
        errors_text = f", {self._errors} in error" if self._errors else ""
        text = (
            f"{self._done} of {self._total} flown{errors_text}, {_duration(elapsed)}, "
            f"{rate:.2f} missions/s, about {_duration(left)} left"
        )
        print(text, file=self._stream, flush=True)


def _duration(seconds: float) -> str:
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
