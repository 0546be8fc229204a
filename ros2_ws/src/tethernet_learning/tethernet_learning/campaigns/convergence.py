"""``tethernet validate convergence``: how far verdicts depend on numbers of the model and on assumed ones, the same
scenarios for each.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
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
from tethernet_learning.assumed_numbers import described_entry
from tethernet_learning.campaigns.comparison import compare
from tethernet_learning.campaigns.statistics import Estimate, Summary, summarise
from tethernet_learning.campaigns.sweep import mean_pairs, outcomes
from tethernet_learning.flight_settings import add_hold
from tethernet_learning.stable_step import stable_step_s
from tethernet_planner import policies
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Outcome
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
    scaled: Mapping[str, float] = field(default_factory=dict)
    """Factors of entries of the description; the row is left out where one has no value but 0."""
    mesh_m: float | None = None
    """Mesh of a square net of the same size; the row is left out where it is that already, or no square."""


DAMPING, SPRINGS, MODULUS = "net.thread.damping_ratio", "net.springs_per_thread", "net.thread.modulus_pa"
TETHER, WINCH = "tether.stiffness_n_m", "closing.winch.stiffness_n_m"
KNOTS = {"contact": "knots"}
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
    "thread modulus / 10": Row(scaled={MODULUS: 0.1}),
    "friction 1": Row(physics={"friction_coefficient": 1.0}),
    "fold factor 0.02": Row(physics={"fold_factor": 0.02}),
    "fold factor 0.1": Row(physics={"fold_factor": 0.1}),
    "tether stiffness / 2": Row(scaled={TETHER: 0.5}),
    "tether stiffness x 2": Row(scaled={TETHER: 2.0}),
    "winch stiffness / 10": Row(scaled={WINCH: 0.1}),
    "contact of knots alone": Row(physics=KNOTS),
    "mesh 1 m": Row(mesh_m=1.0),
    "mesh 0.5 m": Row(mesh_m=0.5),
    "2 springs per thread": Row(system={SPRINGS: 2}),
    "4 springs per thread": Row(system={SPRINGS: 4}),
}
"""The rows of the table; those that take longest come last."""


def rows_of(base: System) -> dict[str, Row]:
    """The rows that change something in a system."""
    return {name: row for name, row in ROWS.items() if _entries(row, base) is not None}


def variant(row: Row, base: System, mission: Mapping[str, Any] | None = None) -> tuple[System, Settings]:
    """System and settings of a row; its step is stable.

    Args:
        row: of the table, one of :func:`rows_of`.
        base: the system as it is described.
        mission: rules in the place of the default ones.
    """
    system, own = changed(base, _entries(row, base) or {}), dict(base.parameters.get("physics", {}))
    physics = load(PhysicsParameters, own)
    wanted = {"contact_stiffness_n_m": row.stiffness * physics.contact_stiffness_n_m, **row.physics}
    step_s = stable_step_s(
        system, load(PhysicsParameters, {**own, **wanted}), Settings.load(base).control, row.step * physics.time_step_s
    )
    return system, Settings.load(system, physics={**wanted, "time_step_s": step_s}, mission=dict(mission or {}))


def _entries(row: Row, base: System) -> dict[str, Any] | None:
    """What a row replaces in the description; None where that changes nothing."""
    entries = dict(row.system)
    for name, factor in row.scaled.items():
        given = base.net.material.modulus_pa if name == MODULUS else described_entry(base.content, name)
        if not given:
            return None
        entries[name] = factor * given
    if row.mesh_m is not None:
        square = described_entry(base.content, "net.square")
        if not square or row.mesh_m == square["mesh_m"]:
            return None
        entries |= _other_mesh(base, square, row.mesh_m)
    return entries


def _other_mesh(base: System, square: Mapping[str, Any], mesh_m: float) -> dict[str, Any]:
    """The same square net with other meshes, its winch's nodes where they were."""
    factor = square["mesh_m"] / mesh_m

    def moved(place: Any) -> Any:
        return round(factor * place) if isinstance(place, int) else place

    entries: dict[str, Any] = {"net.square.mesh_m": mesh_m}
    for side in ("rows", "columns"):
        entries[f"net.square.{side}"] = round(factor * (square[side] - 1)) + 1
    ring = described_entry(base.content, "closing.winch.ring")
    if ring:
        entries["closing.winch.ring"] = [{key: moved(place) for key, place in node.items()} for node in ring]
    return entries


