"""What holds for a message of any type: numbers are finite, stamps are times, texts have an end.

The rules are derived from the type's own description, once for each type, so that no field can be forgotten.
"""

from __future__ import annotations

import functools
import importlib
import math
from collections.abc import Callable
from itertools import chain
from operator import attrgetter
from typing import Any, ClassVar, Protocol

import numpy as np
from builtin_interfaces.msg import Time
from rosidl_parser.definition import AbstractNestedType, AbstractString, AbstractWString, BasicType, NamespacedType

LONGEST_TEXT = 4096
"""Of any text in a message [characters]: a policy may be named by its path, and no path is longer."""

_FLOATS = frozenset(("float", "double", "long double"))
_SECOND_NS = 1_000_000_000


class MessageError(ValueError):
    """A message breaks the contract of its topic and is not used."""


class Message(Protocol):
    """What all ROS messages have in common."""

    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    """Types of the fields, as rosidl describes them."""

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Names of the fields, and their types in words."""


@functools.cache
def _plan(kind: type[Message]) -> _Plan:
    return _Plan(kind)


class _Plan:
    """Where the fields of one message type are that have to be looked at."""

    def __init__(self, kind: type[Message]):
        self.numbers: list[str] = []
        self.number_arrays: list[str] = []
        self.texts: list[str] = []
        self.text_arrays: list[str] = []
        self.stamps: list[str] = []
        self.arrays: list[tuple[str, _Plan]] = []
        self._visit(kind, "")
        self.all_numbers = _getter(self.numbers)
        self.all_texts = _getter(self.texts)
        self.all_times = _getter([f"{stamp}.{part}" for stamp in self.stamps for part in ("sec", "nanosec")])

    def _visit(self, kind: type[Message], prefix: str) -> None:
        for name, slot in zip(kind.get_fields_and_field_types(), kind.SLOT_TYPES, strict=True):
            path = prefix + name
            several = isinstance(slot, AbstractNestedType)
            value = slot.value_type if several else slot
            if isinstance(value, BasicType):
                if value.typename in _FLOATS:
                    (self.number_arrays if several else self.numbers).append(path)
            elif isinstance(value, AbstractString | AbstractWString):
                (self.text_arrays if several else self.texts).append(path)
            elif isinstance(value, NamespacedType):
                part = getattr(importlib.import_module(".".join(value.namespaces)), value.name)
                if several:
                    self.arrays.append((path, _plan(part)))
                elif part is Time:
                    self.stamps.append(path)
                else:
                    self._visit(part, path + ".")


def _getter(paths: list[str]) -> Callable[[Message], tuple[Any, ...]]:
    if len(paths) > 1:
        return attrgetter(*paths)
    return (lambda message: (attrgetter(paths[0])(message),)) if paths else lambda message: ()


def not_finite(message: Message) -> str:
    """The first field of a message that is NaN or infinite, with its value; empty where all numbers are finite.

    Args:
        message: of any ROS message type.
    """
    return _not_finite(_plan(type(message)), message)


def _not_finite(plan: _Plan, message: Message) -> str:
    if not all(map(math.isfinite, plan.all_numbers(message))):
        for path, value in zip(plan.numbers, plan.all_numbers(message), strict=True):
            if not math.isfinite(value):
                return f"{path} is {value:g}"
    for path in plan.number_arrays:
        values = np.asarray(attrgetter(path)(message))
        if len(values) and not np.isfinite(values).all():
            index = int(np.argmin(np.isfinite(values)))
            return f"{path}[{index}] is {values[index]:g}"
    for path, part in plan.arrays:
        elements = attrgetter(path)(message)
        flat = not part.arrays and not part.number_arrays
        if flat and all(map(math.isfinite, chain.from_iterable(map(part.all_numbers, elements)))):
            continue  # thousands of points: no call for each of them
        for index, element in enumerate(elements):
            if found := _not_finite(part, element):
                return f"{path}[{index}].{found}"
    return ""


def check_well_formed(message: Message) -> None:
    """Check all that holds for a message of any type.

    Raises:
        MessageError: for a number that is not finite, a stamp that is no time, or a text without end; names the field.
    """
    if found := not_finite(message):
        raise MessageError(f"{found}; allowed: finite numbers")
    _check_rest(_plan(type(message)), message, "")


def _check_rest(plan: _Plan, message: Message, prefix: str) -> None:
    times = plan.all_times(message)
    for path, seconds, nanoseconds in zip(plan.stamps, times[::2], times[1::2], strict=True):
        check_stamp(seconds, nanoseconds, prefix + path)
    for path, text in zip(plan.texts, plan.all_texts(message), strict=True):
        check_text(text, LONGEST_TEXT, prefix + path)
    for path in plan.text_arrays:
        for text in attrgetter(path)(message):
            check_text(text, LONGEST_TEXT, prefix + path)
    for path, part in plan.arrays:
        for index, element in enumerate(attrgetter(path)(message)):
            _check_rest(part, element, f"{prefix}{path}[{index}].")


def check_stamp(seconds: int, nanoseconds: int, name: str = "stamp") -> int:
    """A stamp as one number [ns].

    Args:
        seconds: of the stamp.
        nanoseconds: of the stamp.
        name: of the field, for the error.

    Raises:
        MessageError: for a time before the clock's zero, or a billion nanoseconds and more.
    """
    if seconds < 0 or nanoseconds >= _SECOND_NS:
        raise MessageError(f"{name} is {seconds} s and {nanoseconds} ns; allowed: from 0 s on, less than 1e9 ns")
    return seconds * _SECOND_NS + nanoseconds


def check_text(text: str, limit: int, name: str) -> str:
    """The text itself, when it is no longer than the limit [characters].

    Raises:
        MessageError: when it is longer.
    """
    if len(text) > limit:
        raise MessageError(f"{name} has {len(text)} characters; allowed: up to {limit}")
    return text
