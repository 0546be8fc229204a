"""Data sets for surrogates in Parquet: one row for each flown scenario, every column described in the file itself."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.atomic_file import write_whole
from tethernet_core.capture_quality import deciding
from tethernet_core.system import DescriptionError, System, system_from_text
from tethernet_learning.flown import CQI_LIMIT
from tethernet_planner.inference.net_features import feature_count
from tethernet_sim.scenario import Outcome, Scenario

COLUMNS = {
    "number": ("-", "number of the scenario in its stream"),
    "mus": ("-", "number of units"),
    "noise_seed": ("-", "seed of the scenario's sensor noise"),
    "debris_position_m": ("m", "debris' centre of mass at launch, x y z, frame launch"),
    "aiming_offsets_m": ("m", "dx dy of each MU's aiming point from the nominal one, MU 1 first"),
    "features": (
        "m, m/s",
        "the net at the start of closing: x y z vx vy vz of each node relative to the debris' centre of mass; nodes: "
        "up to three loops of the net, the first its border, the central node, the units; null where closing "
        "never began",
    ),
    "error": ("-", "why the simulation failed; empty"),
    "captured": ("-", "settled CQI below the threshold of the settings and enough locked pairs"),
    "cqi": ("-", "settled Capture Quality Index, 15 s after the start of closing; null in an error"),
    "cqi_all": ("-", "the same with the MUs counted in the net's centre of mass"),
    "locked_pairs": ("-", "locked pairs at the end"),
    "trigger_time_s": ("s", "start of closing after launch; null where it never came"),
    "fuel_kg": ("kg", "fuel of each MU, launch to end"),
    "fuel_at_trigger_kg": ("kg", "fuel of each MU, launch to start of closing"),
    "mouth_area_m2": ("m^2", "area of the mouth at the start of closing; null where it never came"),
    "net_debris_distance_m": ("m", "between the centres of mass at the end; null in an error"),
}
"""Columns with unit and meaning."""


def schema(system: System, about: dict[str, Any]) -> Any:
    """The Parquet schema.

    Args:
        system: that is flown.
        about: seed, settings, commit: kept in the file.
    """
    import pyarrow as pa

    mus = system.unit_count
    types = {
        "number": pa.int64(),
        "mus": pa.int8(),
        "noise_seed": pa.int64(),
        "debris_position_m": pa.list_(pa.float64(), 3),
        "aiming_offsets_m": pa.list_(pa.float64(), 2 * mus),
        "features": pa.list_(pa.float32(), feature_count(system)),
        "error": pa.string(),
        "captured": pa.bool_(),
        "cqi": pa.float64(),
        "cqi_all": pa.float64(),
        "locked_pairs": pa.int16(),
        "trigger_time_s": pa.float64(),
        "fuel_kg": pa.list_(pa.float64(), mus),
        "fuel_at_trigger_kg": pa.list_(pa.float64(), mus),
        "mouth_area_m2": pa.float64(),
        "net_debris_distance_m": pa.float64(),
    }
    fields = [
        pa.field(name, types[name], metadata={"unit": unit, "description": text})
        for name, (unit, text) in COLUMNS.items()
    ]
    return pa.schema(fields, metadata={"tethernet": json.dumps(about, sort_keys=True)})


def rows(
    begin: int, scenarios: Sequence[Scenario], outcomes: Sequence[Outcome], seen: Sequence[np.ndarray | None]
) -> list[dict[str, Any]]:
    """Rows of the table, numbered from ``begin``."""

    def number_or_null(value: float | None) -> float | None:
        return value if value is not None and np.isfinite(value) else None

    return [
        {
            "number": begin + i,
            "mus": scenario.mus,
            "noise_seed": scenario.seed,
            "debris_position_m": list(scenario.debris_position),
            "aiming_offsets_m": np.ravel(scenario.aiming_offsets or ()).tolist(),
            "features": None if row is None or outcome.error else row,
            "error": outcome.error,
            "captured": outcome.captured,
            "cqi": number_or_null(outcome.cqi),
            "cqi_all": number_or_null(outcome.cqi_all),
            "locked_pairs": outcome.locked_pairs,
            "trigger_time_s": outcome.trigger_time_s,
            "fuel_kg": list(outcome.fuel_kg),
            "fuel_at_trigger_kg": list(outcome.fuel_at_trigger_kg),
            "mouth_area_m2": number_or_null(outcome.mouth_area_m2),
            "net_debris_distance_m": number_or_null(outcome.net_debris_distance_m),
        }
        for i, (scenario, outcome, row) in enumerate(zip(scenarios, outcomes, seen, strict=True))
    ]


def write(path: Path, table: Any) -> None:
    """Write a table to a file at once or not at all."""
    import pyarrow.parquet as pq

    write_whole(path, lambda partial: pq.write_table(table, partial, compression="zstd"))


def description(system: System, about: dict[str, Any]) -> str:
    """The data set's description as Markdown."""
    facts = [f"- {name}: {value}" for name, value in about.items() if not isinstance(value, dict)]
    lines = [f"| {name} | {unit} | {text} |" for name, (unit, text) in COLUMNS.items()]
    head = [
        f"# Captures by {system.name}, flown in full",
        "",
        *facts,
        "",
        "| column | unit | meaning |",
        "|---|---|---|",
    ]
    return "\n".join([*head, *lines, ""])