def table(
    found: Mapping[str, Sequence[Outcome]],
    with_policy: Mapping[str, Sequence[Outcome]],
    variants: Mapping[str, tuple[System, Settings]],
    base: System,
) -> list[str]:
    """The statistics as lines of a Markdown table.

    Args:
        found: outcomes of the rows with nominal aiming points.
        with_policy: the same scenarios with those of a policy, of some rows; empty where none was flown.
        variants: system and settings of each row.
        base: the system as it is described.
    """
    limit = base.closing.max_locked_pairs
    held = any(settings.mission.hold_s > 0.0 for _, settings in variants.values())
    heads = [
        base.name, "step, us", "missions", "captured", *(["held"] if held else []), f"pairs of {limit}, mean (fewest)",
        "CQI", "CQI, units counted", "fuel per unit, kg",
    ]  # fmt: skip
    if with_policy:
        heads += ["with the policy: captured", *(["held"] if held else []), "fuel saved, %"]
    lines = [_line(heads), "|" + "---|" * len(heads)]
    for name, nominal in found.items():
        summary = summarise(nominal)
        step_us = 1e6 * variants[name][1].physics.time_step_s
        cells = [
            name, f"{step_us:.4g}", str(summary.count), *_verdicts(nominal, held),
            f"{mean_pairs(summary):.2f} ({min(summary.locked_pairs)})", _number(summary.cqi), _number(summary.cqi_all),
            _interval(summary.fuel_kg),
        ]  # fmt: skip
        if with_policy:
            cells += _with_policy(nominal, with_policy.get(name), held)
        lines.append(_line(cells))
    return lines


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _verdicts(flown: Sequence[Outcome], held: bool) -> list[str]:
    captured = str(sum(outcome.captured for outcome in flown)) + _errors(summarise(flown))
    return [captured, str(sum(outcome.held is True for outcome in flown))] if held else [captured]


def _with_policy(nominal: Sequence[Outcome], aimed: Sequence[Outcome] | None, held: bool) -> list[str]:
    if aimed is None:
        return ["-"] * (3 if held else 2)
    saved = compare(nominal, aimed).reduction
    share = "-" if saved is None else f"{100 * saved.value:.2f} ({100 * saved.low:.2f} to {100 * saved.high:.2f})"
    return [*_verdicts(aimed, held), share]


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
    rows = rows_of(base)
    chosen = options.rows or list(rows)
    if missing := [name for name in chosen if name not in rows]:
        raise InputError(f"--rows {missing[0]}: changes nothing in {base.name}; allowed: {'; '.join(rows)}")
    mission = {"hold_s": options.hold or 0.0, "tow_n": options.tow or 0.0}
    variants = {name: variant(row, base, mission) for name, row in rows.items() if name in chosen}
    try:
        options.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--output {options.output}: cannot be made ({error}); name another folder") from error
    flown: dict[str, dict[str, list[Outcome]]] = {policies.NOMINAL: {}, options.policy: {}}
    numbers = {name: number for number, name in enumerate(rows, start=1)}
    lines: list[str] = []
    for name, (system, settings) in variants.items():
        for policy, found in flown.items():
            new = outcomes(
                {name: (system, settings)}, options.missions, options.seed, options.output, first=numbers[name],
                total=len(rows), chunk=CHUNK, aimed_by=policy, aimed_for=base,
            )  # fmt: skip
            if new is None:
                return INTERRUPTED
            found.update(new)
        with_policy = flown[options.policy] if options.policy != policies.NOMINAL else {}
        lines = table(flown[policies.NOMINAL], with_policy, variants, base)
        write_text(options.output / f"{NAME}_{base.name}.md", "\n".join(lines) + "\n")
    print("\n".join(lines))
    return 0


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_system(parser, required=False)
    add("--missions", type=whole_number(1), default=40, metavar="N", help="of each row, default 40")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the scenarios, default 0")
    add("--rows", nargs="+", choices=list(ROWS), metavar="ROW", help=f"of: {'; '.join(ROWS)}; default all")
    add(
        "--policy", default=policies.NOMINAL, metavar="POLICY",
        help="fly the same missions with a policy too, aimed for the system as it is described, and say what it saves "
        f"in each row, with its 95 %% interval: {policies.HELP}; default nominal: none",
    )  # fmt: skip
    add_hold(parser)
    add("--output", type=Path, required=True, metavar="FOLDER", help="for the outcomes of each row, and the table")


COMMAND = Subcommand(
    "Fly the same missions with other numerics (time step, contact, springs per thread) and other assumed numbers "
    "(friction, thread damping and modulus, fold factor, mesh, tether, winch), and put captures, holds, pairs, CQI, "
    "fuel and what a policy saves into one table. What is flown is kept; interrupted, the same command goes on.",
    ("--output convergence", "--system zenit_4mu --policy rl --hold 60 --tow 20 --rows 'friction 1' --output table"),
    run, _add_arguments,
    notes="With --rows some are flown, the table then holds these. A row whose step would be unstable takes the "
    "largest stable one that divides the control period; the table says which.",
)  # fmt: skip
