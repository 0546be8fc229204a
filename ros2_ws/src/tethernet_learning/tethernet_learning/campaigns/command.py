"""``tethernet campaign``: fly a campaign, tabulate it, draw its maps."""

from __future__ import annotations

import argparse
import functools
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tethernet_core.command import INTERRUPTED
from tethernet_core.subcommand import Parser, Subcommand
from tethernet_core.system import System, load_system
from tethernet_core.system.option import chosen_systems
from tethernet_learning.campaigns import (
    arguments,
    attitude_map,
    pictures,
    provenance,
    report,
    scenario_file,
    tumble_map,
)
from tethernet_learning.campaigns import variations as sources
from tethernet_learning.campaigns.cases import Case, aim, as_flown
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.flown_systems import FlownSystems
from tethernet_learning.campaigns.results import Results
from tethernet_learning.campaigns.run import resume
from tethernet_learning.flight_settings import Flights, flights_of, replaced, settings_by_system
from tethernet_planner import policies
from tethernet_sim.fly import Settings

MAPS = {"attitude": attitude_map.draw, "tumble": tumble_map.draw}

NOTES = (
    "All cores fly (NUMBA_NUM_THREADS limits them). Give the same command again to go on after an interruption: at "
    "most the missions in flight are lost. A file that was begun with other scenarios, settings or code is refused. A "
    "mission that ends in error is counted as not captured."
)
EXIT_STATUS = "exit status: 0 done, 1 a fault, 2 bad usage, 130 interrupted (the same command goes on)"

Make = Callable[[argparse.Namespace], tuple[list[Case], Flights, dict[str, Any]]]
"""Cases of a campaign, those of one system after the other, which share batches; how each system is flown; and the
options that made them."""


def _fly(make: Make, options: argparse.Namespace) -> int:
    _check_folder(options.output)
    cases, flights, source = make(options)
    cases, settings = as_flown(aim(cases, options.policy), flights), settings_by_system(flights)
    aimed_by = {system.name: policies.chosen(options.policy, system) for system in flights}
    models = {system.name: policies.fingerprint(aimed_by[system.name], system) for system in flights}
    source |= {"policy": aimed_by, "policy_models": models, "control": options.control}
    description = provenance.describe(source, cases, settings)
    with Results(options.output, description) as results:
        if not results.complete and not resume(results, cases, settings, options.chunk, options.cluster):
            return INTERRUPTED
        print(f"{options.output}: {len(cases)} missions")
        print("\n".join(report.table(results.rows)))
        print(f"to look at maps and flights: tethernet campaign report {shlex.quote(str(options.output))}")
    return 0


def _of_file(options: argparse.Namespace) -> tuple[list[Case], Flights, dict[str, Any]]:
    cases = scenario_file.read(options.scenarios, [load_system(name) for name in options.system])
    cases = sorted(cases, key=lambda case: (case.scenario.mus, case.scenario.system.name))
    systems = dict.fromkeys(case.scenario.system for case in cases)
    return cases, flights_of(replaced(options), systems, options.control == "paper"), {"name": "file"}


def _of_seed(
    name: str,
    options_told: Sequence[str],
    make: Callable[[System, argparse.Namespace, Settings], list[Case]],
    options: argparse.Namespace,
) -> tuple[list[Case], Flights, dict[str, Any]]:
    flights = flights_of(replaced(options), chosen_systems(options), options.control == "paper")
    source = {"name": name, **{option: getattr(options, option) for option in options_told}}
    return [case for system, f in flights.items() for case in make(system, options, f.settings)], flights, source


def _random(system: System, options: argparse.Namespace, settings: Settings) -> list[Case]:
    return sources.random_positions(system, options.scenarios, options.seed, settings.mission)


def _attitudes(system: System, options: argparse.Namespace, settings: Settings) -> list[Case]:
    return sources.attitudes(system, options.directions, options.each, options.seed, settings.mission)


def _tumbles(system: System, options: argparse.Namespace, settings: Settings) -> list[Case]:
    random = options.attitude == "random"
    return sources.tumbles(
        system, options.rates, options.axes, options.each, options.seed, settings.mission, random
    )  # fmt: skip


def _losses(system: System, options: argparse.Namespace, settings: Settings) -> list[Case]:
    return sources.losses(system, options.scenarios, options.seed, settings.mission, options.latest, options.kinds)


def _table(options: argparse.Namespace) -> None:
    print("\n".join(report.table(report.read(options.files), options.by or report.GROUPED_BY)))


def _plot(options: argparse.Namespace) -> None:
    pictures.check_suffix(options.output)
    _check_folder(options.output)
    systems = FlownSystems([load_system(name) for name in options.system], options.files)
    pictures.save(MAPS[options.map](report.read(options.files), systems), options.output)
    print(options.output)


def _check_folder(path: Path) -> None:
    if not path.absolute().parent.is_dir():
        raise CampaignError(f"--output {path}: its folder does not exist; make it first")


def _campaign(
    text: str, examples: tuple[str, ...], make: Make, add_arguments: Callable[[Parser], None]
) -> Subcommand:  # fmt: skip
    return Subcommand(
        f"Fly many missions in full, in this process: {text}. The outcomes become a row each of a Parquet or CSV file.",
        examples, functools.partial(_fly, make), add_arguments, NOTES, EXIT_STATUS,
    )  # fmt: skip


RANDOM = _campaign(
    "the debris anywhere within the mission's bounds",
    ("--scenarios 1000 --seed 7 --output random.parquet", "--mus 4 --policy nominal --output random.csv"),
    functools.partial(_of_seed, "random", ("seed", "scenarios"), _random), arguments.add_random,
)  # fmt: skip
ATTITUDE = _campaign(
    "the debris' long axis over the whole sphere, at random places",
    ("--directions 200 --each 5 --output attitude.parquet",),
    functools.partial(_of_seed, "attitude", ("seed", "directions", "each"), _attitudes), arguments.add_attitude,
)  # fmt: skip
TUMBLE = _campaign(
    "the debris tumbles about axes over the whole sphere, at random places",
    ("--rates 0 1 2 3 4 5 --mus 8 --output tumble.csv",),
    functools.partial(_of_seed, "tumble", ("seed", "rates", "axes", "each", "attitude"), _tumbles),
    arguments.add_tumble,
)  # fmt: skip
LOSS = _campaign(
    "one unit is lost in flight, any of them, at any time",
    ("--scenarios 300 --output loss.parquet", "--mus 8 --kinds no_thrust --latest 24 --output dead.csv"),
    functools.partial(_of_seed, "loss", ("seed", "scenarios", "latest", "kinds"), _losses), arguments.add_loss,
)  # fmt: skip
FILE = _campaign(
    "the scenarios of a file with the columns of an outcomes file, the default where one lacks",
    ("--scenarios scenarios.csv --output again.parquet",), _of_file, arguments.add_file,
)  # fmt: skip
TABLE = Subcommand(
    "Statistics of outcomes files: captures and fuel with their 95 % intervals, locked pairs, CQI, errors.",
    ("loss.parquet --by system failure_kind",), _table, arguments.add_table,
)  # fmt: skip
PLOT = Subcommand(
    "Draw a map of outcomes files.",
    ("attitude attitude.parquet --output attitude.png", "tumble tumble.csv --output tumble.svg"),
    _plot, arguments.add_plot,
)  # fmt: skip
