"""Signals that end a mission early: at once while there is nothing to leave in order, later noticed where it suits."""

from __future__ import annotations

import os
import signal
from typing import Any

from tethernet_core.command import INTERRUPTED, TERMINATED
from tethernet_core.quiet_start import unblock_signals

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class MissionInterrupt(Exception):  # noqa: N818, like KeyboardInterrupt it is no error
    """The mission is to end now; the message is the signal's name."""


class Interrupts:
    """Context manager: SIGINT, SIGTERM and SIGHUP end the process at once, after :meth:`hold` they are remembered.

    A SIGHUP that is ignored stays so: that is how ``nohup`` asks for a mission that outlives its terminal.
    """

    def __init__(self) -> None:
        self.name = ""
        """Name of the first signal that came."""
        self._held = False
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Interrupts:
        for number in _SIGNALS:
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._take)
        unblock_signals()
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def hold(self) -> None:
        """From now on remember a signal instead of ending at once."""
        self._held = True

    def check(self) -> None:
        """Raises: MissionInterrupt: when a signal came."""
        if self.name:
            raise MissionInterrupt(self.name)

    def _take(self, number: int, _: object) -> None:
        if not self._held:
            os._exit(TERMINATED if number == signal.SIGTERM else INTERRUPTED)
        if not self.name:
            self.name = signal.Signals(number).name
