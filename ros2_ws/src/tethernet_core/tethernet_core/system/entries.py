"""Entries of a description: dataclass fields with type, unit, range and meaning, read from a mapping with errors that
name the entry's full path.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import typing
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from ..near_match import near_match
from .errors import Findings, Place

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")


def entry(
    description: str,
    *,
    unit: str = "-",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
    size: int | None = None,
    form: str = "",
    default: Any = dataclasses.MISSING,
    default_text: str = "",
) -> Any:
    """Describe a dataclass field as an entry of a section.

    Args:
        description: what it is.
        unit: SI unit, or "-".
        low: smallest allowed value.
        high: largest allowed value.
        choices: allowed values of a text.
        size: how many numbers an array has; None: any number.
        form: what is allowed in words, for entries that have a form of their own.
        default: value where the entry is not given; without one it must be given.
        default_text: the default in words, where it is derived.
    """
    return dataclasses.field(
        default=default,
        metadata={
            "description": description, "unit": unit, "low": low, "high": high, "choices": choices, "size": size,
            "form": form, "default_text": default_text,
        },
    )  # fmt: skip


@functools.cache
def entry_kinds(cls: type) -> dict[str, Any]:
    """Entries of a section with their types: float, int, bool, str, tuple (of numbers) or Any (a form of its own)."""
    hints = typing.get_type_hints(cls)
    kinds = {}
    for field in dataclasses.fields(cls):
        kind = hints[field.name]
        if type(None) in typing.get_args(kind):
            kind = next(part for part in typing.get_args(kind) if part is not type(None))
        kinds[field.name] = tuple if typing.get_origin(kind) is tuple else kind
    return kinds


def allowed_text(field: dataclasses.Field[Any], kind: Any) -> str:
    """The allowed values of an entry in words."""
    meta = field.metadata
    if meta["form"]:
        return str(meta["form"])
    if meta["choices"]:
        return "one of " + ", ".join(meta["choices"])
    if kind in (str, bool):
        return {str: "text", bool: "true or false"}[kind]
    unit = "" if meta["unit"] == "-" else f" {meta['unit']}"
    noun = "whole number" if kind is int else "number"
    low, high = meta["low"], meta["high"]
    if low is not None and high is not None:
        bounds = f"{low:g} to {high:g}{unit}"
    elif low is not None:
        bounds = f"at least {low:g}{unit}"
    else:
        bounds = f"any finite {noun}{' in' + unit if unit else ''}"
    if kind is tuple:
        return f"{meta['size'] or 'a list of'} numbers, each {bounds}"
    return bounds


def check_keys(content: Any, names: typing.Iterable[str], place: Place, noun: str = "entry") -> Mapping[str, Any]:
    """Make sure that ``content`` is a mapping with none but these keys.

    Raises:
        DescriptionError: naming the unknown key, near matches and what is allowed.
    """
    names = list(names)
    if not isinstance(content, Mapping):
        raise place.error(content, "not a mapping of entries", ", ".join(names))
    found = Findings()
    for key in content:
        if key not in names:
            with found.collected():
                raise (place / str(key)).problem(f"unknown {noun}{near_match(key, names)}", ", ".join(names))
    found.raise_them()
    return content


def read_section(cls: type[T], content: Any, place: Place) -> T:
    """Make a section from its mapping; an entry given as null has its default.

    Raises:
        DescriptionError: for an unknown or missing entry, a wrong type, a value out of range.
    """
    kinds = entry_kinds(cls)
    fields = {field.name: field for field in dataclasses.fields(cls)}
    found = Findings()
    with found.collected():
        check_keys(content, kinds, place)
    if not isinstance(content, Mapping):
        found.raise_them()
    values: dict[str, Any] = {}
    for name, field in fields.items():
        value = content.get(name)
        with found.collected():
            if value is not None:
                values[name] = check_value(value, field, kinds[name], place / name)
            elif field.default is dataclasses.MISSING:
                raise (place / name).problem("is missing", allowed_text(field, kinds[name]))
    found.raise_them()
    return cls(**values)


def check_given(cls: type, content: Mapping[str, Any], place: Place) -> None:
    """Check the values that a mapping gives of a section's entries, whether or not it gives all.

    Raises:
        DescriptionError: for a wrong type or a value out of range.
    """
    kinds, found = entry_kinds(cls), Findings()
    for field in dataclasses.fields(cls):
        if (value := content.get(field.name)) is not None:
            with found.collected():
                check_value(value, field, kinds[field.name], place / field.name)
    found.raise_them()


def check_value(value: Any, field: dataclasses.Field[Any], kind: Any, place: Place) -> Any:
    """The value of an entry as its type, checked.

    Raises:
        DescriptionError: for a wrong type or a value out of range.
    """
    allowed = allowed_text(field, kind)
    meta = field.metadata
    if kind is Any:
        return value
    if kind is tuple:
        if not isinstance(value, list | tuple):
            raise place.error(value, "not a list of numbers", allowed)
        if meta["size"] is not None and len(value) != meta["size"]:
            raise place.error(value, f"has {len(value)} numbers", allowed)
        return tuple(_number(item, field, place[i], allowed) for i, item in enumerate(value))
    if kind is float:
        return _number(value, field, place, allowed)
    if kind is int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise place.error(value, "not a whole number", allowed)
        if not _in_range(value, field):
            raise place.error(value, "out of range", allowed)
        return value
    if not isinstance(value, kind):
        raise place.error(value, "not text" if kind is str else "neither true nor false", allowed)
    if meta["choices"] and value not in meta["choices"]:
        raise place.error(value, f"unknown{near_match(value, meta['choices'])}", allowed)
    return value


def _number(value: Any, field: dataclasses.Field[Any], place: Place, allowed: str) -> float:
    number = finite(value, place, allowed)
    if not _in_range(number, field):
        raise place.error(value, "out of range", allowed)
    return number


def finite(value: Any, place: Place, allowed: str) -> float:
    """A finite number.

    Raises:
        DescriptionError: for anything else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise place.error(value, "not a number", allowed)
    try:
        number = float(value)
    except OverflowError:  # a whole number with more digits than a float has
        number = math.inf
    if not math.isfinite(number):
        raise place.error(value, "not finite", allowed)
    return number


def _in_range(value: float, field: dataclasses.Field[Any]) -> bool:
    low, high = field.metadata["low"], field.metadata["high"]
    return (low is None or value >= low) and (high is None or value <= high)
