"""Dataclasses as rows of a table with plain column names, and back.

The names follow from the fields and their types alone: a vector ``position`` becomes ``position_x``, ``position_y``,
``position_z``; one value for each unit becomes ``fuel_kg_mu1`` to ``fuel_kg_muM``, as many as the largest system of a
campaign has; a system becomes ``system`` and ``system_digest``, its name and digest; a dataclass ``failure`` becomes
``failure_mu``, ``failure_kind`` and so on. None, NaN and infinity are empty cells.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import re
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from tethernet_core.system import System

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")
Value = bool | int | float | str | None
Row = dict[str, Value]
"""The cells of one row by column name; None is an empty cell."""

SCALARS = (bool, int, float, str)
MUS = "mus"
"""The column with a row's number of units."""
Resolve = Callable[[str | None, str | None, int | None], System]
"""The system of a row from its cells: name, digest, number of units; None where a cell is empty."""
SYSTEM, DIGEST = "system", "system_digest"
"""The columns with name and digest of what was flown."""
OF_UNIT = re.compile(r"_mu(\d+)(?=_|$)")


@functools.cache
def columns(cls: type, units: int) -> dict[str, type]:
    """Column names of a dataclass with their types: bool, int, float or str.

    Args:
        cls: a dataclass.
        units: fields with one value for each unit get so many columns.
    """
    return dict(item for name, hint in _hints(cls).items() for item in _columns(hint, name, units))


def units_in(names: Iterable[str]) -> int:
    """Of how many units columns hold values: the largest number of one that is named."""
    return max((int(found[-1]) for name in names if (found := OF_UNIT.findall(name))), default=0)


def in_words(names: Iterable[str]) -> str:
    """Column names for people: those of the MUs as one, ``fuel_kg_muN``."""
    return ", ".join(dict.fromkeys(re.sub(r"_mu\d+", "_muN", name) for name in names))


def flatten(instance: Any, units: int) -> Row:
    """The cells of a dataclass' instance, every column of :func:`columns`.

    Args:
        instance: of a dataclass.
        units: so many columns for fields with one value for each unit; the system has so many units, or fewer.
    """
    kind: type = type(instance)
    row: Row = dict.fromkeys(columns(kind, units))
    for name, hint in _hints(kind).items():
        _fill(row, hint, name, getattr(instance, name), units)
    return row


def rebuild(cls: type[T], row: Mapping[str, Value]) -> T:
    """Make ``cls`` from its cells: what :func:`flatten` gave; an empty number becomes NaN.

    A field without any column in the row takes its default: a file may be older than the field.

    Raises:
        ValueError: naming a column that is empty but may not be, or what ``cls`` itself objects to.
        TypeError: when a field without a default has no column.
    """
    units = _unit_count(row)
    given = {}
    for name, hint in _hints(cls).items():
        # One value for each of no units has no column.
        if any(column in row for column, _ in _columns(hint, name, units)) or (_per_unit(hint) and not units):
            given[name] = _value(hint, name, row, units, strict=False)
    return cls(**given)


def rebuild_given(cls: type[T], row: Mapping[str, Value], resolve: Resolve) -> T:
    """Make ``cls`` from those of its cells that are there; the fields without any take their defaults.

    Args:
        cls: a dataclass with a field ``system``.
        row: cells.
        resolve: finds the system of a row.

    Raises:
        ValueError: naming a column that is empty although others of its field are not, or what ``cls`` itself objects
            to.
    """
    name, digest, mus = row.get(SYSTEM), row.get(DIGEST), row.get(MUS)
    system = resolve(
        None if name is None else str(name), None if digest is None else str(digest), None if mus is None else int(mus)
    )
    given: dict[str, Any] = {SYSTEM: system}
    units = system.unit_count
    for name, hint in _hints(cls).items():
        if name != SYSTEM and any(row.get(column) is not None for column, _ in _columns(hint, name, units)):
            given[name] = _value(hint, name, row, units, strict=True)
    return cls(**given)


def _unit_count(row: Mapping[str, Value]) -> int:
    count = row.get(MUS)
    if count is None:
        return units_in(name for name, value in row.items() if value is not None)
    if not isinstance(count, int):
        raise ValueError(f"column {MUS} is {count!r}; give it a whole number")
    return count


@functools.cache
def _hints(cls: type) -> dict[str, Any]:
    hints = typing.get_type_hints(cls)
    # A scenario's field takes a name too and gives a system.
    return {
        field.name: System if field.name == SYSTEM and hints[field.name] is not str else hints[field.name]
        for field in dataclasses.fields(cls)
    }


def _without_none(hint: Any) -> tuple[Any, bool]:
    """A type, and whether None is allowed beside it."""
    if typing.get_origin(hint) not in (types.UnionType, typing.Union):
        return hint, False
    [core] = [part for part in typing.get_args(hint) if part is not types.NoneType]
    return core, True


def _is_dataclass(core: Any) -> bool:
    return dataclasses.is_dataclass(core)


def _per_unit(hint: Any) -> bool:
    """Whether a field holds one value for each unit, and must."""
    return typing.get_origin(hint) is tuple and typing.get_args(hint)[-1] is Ellipsis


def _parts(core: Any, name: str, units: int) -> Iterator[tuple[str, Any]]:
    """Names and types of what a dataclass or a tuple is made of."""
    if _is_dataclass(core):
        yield from ((f"{name}_{part}", hint) for part, hint in _hints(core).items())
        return
    if typing.get_origin(core) is not tuple:
        raise TypeError(f"{name}: {core} has no columns; a field is a number, a text, a tuple or a dataclass")
    first, *others = typing.get_args(core)
    if others == [Ellipsis]:
        yield from ((f"{name}_mu{mu}", first) for mu in range(1, units + 1))
    else:
        yield from zip((f"{name}_{axis}" for axis in "xyzw"), (first, *others), strict=False)


def _columns(hint: Any, name: str, units: int) -> Iterator[tuple[str, type]]:
    core, _ = _without_none(hint)
    if core is System:
        yield name, str
        yield f"{name}_digest", str
        return
    if core in SCALARS:
        yield name, core
        return
    for part, part_hint in _parts(core, name, units):
        yield from _columns(part_hint, part, units)


def _fill(row: Row, hint: Any, name: str, value: Any, units: int) -> None:
    core, _ = _without_none(hint)
    if value is None:
        return
    if core is System:
        row[name], row[f"{name}_digest"] = value.name, value.digest
        return
    if core in SCALARS:
        scalar = core(value)
        row[name] = None if core is float and not math.isfinite(scalar) else scalar
        return
    items = [getattr(value, n) for n in _hints(core)] if _is_dataclass(core) else value
    for (part, part_hint), item in zip(_parts(core, name, units), items, strict=False):
        _fill(row, part_hint, part, item, units)


def _value(hint: Any, name: str, row: Mapping[str, Value], units: int, strict: bool) -> Any:
    core, optional = _without_none(hint)
    if optional and all(row.get(column) is None for column, _ in _columns(core, name, units)):
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
    values = [_value(part_hint, part, row, units, strict) for part, part_hint in _parts(core, name, units)]
    return core(*values) if _is_dataclass(core) else tuple(values)
