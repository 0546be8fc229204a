"""Dataclasses as rows of a table with plain column names, and back.

The names follow from the fields and their types alone: a vector ``position`` becomes ``position_x``, ``position_y``,
``position_z``; one value for each MU becomes ``fuel_kg_mu1`` to ``fuel_kg_mu8``; a dataclass ``failure`` becomes
``failure_mu``, ``failure_kind`` and so on. None, NaN and infinity are empty cells.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import re
import types
import typing
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from tethernet_core.layout import DESIGNS
from tethernet_core.system import System

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")
Value = bool | int | float | str | None
Row = dict[str, Value]
"""The cells of one row by column name; None is an empty cell."""

SCALARS = (bool, int, float, str)
MU_COUNT = max(DESIGNS)
"""Fields with one value for each MU get so many columns."""
MUS = "mus"
"""The column with a row's number of MUs."""
SYSTEM = "system"
"""The column with the name of what was flown."""


@functools.cache
def columns(cls: type) -> dict[str, type]:
    """Column names of a dataclass with their types: bool, int, float or str."""
    return dict(item for name, hint in _hints(cls).items() for item in _columns(hint, name))


def in_words(names: Iterable[str]) -> str:
    """Column names for people: those of the MUs as one, ``fuel_kg_muN``."""
    return ", ".join(dict.fromkeys(re.sub(r"_mu\d+", "_muN", name) for name in names))


def flatten(instance: Any) -> Row:
    """The cells of a dataclass' instance, every column of :func:`columns`."""
    kind: type = type(instance)
    row: Row = dict.fromkeys(columns(kind))
    for name, hint in _hints(kind).items():
        _fill(row, hint, name, getattr(instance, name))
    return row


def rebuild(cls: type[T], row: Mapping[str, Value]) -> T:
    """Make ``cls`` from its cells: what :func:`flatten` gave; an empty number becomes NaN.

    A field without any column in the row takes its default: a file may be older than the field.

    Raises:
        ValueError: naming a column that is empty but may not be, or what ``cls`` itself objects to.
        TypeError: when a field without a default has no column.
    """
    hints = {
        name: hint for name, hint in _hints(cls).items() if any(column in row for column, _ in _columns(hint, name))
    }
    return cls(**{name: _value(hint, name, row, strict=False) for name, hint in hints.items()})


def rebuild_given(cls: type[T], row: Mapping[str, Value]) -> T:
    """Make ``cls`` from those of its cells that are there; the fields without any take their defaults.

    Raises:
        ValueError: naming a column that is empty although others of its field are not, or what ``cls`` itself objects
            to.
    """
    given = {}
    if row.get(SYSTEM) is None and row.get(MUS) is not None and SYSTEM in _hints(cls):
        given[SYSTEM] = f"zenit_{row[MUS]}mu"
    for name, hint in _hints(cls).items():
        if any(row.get(column) is not None for column, _ in _columns(hint, name)):
            given[name] = _value(hint, name, row, strict=True)
    return cls(**given)


@functools.cache
def _hints(cls: type) -> dict[str, Any]:
    hints = typing.get_type_hints(cls)
    # A system is told by its name.
    return {field.name: str if field.name == SYSTEM else hints[field.name] for field in dataclasses.fields(cls)}


def _without_none(hint: Any) -> tuple[Any, bool]:
    """A type, and whether None is allowed beside it."""
    if typing.get_origin(hint) not in (types.UnionType, typing.Union):
        return hint, False
    [core] = [part for part in typing.get_args(hint) if part is not types.NoneType]
    return core, True


def _is_dataclass(core: Any) -> bool:
    return dataclasses.is_dataclass(core)


def _parts(core: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Names and types of what a dataclass or a tuple is made of."""
    if _is_dataclass(core):
        yield from ((f"{name}_{part}", hint) for part, hint in _hints(core).items())
        return
    if typing.get_origin(core) is not tuple:
        raise TypeError(f"{name}: {core} has no columns; a field is a number, a text, a tuple or a dataclass")
    first, *others = typing.get_args(core)
    if others == [Ellipsis]:
        yield from ((f"{name}_mu{mu}", first) for mu in range(1, MU_COUNT + 1))
    else:
        yield from zip((f"{name}_{axis}" for axis in "xyzw"), (first, *others), strict=False)


def _columns(hint: Any, name: str) -> Iterator[tuple[str, type]]:
    core, _ = _without_none(hint)
    if core in SCALARS:
        yield name, core
        return
    for part, part_hint in _parts(core, name):
        yield from _columns(part_hint, part)


def _fill(row: Row, hint: Any, name: str, value: Any) -> None:
    core, _ = _without_none(hint)
    if value is None:
        return
    if core in SCALARS:
        scalar = core(value.name if isinstance(value, System) else value)
        row[name] = None if core is float and not math.isfinite(scalar) else scalar
        return
    items = [getattr(value, n) for n in _hints(core)] if _is_dataclass(core) else value
    for (part, part_hint), item in zip(_parts(core, name), items, strict=False):
        _fill(row, part_hint, part, item)


def _value(hint: Any, name: str, row: Mapping[str, Value], strict: bool) -> Any:
    core, optional = _without_none(hint)
    if optional and all(row.get(column) is None for column, _ in _columns(core, name)):
        return None
    if core in SCALARS:
        value = row.get(name)
        if value is not None:
            return value
        if core is float and not strict:
            return math.nan
        if core is str and not strict:
            return ""
        raise ValueError(f"column {name} is empty; give it a value")
    parts = list(_parts(core, name))
    if not _is_dataclass(core) and typing.get_args(core)[-1] is Ellipsis:
        filled = [any(row.get(column) is not None for column, _ in _columns(hint, part)) for part, hint in parts]
        count = row.get(MUS, sum(filled))
        if not isinstance(count, int):
            raise ValueError(f"column {MUS} is {count!r}; give it a whole number")
        parts = parts[:count]
    values = [_value(part_hint, part, row, strict) for part, part_hint in parts]
    return core(*values) if _is_dataclass(core) else tuple(values)
