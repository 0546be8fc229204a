"""Signals that end a mission early, noticed where it suits."""

from __future__ import annotations

import signal

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class MissionInterrupt(Exception):  # noqa: N818, like KeyboardInterrupt it is no error
    """The mission is to end now; the message is the signal's name."""


class Interrupts:
    """Context manager: SIGINT, SIGTERM and SIGHUP are remembered instead of killing the process."""

    def __init__(self):
        self.name = ""
        """Name of the first signal that came."""
        self._before = {}

    def __enter__(self) -> Interrupts:
        for number in _SIGNALS:
            self._before[number] = signal.signal(number, self._remember)
        return self

    def __exit__(self, *_) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def check(self) -> None:
        """Raises: MissionInterrupt: when a signal came."""
        if self.name:
            raise MissionInterrupt(self.name)

    def _remember(self, number: int, _) -> None:
        if not self.name:
            self.name = signal.Signals(number).name
