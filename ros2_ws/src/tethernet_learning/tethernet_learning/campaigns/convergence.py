"""``tethernet validate convergence``: how far captures depend on numbers of the model, the same scenarios for each."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tethernet_core.atomic_file import write_text
from tethernet_core.command import INTERRUPTED
from tethernet_core.errors import InputError
from tethernet_core.parameters import load
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system import System
from tethernet_core.system.changing import changed
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning.campaigns.statistics import Estimate, Summary
from tethernet_learning.campaigns.sweep import fly, mean_pairs
from tethernet_learning.stable_step import stable_step_s
from tethernet_sim.fly import Settings
from tethernet_sim.settings import PhysicsParameters

NAME = "convergence"
CHUNK = 8
"""Missions that are flown, and kept, at a time: some rows take minutes for each."""


@dataclass(frozen=True)
class Row:
    """What a row of the table changes."""

    step: float = 1.0
    """The time step, by the default one; where that is unstable, the largest stable one is taken."""
    stiffness: float = 1.0
    """Contact stiffness, by the default one."""
    physics: Mapping[str, Any] = field(default_factory=dict)
    """Physical parameters in the place of the default ones."""
    system: Mapping[str, Any] = field(default_factory=dict)
    """Entries of the description, likewise."""
    modulus: float = 1.0
    """Young's modulus of the threads, by the described one."""


DAMPING, SPRINGS = "net.thread.damping_ratio", "net.springs_per_thread"
ROWS: Mapping[str, Row] = {
    "as described": Row(),
    "time step / 2": Row(step=0.5),
    "time step / 4": Row(step=0.25),
    "contact stiffness x 10": Row(stiffness=10.0),
    "contact stiffness / 10": Row(stiffness=0.1),
    "friction 0": Row(physics={"friction_coefficient": 0.0}),
    "friction 0.1": Row(physics={"friction_coefficient": 0.1}),
    "friction 0.6": Row(physics={"friction_coefficient": 0.6}),
    "thread damping ratio 0.05": Row(system={DAMPING: 0.05}),
    "thread damping ratio 0.2": Row(system={DAMPING: 0.2}),
    "thread modulus / 10": Row(modulus=0.1),
    "2 springs per thread": Row(system={SPRINGS: 2}),
    "4 springs per thread": Row(system={SPRINGS: 4}),
}
"""The rows of the table; those that take longest come last."""


def variant(row: Row, base: System) -> tuple[System, Settings]:
    """System and settings of a row; its step is stable.

    Args:
        row: of the table.
        base: the system as it is described.
    """
    entries = dict(row.system)
    if row.modulus != 1.0:
        entries["net.thread.modulus_pa"] = row.modulus * base.net.material.modulus_pa
    system, own = changed(base, entries), dict(base.parameters.get("physics", {}))
    physics = load(PhysicsParameters, own)
    wanted = {**row.physics, "contact_stiffness_n_m": row.stiffness * physics.contact_stiffness_n_m}
    step_s = stable_step_s(
        system, load(PhysicsParameters, {**own, **wanted}), Settings.load(base).control, row.step * physics.time_step_s
    )
    return system, Settings.load(system, physics={**wanted, "time_step_s": step_s})


def table(found: Mapping[str, Summary], variants: Mapping[str, tuple[System, Settings]], base: System) -> list[str]:
    """The statistics as lines of a Markdown table."""
    limit = base.closing.max_locked_pairs
    lines = [
        f"| {base.name} | step, us | missions | captured | pairs of {limit}, mean (fewest) | CQI | CQI, units counted "
        "| fuel per unit, kg |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, summary in found.items():
        step_us = 1e6 * variants[name][1].physics.time_step_s
        cells = (
            name, f"{step_us:.4g}", str(summary.count), str(summary.captured) + _errors(summary),
            f"{mean_pairs(summary):.2f} ({min(summary.locked_pairs)})", _number(summary.cqi), _number(summary.cqi_all),
            _interval(summary.fuel_kg),
        )  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def _errors(summary: Summary) -> str:
    return f" ({summary.errors} in error)" if summary.errors else ""


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _interval(estimate: Estimate | None) -> str:
    if estimate is None:
        return "-"
    half = 0.5 * (estimate.high - estimate.low)
    return f"{estimate.value:.4f}" + ("" if math.isnan(half) else f" +- {half:.4f}")


def run(options: argparse.Namespace) -> int:
    """Fly the rows, write the table after each, print it; gives 130 when interrupted."""
    base = chosen_system(options)
    chosen = options.rows or list(ROWS)
    variants = {name: variant(ROWS[name], base) for name in ROWS if name in chosen}
    try:
        options.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--output {options.output}: cannot be made ({error}); name another folder") from error
    found: dict[str, Summary] = {}
    numbers = {name: number for number, name in enumerate(ROWS, start=1)}
    lines: list[str] = []
    for name, (system, settings) in variants.items():
        flown = fly(
            {name: (system, settings)}, options.missions, options.seed, options.output, first=numbers[name],
            total=len(ROWS), chunk=CHUNK,
        )  # fmt: skip
        if flown is None:
            return INTERRUPTED
        found |= flown
        lines = table(found, variants, base)
        write_text(options.output / f"{NAME}_{base.name}.md", "\n".join(lines) + "\n")
    print("\n".join(lines))
    return 0


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_system(parser, required=False)
    add("--missions", type=whole_number(1), default=40, metavar="N", help="of each row, default 40")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the scenarios, default 0")
    add("--rows", nargs="+", choices=list(ROWS), metavar="ROW", help=f"of: {'; '.join(ROWS)}; default all")
    add("--output", type=Path, required=True, metavar="FOLDER", help="for the outcomes of each row, and the table")


COMMAND = Subcommand(
    "Fly the same missions with other time steps, contact stiffness, friction, springs per thread, thread damping and "
    "modulus, and put captures, pairs, CQI and fuel into one table. What is flown is kept; interrupted, the same "
    "command goes on.",
    ("--output convergence", "--missions 100 --system zenit_4mu --rows 'time step / 2' --output convergence"),
    run, _add_arguments,
    notes="With --rows some are flown, the table then holds these. A row whose step would be unstable takes the "
    "largest stable one that divides the control period; the table says which.",
)  # fmt: skip
