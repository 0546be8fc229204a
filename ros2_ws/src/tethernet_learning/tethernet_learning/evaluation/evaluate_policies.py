"""Fly policies on unseen scenarios in full."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tethernet_core import atomic_file
from tethernet_core.errors import InputError
from tethernet_core.subcommand import Parser, Subcommand, number, whole_number
from tethernet_core.system import System
from tethernet_core.system.option import add_systems, chosen_systems
from tethernet_learning import assumed_numbers, flight_settings, measured, workers
from tethernet_learning.campaigns import pictures, tables
from tethernet_learning.campaigns.arguments import FASTEST_DEG_S
from tethernet_learning.campaigns.cases import outcome_columns, row
from tethernet_learning.campaigns.records import plain
from tethernet_learning.evaluation import report as evaluation_report
from tethernet_learning.evaluation.policy_scores import Evaluated, as_json, contenders, evaluate
from tethernet_learning.flight_digest import flight_digest
from tethernet_learning.flight_settings import fingerprints, settings_by_system
from tethernet_learning.random_scenarios import Turned
from tethernet_learning.run_progress import MissionProgress
from tethernet_learning.seeds import Purpose
from tethernet_planner import policies
from tethernet_planner.inference import model_file, shipped_models
from tethernet_sim import cores
from tethernet_sim.fly import CHUNK

RESULT, REPORT, PLOT, ROWS = "evaluation.json", "report.md", "fuel.png", "outcomes.csv"


def run(options: argparse.Namespace) -> None:
    """Fly, print the table, write the files."""
    flights = flight_settings.flights_of(flight_settings.replaced(options), chosen_systems(options))
    chosen = contenders(options.policy, list(flights))
    if options.output.suffix == ".json":
        if len(chosen) != 1:
            raise InputError(
                f"--output {options.output} with {len(chosen)} systems; allowed: a JSON file for one --system, or a "
                "folder"
            )
        options.output.parent.mkdir(parents=True, exist_ok=True)
    else:
        options.output.mkdir(parents=True, exist_ok=True)
    _run(options, flights, chosen)


def _run(options: argparse.Namespace, flights: flight_settings.Flights, chosen: dict[System, list[str]]) -> None:
    for system in chosen if policies.RL in options.policy else ():
        if warning := measured.stale(shipped_models.POLICY, system):
            print(f"warning: {warning}", file=sys.stderr)
    began = time.monotonic()
    turned = Turned(options.attitude == "random", options.tumble_rate)
    with MissionProgress(options.scenarios * sum(map(len, chosen.values()))) as progress:
        evaluated = evaluate(
            chosen, options.scenarios, options.seed, flights, options.chunk, options.cluster, progress.add, turned,
            options.assumed,
        )  # fmt: skip
    facts = {
        "scenarios": options.scenarios,
        "stream": Purpose.POLICY_EVALUATION.name,
        "seed": options.seed,
        "attitude": options.attitude,
        "tumble_rate_deg_s": options.tumble_rate,
        "assumed": options.assumed,
        "set": flight_settings.replaced(options),
        "flight_digest": flight_digest(),
        "flight_parameters": fingerprints(settings_by_system(flights)),
        "commit": model_file.commit(),
        "flown_on": f"the cluster at {options.cluster}" if options.cluster else cores.told(),
        "wall_time_s": round(time.monotonic() - began, 1),
    }
    if options.output.suffix == ".json":
        atomic_file.write_text(options.output, as_text(of_one(facts, evaluated[0])))
    else:
        write(options.output, facts, evaluated)
    print(evaluation_report.table(evaluated))
    print(f"{facts['wall_time_s']:.0f} s on {facts['flown_on']}; {options.output}")


def of_one(facts: dict[str, Any], evaluated: Evaluated) -> dict[str, Any]:
    """One system's evaluation with what the last policy came to at the top, the nominal points where nothing else flew.

    Args:
        facts: how it was flown.
        evaluated: what came out.
    """
    [(name, of_system)] = as_json([evaluated]).items()
    by_policy = of_system.pop("policies")
    last = list(by_policy)[-1]
    told = {key: value for key, value in facts.items() if key != "scenarios"}  # they are listed
    others = {
        policy: {key: value for key, value in found.items() if key != "scenarios"}
        for policy, found in by_policy.items()
        if policy != last
    }
    return {"system": name, "policy": last, **told, **of_system, **by_policy[last], "others": others}


def as_text(content: dict[str, Any]) -> str:
    """Content as JSON; null stands for what is not finite."""
    return json.dumps(plain(content), indent=2, allow_nan=False) + "\n"


def write(folder: Path, facts: dict[str, Any], evaluated: Sequence[Evaluated]) -> None:
    """Write an evaluation: all of it, the table, the box plots, a row for each mission.

    Args:
        folder: takes the files.
        facts: how it was flown.
        evaluated: what came out.
    """
    atomic_file.write_text(folder / RESULT, as_text({**facts, "systems": as_json(evaluated)}))
    head = "\n".join(f"- {name}: {value}" for name, value in facts.items())
    text = f"# Policies on unseen scenarios\n\n{head}\n\n{evaluation_report.table(evaluated)}\n![Fuel]({PLOT})\n"
    atomic_file.write_text(folder / REPORT, text)
    pictures.save(evaluation_report.figure(evaluated), folder / PLOT)
    flown = [pair for e in evaluated for name in e.cases for pair in zip(e.cases[name], e.outcomes[name], strict=True)]
    units = max(e.system.unit_count for e in evaluated)
    tables.write(folder / ROWS, outcome_columns(units), [row(i, *pair, units) for i, pair in enumerate(flown)])


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_systems(parser)
    add(
        "--policy", nargs="+", default=[policies.RL], metavar="POLICY",
        help="rl (the shipped models; default) or paths of policy.safetensors, each for the system that it was made "
        "for; the nominal points fly in any case, and alone with --policy nominal",
    )  # fmt: skip
    flight_settings.add_parameters(parser, "; for the nominal points and every policy alike")
    add(
        "--attitude", choices=("default", "random"), default="default",
        help="of the debris at launch: default (long axis along the net's diagonal) or random",
    )  # fmt: skip
    add(
        "--tumble-rate", type=number(0.0, FASTEST_DEG_S, "deg/s"), default=0.0, metavar="DEG_S",
        help="the debris turns so fast about a random axis [deg/s]; default 0",
    )  # fmt: skip
    add(
        "--assumed", choices=assumed_numbers.CHOICES, default=assumed_numbers.AS_DESCRIBED,
        help="numbers that nobody has measured (threads' damping, fold factor, friction, stiffness of tether and "
        "winches): as described (default), or random, drawn anew for every few scenarios, the same for all policies",
    )  # fmt: skip
    positive = whole_number(1)
    add("--scenarios", type=positive, default=100, metavar="N", help="for each system and policy, default 100")
    add(
        "--seed", type=whole_number(0), default=0, metavar="N",
        help="of the scenarios, from a stream that no training uses; default 0",
    )  # fmt: skip
    add(
        "--output", type=Path, default=Path("runs/evaluation"), metavar="FOLDER",
        help="default runs/evaluation; with one system also FILE.json: what the policy came to, each mission and the "
        "means, and nothing else is written",
    )  # fmt: skip
    add("--chunk", type=positive, default=CHUNK, metavar="N", help=f"missions flown together; default {CHUNK}")
    add("--cluster", metavar="ADDRESS", help=workers.HELP)


COMMAND = Subcommand(
    "Fly policies and the nominal aiming points on the same unseen scenarios with the same sensor noise, in full "
    "simulation to the end of capture, and compare them with each other and with the paper.",
    ("", "--mus 8 --policy A/policy.safetensors B/policy.safetensors"), run, _add_arguments,
    f"The folder gets {RESULT} (all of it), {REPORT} (the table), {PLOT} (box plots) and {ROWS} (a row for each "
    "mission, as tethernet campaign writes and reads it).",
)  # fmt: skip
