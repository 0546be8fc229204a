"""Messages that no honest node sends: random values of any message type, and honest messages with one field changed."""

from __future__ import annotations

import copy
import math
import random
import re
from typing import Any

from rosidl_parser.definition import AbstractSequence, Array, BasicType, BoundedSequence, NamespacedType

REALS = (0.0, -0.0, 1.0, -1.0, 1e-300, 1e5, -1e9, 1e200, 1e308, math.inf, -math.inf, math.nan)
TEXTS = (
    "", "launch", "map", "nominal", "rl", "/etc/hostname", "../" * 40 + "etc/passwd", "\x1b[31mred\x1b]0;title\x07",
    "ä" * 400, "x" * 100_000, "a\nb\r\n", "%s %n {0}", "/" + "a" * 300,
)  # fmt: skip
LENGTHS = (0, 1, 3, 4, 5, 8, 12, 24, 1000)


def reals(generator: random.Random) -> float:
    """A number that is seldom a sensible one."""
    return generator.choice((*REALS, generator.uniform(-1e3, 1e3), generator.gauss(0.0, 1.0)))


def wholes(generator: random.Random, bits: int, signed: bool) -> int:
    """A whole number of a type, often at its limits."""
    low, high = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if signed else (0, (1 << bits) - 1)
    return generator.choice((low, high, 0, 1, min(high, 9), min(high, 99), generator.randint(low, high)))


def fill(message: Any, generator: random.Random) -> Any:
    """Give every field of a message, nested ones too, a random value of its type; returns the message."""
    for name in fields(message):
        setattr(message, name, _value(_slot(message, name), getattr(message, name), generator))
    return message


def mutate(message: Any, generator: random.Random) -> Any:
    """A copy of a message with one field, at any depth, changed to a random value of its type."""
    changed = copy.deepcopy(message)
    target = changed
    while True:
        name = generator.choice(fields(target))
        value = getattr(target, name)
        if hasattr(value, "get_fields_and_field_types") and generator.random() < 0.9:
            target = value
            continue
        setattr(target, name, _value(_slot(target, name), value, generator))
        return changed


def fields(message: Any) -> list[str]:
    """Names of a message's fields."""
    return list(message.get_fields_and_field_types())


def _slot(message: Any, name: str) -> Any:
    return type(message).SLOT_TYPES[fields(message).index(name)]


def _value(slot: Any, old: Any, generator: random.Random) -> Any:
    if isinstance(slot, Array):
        return [_value(slot.value_type, None, generator) for _ in range(slot.size)]
    if isinstance(slot, AbstractSequence):
        length = generator.choice((*LENGTHS, len(old) if old is not None else 2))
        if isinstance(slot, BoundedSequence):
            length = min(length, slot.maximum_size)
        if isinstance(slot.value_type, NamespacedType):
            length = min(length, 24)
        return [_value(slot.value_type, None, generator) for _ in range(length)]
    if isinstance(slot, NamespacedType):
        return fill(_new(slot) if old is None else type(old)(), generator)
    if isinstance(slot, BasicType):
        return _basic(slot.typename, generator)
    return generator.choice(TEXTS)


def _new(slot: NamespacedType) -> Any:
    import importlib

    return getattr(importlib.import_module(".".join(slot.namespaces)), slot.name)()


def _basic(typename: str, generator: random.Random) -> Any:
    if typename == "boolean":
        return generator.random() < 0.5
    if typename in ("float", "double"):
        value = reals(generator)
        return value if typename == "double" or not math.isfinite(value) or abs(value) < 3e38 else math.inf
    if typename == "octet":
        return bytes([generator.randrange(256)])
    signed, bits = re.fullmatch(r"(u?)int(\d+)", typename).groups()
    return wholes(generator, int(bits), not signed)
