"""How far a long run has come, how fast it is and how long it will take, on standard error."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NoReturn, Self, TextIO, cast

if TYPE_CHECKING:
    from tqdm import tqdm

    from tethernet_sim.scenario import Outcome

LINE = "{n} of {total} {desc}{postfix}, {elapsed}, {rate_noinv_fmt}, about {remaining} left"
BAR = "{percentage:3.0f}% |{bar:10}| " + LINE


class Progress:
    """A bar on a terminal, elsewhere a line now and then; to be entered as a context, so that the bar ends with it.

    What others write to standard error meanwhile appears above the bar.
    """

    def __init__(
        self,
        what: str,
        total: int,
        done: int = 0,
        *,
        unit: str = "",
        every_s: float = 10.0,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
    ):
        """Args:
        what: is counted, in the plural.
        total: how many there will be.
        done: how many were done before this run.
        unit: of the rate; default: the first word of ``what``.
        every_s: at least so long between two lines where there is no terminal [s].
        stream: where to write; None for standard error.
        clock: for the lines [s].
        """
        self._what, self._total, self._before, self._every_s, self._clock = what, total, done, every_s, clock
        self._unit = " " + (unit or what.split(maxsplit=1)[0])
        self._stream = stream or sys.stderr
        self._bar = self._new_bar() if _can_overwrite(self._stream) else None
        self._began = self._reported = clock()
        self._open = contextlib.ExitStack()

    def __enter__(self) -> Self:
        if self._bar is not None:
            from tqdm.contrib import DummyTqdmFile

            self._open.callback(self._bar.close)
            self._open.enter_context(contextlib.redirect_stderr(cast(TextIO, DummyTqdmFile(sys.stderr))))
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def tell(self, done: int, more: str = "") -> None:
        """Args:
        done: how many are done, those before this run included.
        more: to be told too.
        """
        if self._bar is not None:
            self._bar.set_postfix_str(more, refresh=False)
            self._bar.update(done - self._bar.n)
            return
        now = self._clock()
        if done >= self._total or now - self._reported >= self._every_s:
            self._reported = now
            print(self._line(done, now - self._began, more), file=self._stream, flush=True)

    def print(self, text: str) -> None:
        """Write a line to standard output, above the bar."""
        if self._bar is not None:
            self._bar.write(text, file=sys.stdout)
        else:
            print(text, flush=True)

    def _line(self, done: int, elapsed_s: float, more: str) -> str:
        from tqdm import tqdm  # it takes 50 ms to import, and a command may have nothing to count

        return tqdm.format_meter(
            done, self._total, elapsed_s, initial=self._before, prefix=self._what, unit=self._unit, postfix=more,
            bar_format=LINE,
        )  # fmt: skip

    def _new_bar(self) -> tqdm[NoReturn]:
        from tqdm import tqdm

        tqdm.monitor_interval = 0  # it would be a thread in a process that forks workers
        return tqdm(
            total=self._total, initial=self._before, desc=self._what, unit=self._unit, file=self._stream,
            bar_format=BAR, dynamic_ncols=True, smoothing=0.0, miniters=1,
        )  # fmt: skip


class MissionProgress(Progress):
    """Of flown missions: told after each chunk, with those that ended in an error."""

    def __init__(self, total: int, done: int = 0):
        """Args:
        total: missions in all.
        done: of these flown earlier.
        """
        super().__init__("flown", total, done, unit="missions", every_s=0.0)
        self._done, self._errors = done, 0

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Count missions that have ended since the last call, and say where it stands."""
        self._done += len(outcomes)
        self._errors += sum(bool(outcome.error) for outcome in outcomes)
        self.tell(self._done, f"{self._errors} in error" if self._errors else "")


def _can_overwrite(stream: TextIO) -> bool:
    """Whether it is a terminal that can move its cursor and knows how wide it is; tqdm shows nothing where it is 0."""
    return stream.isatty() and os.environ.get("TERM") != "dumb" and os.get_terminal_size(stream.fileno()).columns > 1
