"""The end of this process at a given time, whatever holds it up: a last resort for what may hang outside Python."""

from __future__ import annotations

import ctypes
import os
from types import TracebackType

_CLOCK_MONOTONIC = 1
_SIGEV_THREAD = 2


class _Notice(ctypes.Structure):
    """C's struct sigevent, as Linux and its C libraries lay it out."""

    _fields_ = (
        ("value", ctypes.c_void_p),
        ("signal", ctypes.c_int),
        ("kind", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("rest", ctypes.c_char * 32),
    )


class _Span(ctypes.Structure):
    """C's struct itimerspec."""

    _fields_ = (
        ("period_s", ctypes.c_long),
        ("period_ns", ctypes.c_long),
        ("first_s", ctypes.c_long),
        ("first_ns", ctypes.c_long),
    )


class Deadline:
    """Ends this process with an exit status, unless what stands in its ``with`` block is done before.

    No Python runs at the end: a timer of the C library calls C's ``_exit(status)`` in a thread of its own, so that it
    does not matter who holds the interpreter's lock. Afterwards nothing of it is left, and the process has the exit
    status that it gives itself.
    """

    def __init__(self, seconds: float, status: int):
        """Args:
        seconds: from entering the block [s].
        status: exit status of the process then.
        """
        self._seconds, self._status = seconds, status
        self._timer = ctypes.c_void_p()
        self._libc = ctypes.CDLL(None, use_errno=True)

    def __enter__(self) -> Deadline:
        end = ctypes.cast(self._libc._exit, ctypes.c_void_p)
        notice = _Notice(value=self._status, kind=_SIGEV_THREAD, function=end)
        self._check(self._libc.timer_create(_CLOCK_MONOTONIC, ctypes.byref(notice), ctypes.byref(self._timer)))
        whole = int(self._seconds)
        span = _Span(first_s=whole, first_ns=round((self._seconds - whole) * 1e9))
        self._check(self._libc.timer_settime(self._timer, 0, ctypes.byref(span), None))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._libc.timer_delete(self._timer)

    @staticmethod
    def _check(result: int) -> None:
        if result != 0:
            number = ctypes.get_errno()
            raise OSError(number, f"no timer to be had: {os.strerror(number)}")
