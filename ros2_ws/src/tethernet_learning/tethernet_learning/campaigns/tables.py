"""Tables as Parquet or CSV files, by the file's suffix."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tethernet_core.atomic_file import write_whole
from tethernet_learning.campaigns.columns import Row, Value, in_words
from tethernet_learning.campaigns.errors import CampaignError

SUFFIXES = (".parquet", ".csv")


def check_suffix(path: Path) -> None:
    """Make sure that a file's kind is known, and that this Python can read and write it.

    Raises:
        CampaignError: when not.
    """
    if path.suffix not in SUFFIXES:
        raise CampaignError(f"{path}: unknown kind of file; allowed: names that end in {' or '.join(SUFFIXES)}")
    if path.suffix == ".parquet":
        _parquet()


def write(path: Path, columns: Mapping[str, type], rows: Sequence[Row]) -> None:
    """Write a table whole or not at all.

    Args:
        path: ends in .parquet or .csv.
        columns: names and types, in order.
        rows: an empty cell is None.

    Raises:
        CampaignError: for another suffix, or Parquet without pyarrow.
        OSError: when it cannot be written.
    """
    check_suffix(path)
    if path.suffix == ".csv":
        write_whole(path, lambda partial: _write_csv(partial, columns, rows))
    else:
        write_whole(path, lambda partial: _write_parquet(partial, columns, rows))


def read(path: Path, columns: Mapping[str, type]) -> list[Row]:
    """Read a table.

    Args:
        path: ends in .parquet or .csv.
        columns: types of the columns that may be in it; others are left out.

    Returns:
        Its rows, with those of the columns that it has.

    Raises:
        CampaignError: when it cannot be read, has no column of these, or a cell is not of its column's type.
    """
    names, lines = _read(path)
    used = [(place, name, columns[name]) for place, name in enumerate(names) if name in columns]
    if not used:
        raise CampaignError(
            f"{path} has none of the expected columns; it has: {in_words(names) or 'none'}; "
            f"allowed: {in_words(columns)}"
        )
    rows = []
    for number, line in enumerate(lines, start=1):
        if len(line) != len(names):
            raise CampaignError(f"{path}, row {number}: {len(line)} cells for {len(names)} columns")
        row: Row = {}
        for place, name, kind in used:
            try:
                row[name] = _cell(line[place], kind)
            except (KeyError, TypeError, ValueError, OverflowError):
                allowed = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}[kind]
                raise CampaignError(
                    f"{path}, row {number}: {name} = {line[place]!r}; allowed: {allowed}, or empty"
                ) from None
        rows.append(row)
    return rows


def header(path: Path) -> list[str]:
    """The names of a table's columns.

    Raises:
        CampaignError: when it cannot be read.
    """
    return _read(path)[0]


def _read(path: Path) -> tuple[list[str], list[list[Value]]]:
    check_suffix(path)
    try:
        return (_read_csv if path.suffix == ".csv" else _read_parquet)(path)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise CampaignError(f"{path} cannot be read: {error}") from error


def _cell(value: Value, kind: type) -> Value:
    if value is None or value == "":
        return None
    if kind is bool:
        return {"true": True, "false": False}[str(value).lower()] if not isinstance(value, bool) else value
    if kind is int and isinstance(value, float) and not value.is_integer():
        raise ValueError(value)
    if kind is float and float(value) != float(value):
        return None
    return kind(value)


def _write_csv(path: Path, columns: Mapping[str, type], rows: Sequence[Row]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in rows:
            cells = (row.get(name) for name in columns)
            writer.writerow([str(cell).lower() if isinstance(cell, bool) else cell for cell in cells])


def _read_csv(path: Path) -> tuple[list[str], list[list[Value]]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = [line for line in csv.reader(file) if line]
    return (lines[0], [[*line] for line in lines[1:]]) if lines else ([], [])


def _parquet() -> Any:
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise CampaignError(
            f"Parquet files need pyarrow ({error}); install it, or take a file whose name ends in .csv"
        ) from error
    return pyarrow.parquet


def _write_parquet(path: Path, columns: Mapping[str, type], rows: Sequence[Row]) -> None:
    parquet = _parquet()
    import pyarrow

    kinds = {bool: pyarrow.bool_(), int: pyarrow.int64(), float: pyarrow.float64(), str: pyarrow.string()}
    schema = pyarrow.schema([(name, kinds[kind]) for name, kind in columns.items()])
    table = pyarrow.table({name: [row.get(name) for row in rows] for name in columns}, schema=schema)
    parquet.write_table(table, path)


def _read_parquet(path: Path) -> tuple[list[str], list[list[Value]]]:
    parquet = _parquet()
    import pyarrow

    try:
        table = parquet.read_table(path)
    except pyarrow.ArrowException as error:
        raise CampaignError(f"{path} is not a Parquet file: {error}") from error
    return table.column_names, [list(line) for line in zip(*(c.to_pylist() for c in table.columns), strict=True)]