@dataclass(frozen=True)
class Captures:
    """The scenarios of a data set in which closing began: what a surrogate learns from."""

    features: np.ndarray  # (n, inputs) float32
    """See :mod:`.net_features`."""
    cqi: np.ndarray  # (n,)
    """Settled, the one that decides, at most CQI_LIMIT."""
    locked_pairs: np.ndarray  # (n,)
    closing_fuel_kg: np.ndarray  # (n,)
    """Total of all MUs after the start of closing [kg]."""
    captured: np.ndarray  # (n,) bool
    scenarios: int
    """In the whole data set, those included in which closing never began."""
    failures: int
    """Scenarios of the whole data set that were not captured."""
    about: dict[str, Any]
    """Seed, settings, commit."""
    system: System
    """That was flown, and by which captures were judged."""

    def chosen(self, which: np.ndarray) -> Captures:
        """Some of them, by index or mask; the counts stay those of the whole data set."""
        return dataclasses.replace(
            self,
            features=self.features[which],
            cqi=self.cqi[which],
            locked_pairs=self.locked_pairs[which],
            closing_fuel_kg=self.closing_fuel_kg[which],
            captured=self.captured[which],
        )


def captures(
    outcomes: Sequence[Outcome], seen: Sequence[np.ndarray | None], about: dict[str, Any], system: System
) -> Captures:
    """The same of flights that were not written down.

    Args:
        outcomes: of one system.
        seen: what a surrogate sees of each; None where closing never began.
        about: facts.
        system: by which the captures were judged.
    """
    kept = [
        (outcome, row) for outcome, row in zip(outcomes, seen, strict=True) if row is not None and not outcome.error
    ]
    return Captures(
        np.array([row for _, row in kept], np.float32).reshape(-1, feature_count(system)),
        np.minimum([deciding(o.cqi, o.cqi_all, system) for o, _ in kept], CQI_LIMIT),
        np.array([o.locked_pairs for o, _ in kept], float),
        np.array([sum(o.fuel_kg) - sum(o.fuel_at_trigger_kg) for o, _ in kept]),
        np.array([o.captured for o, _ in kept], bool),
        len(outcomes),
        sum(not o.captured for o in outcomes),
        about,
        system,
    )


def read(path: Path) -> Captures:
    """Read a data set.

    Raises:
        ValueError: when the file is no data set of this kind.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowInvalid) as error:
        raise ValueError(f"{path} cannot be read as Parquet: {error}") from error
    about = (table.schema.metadata or {}).get(b"tethernet")
    names = set(table.column_names)
    if about is None or names | {"cqi_all"} != set(COLUMNS) or not len(table):
        raise ValueError(f"{path} is no data set; allowed: what tethernet data make writes")
    facts = json.loads(about)
    system = _system(path, facts)
    mus = system.unit_count
    decides = deciding("cqi", "cqi_all", system)
    if decides not in names:
        raise ValueError(f"{path} has no column {decides}, by which its captures are judged; make it anew")
    captured = np.array(table["captured"].to_pylist(), bool)
    kept = table.filter(table["features"].is_valid())
    fuel, at_trigger = (
        np.array(kept[name].to_pylist(), float).reshape(-1, mus) for name in ("fuel_kg", "fuel_at_trigger_kg")
    )
    flat = kept["features"].combine_chunks().flatten().to_numpy(zero_copy_only=False)
    return Captures(
        np.array(flat, np.float32).reshape(-1, feature_count(system)),
        np.minimum(np.array(kept[decides].to_pylist(), float), CQI_LIMIT),
        np.array(kept["locked_pairs"].to_pylist(), float),
        (fuel - at_trigger).sum(axis=1),
        np.array(kept["captured"].to_pylist(), bool),
        len(table),
        int((~captured).sum()),
        facts,
        system,
    )


def _system(path: Path, facts: dict[str, Any]) -> System:
    """What was flown, as the file describes it."""
    text = facts.get("description", {}).get("text")
    if text is None:
        raise ValueError(
            f"{path} does not say which system was flown: it was made before data sets held its description; make it "
            "anew with tethernet data make"
        )
    try:
        system = system_from_text(text, folder=path.parent, source=str(path))
    except DescriptionError as error:
        raise ValueError(f"{path}: the description of its system cannot be read: {error}") from error
    if system.digest != facts.get("system_digest"):
        raise ValueError(
            f"{path}: its description of system {system.name} does not make the system that was flown any more; make "
            "it anew with tethernet data make"
        )
    return system
