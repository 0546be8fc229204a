"""Reads what was recorded for Rerun, chunk by chunk."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

TIMELINE = "mission"


@dataclass
class Entity:
    """What was recorded under one path."""

    times_ns: list[int] = field(default_factory=list)
    """Of its rows, sorted."""
    rows: list[tuple[int, dict[str, Any]]] = field(default_factory=list)
    """Time [ns] and components by name, as Python values; -1 for what holds at all times."""

    def last(self, component: str) -> Any:
        """The newest value of a component."""
        return [row[component] for _, row in self.rows if row.get(component) is not None][-1]


def read(path: Path) -> dict[str, Entity]:
    """All that was recorded in a file, by path, in the order of time; the layout and Rerun's own left out."""
    from rerun.chunk import RrdReader

    found: dict[str, Entity] = {}
    for chunk in RrdReader(path).stream():
        if chunk.entity_path.startswith(("/scene", "/plots", "/events")):
            found.setdefault(chunk.entity_path, Entity()).rows += _rows(chunk)
    for entity in found.values():
        entity.rows.sort(key=lambda row: row[0])
        entity.times_ns = [time_ns for time_ns, _ in entity.rows if time_ns >= 0]
    return found


def _rows(chunk: Any) -> Iterator[tuple[int, dict[str, Any]]]:
    import pyarrow as pa

    batch = chunk.to_record_batch()
    times = [-1] * batch.num_rows
    if not chunk.is_static:
        times = batch.column(batch.schema.get_field_index(TIMELINE)).cast(pa.int64()).to_pylist()
    columns = {
        name.rpartition(":")[2]: batch.column(i).to_pylist()
        for i, name in enumerate(batch.schema.names)
        if name != TIMELINE and not name.startswith("rerun.")
    }
    for i, time_ns in enumerate(times):
        yield time_ns, {name: values[i] for name, values in columns.items()}
