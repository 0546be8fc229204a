"""Checks of single fields of messages, which say what was given and what is allowed."""

from __future__ import annotations

from typing import Any

from tethernet_ros.well_formed import Message, MessageError


def one_of(name: str, value: Any, allowed: Any) -> None:
    """Check that a value is among those that are allowed, a range or a sequence.

    Raises:
        MessageError: when it is not.
    """
    if value not in allowed:
        what = f"{allowed[0]} to {allowed[-1]}" if isinstance(allowed, range) else " or ".join(map(str, allowed))
        raise MessageError(f"{name} is {value!r}; allowed: {what}")


def not_negative(message: Message, *names: str) -> None:
    """Check that fields of a message are not below 0.

    Raises:
        MessageError: naming the first that is.
    """
    for name in names:
        value = getattr(message, name)
        if value < 0.0:
            raise MessageError(f"{name} is {value:g}; allowed: 0 and more")


def within(name: str, value: float, limit: float, unit: str) -> None:
    """Check that a value lies between 0 and a limit.

    Raises:
        MessageError: for a value that is negative, beyond the limit or NaN.
    """
    if not 0.0 <= value <= limit:  # also catches NaN
        raise MessageError(f"{name} is {value:g} {unit}".rstrip() + f"; allowed: 0 to {limit:g}")
