"""``python -m tethernet_learning.campaigns``: fly a campaign, tabulate it, draw its maps."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tethernet_core.command import command
from tethernet_core.parameters import ParameterError
from tethernet_learning.campaigns import attitude_map, pictures, provenance, report, scenario_file, tumble_map
from tethernet_learning.campaigns import variations as sources
from tethernet_learning.campaigns.arguments import parse
from tethernet_learning.campaigns.cases import Case, aim
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.results import Results
from tethernet_learning.campaigns.run import resume
from tethernet_learning.flight_settings import settings_of
from tethernet_learning.workers import ClusterError
from tethernet_planner import policies
from tethernet_sim.fly import Settings

FAULT, USAGE, INTERRUPTED = 1, 2, 130
MAPS = {"attitude": attitude_map.draw, "tumble": tumble_map.draw}


@command
def main(argv: Sequence[str] | None = None) -> int:
    """Do what the command line says.

    Args:
        argv: the words after the program's name; None for those of this process.

    Returns:
        The exit status: 0 done, 1 a fault, 2 bad usage, 130 interrupted.
    """
    options = parse(argv)
    command = {"table": _table, "plot": _plot}.get(options.command, _fly)
    try:
        return command(options)
    except (CampaignError, ParameterError, policies.PolicyError) as error:
        print(f"campaign: {error}", file=sys.stderr)
        return USAGE
    except (OSError, ClusterError) as error:
        print(f"campaign: {error}", file=sys.stderr)
        return FAULT


def _fly(options: argparse.Namespace) -> int:
    _check_folder(options.output)
    settings = settings_of(options.set, options.control == "paper")
    cases, source = _cases(options, settings)
    cases = aim(cases, options.policy)
    models = {str(mus): policies.fingerprint(options.policy, mus) for mus in {case.scenario.mus for case in cases}}
    source |= {"policy": options.policy, "policy_models": models, "control": options.control}
    description = provenance.describe(source, cases, settings)
    with Results(options.output, description) as results:
        if not results.complete and not resume(results, cases, settings, options.chunk, options.cluster):
            return INTERRUPTED
        print(f"{options.output}: {len(cases)} missions")
        print("\n".join(report.table(results.rows)))
    return 0


def _cases(options: argparse.Namespace, settings: Settings) -> tuple[list[Case], dict[str, Any]]:
    """The scenarios, and the options that made them."""
    if options.command == "file":
        cases = scenario_file.read(options.scenarios)
        return sorted(cases, key=lambda case: case.scenario.mus), {"name": "file"}
    rules = settings.mission
    make: Callable[[int], list[Case]] = {
        "random": lambda mus: sources.random_positions(mus, options.scenarios, options.seed, rules),
        "attitude": lambda mus: sources.attitudes(mus, options.directions, options.each, options.seed, rules),
        "tumble": lambda mus: sources.tumbles(
            mus, options.rates, options.axes, options.each, options.seed, rules, options.attitude == "random"
        ),
        "loss": lambda mus: sources.losses(mus, options.scenarios, options.seed, rules, options.latest, options.kinds),
    }[options.command]
    told = ("mus", "seed", "scenarios", "directions", "rates", "axes", "each", "attitude", "latest", "kinds")
    source = {"name": options.command, **{name: getattr(options, name) for name in told if hasattr(options, name)}}
    # One design after the other: flights of one design share a batch.
    return [case for mus in sorted(set(options.mus)) for case in make(mus)], source


def _table(options: argparse.Namespace) -> int:
    print("\n".join(report.table(report.read(options.files), options.by or report.GROUPED_BY)))
    return 0


def _plot(options: argparse.Namespace) -> int:
    pictures.check_suffix(options.output)
    _check_folder(options.output)
    pictures.save(MAPS[options.map](report.read(options.files)), options.output)
    print(options.output)
    return 0


def _check_folder(path: Path) -> None:
    if not path.absolute().parent.is_dir():
        raise CampaignError(f"--output {path}: its folder does not exist; make it first")
