"""Fly many random scenarios in full, in process, and say how it went.

``python -m tethernet_learning.campaigns.fly_scenarios --mus 8``

The short command for one design and one policy; :mod:`tethernet_learning.campaigns` does the same for more missions and
other variations, with resume and outcomes as a table.
"""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import command_start

    command_start()

import argparse
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from tethernet_core.atomic_file import write_text
from tethernet_core.capture_quality import QualityParameters, tight
from tethernet_core.command import command
from tethernet_learning.campaigns.cases import Case, aim
from tethernet_learning.campaigns.chunks import fly_chunks
from tethernet_learning.campaigns.progress import Progress
from tethernet_learning.campaigns.statistics import Estimate, summarise
from tethernet_learning.campaigns.variations import random_positions
from tethernet_planner import policies
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Outcome


def records(cases: Sequence[Case], outcomes: Sequence[Outcome], quality: QualityParameters) -> dict:
    """Statistics and records of flown scenarios, ready for JSON; missions in error count as not captured."""
    summary = summarise(outcomes)
    return {
        "success_rate": summary.success.value,
        "success_rate_95": _interval(summary.success),
        "fuel_per_mu_kg": _value(summary.fuel_kg),
        "fuel_per_mu_kg_95": _interval(summary.fuel_kg),
        "fuel_at_trigger_per_mu_kg": _value(summary.fuel_at_trigger_kg),
        "locked_pairs": {str(pairs): count for pairs, count in summary.locked_pairs.items()},
        "cqi_mean": summary.cqi,
        "cqi_below_threshold": sum(tight(outcome.cqi, quality) for outcome in outcomes),
        "cqi_all_mean": summary.cqi_all,
        "cqi_all_below_threshold": sum(tight(outcome.cqi_all, quality) for outcome in outcomes),
        "errors": summary.errors,
        "scenarios": [
            {"scenario": asdict(case.scenario), "outcome": asdict(outcome)}
            for case, outcome in zip(cases, outcomes, strict=True)
        ],
    }


def _value(estimate: Estimate | None) -> float | None:
    return None if estimate is None else estimate.value


def _interval(estimate: Estimate | None) -> list[float] | None:
    return None if estimate is None or math.isnan(estimate.low) else [estimate.low, estimate.high]


def plain(value):
    """NaN and infinity are no JSON."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tethernet_learning.campaigns.fly_scenarios",
        description="Fly many random scenarios in full, in process.",
    )
    parser.add_argument("--mus", type=int, choices=(4, 8), required=True)
    parser.add_argument("--policy", default=policies.default(), metavar="POLICY", help=f"who aims: {policies.HELP}")
    parser.add_argument("--control", default="default", choices=("default", "paper"), help="paper: its law as printed")
    parser.add_argument("--scenarios", type=int, default=100, metavar="N", help="how many, default 100")
    parser.add_argument("--seed", type=int, default=0, help="of the list of scenarios, default 0")
    parser.add_argument("--output", type=Path, metavar="FILE.json", help="statistics and one record per scenario")
    options = parser.parse_args(argv)
    try:
        policies.check(options.policy, options.mus)
    except policies.PolicyError as error:
        parser.error(str(error))
    if options.scenarios < 1:
        parser.error(f"--scenarios {options.scenarios}: allowed: 1 or more")
    if options.seed < 0:
        parser.error(f"--seed {options.seed}: allowed: 0 or more")
    if options.output and not options.output.absolute().parent.is_dir():
        parser.error(f"--output {options.output}: its folder does not exist")
    if options.output and options.output.is_dir():
        parser.error(f"--output {options.output}: is a folder; allowed: a file's name")
    return options


@command
def main(argv: Sequence[str] | None = None) -> int:
    """Fly, print a table, write the file. Returns 0; 2 for bad usage."""
    options = _arguments(argv)
    settings = Settings.paper() if options.control == "paper" else Settings.load()
    cases = aim(random_positions(options.mus, options.scenarios, options.seed, settings.mission), options.policy)
    progress = Progress(len(cases))
    outcomes: list[Outcome] = []
    for flown in fly_chunks(cases, settings):
        outcomes += flown
        progress.add(len(flown), sum(bool(outcome.error) for outcome in flown))
    result = records(cases, outcomes, settings.quality)
    head = {name: getattr(options, name) for name in ("mus", "policy", "control", "seed")}
    _print(head, result)  # first: a file that cannot be written must not cost what was flown
    if options.output:
        text = json.dumps(plain({**head, **result}), indent=2, allow_nan=False) + "\n"
        write_text(options.output, text)
    return 0


def _print(head: dict, result: dict) -> None:
    low, high = result["success_rate_95"]
    print(
        f"{head['mus']} MUs, policy {head['policy']}, control {head['control']}, {len(result['scenarios'])} scenarios"
    )
    print(f"  captured          {100 * result['success_rate']:.1f} %   (95 %: {100 * low:.1f} to {100 * high:.1f} %)")
    if result["fuel_per_mu_kg"] is not None:
        spread = result["fuel_per_mu_kg_95"]
        between = f"   (95 %: {spread[0]:.4f} to {spread[1]:.4f} kg)" if spread else ""
        print(f"  fuel per MU       {result['fuel_per_mu_kg']:.4f} kg{between}")
        print(f"  until the trigger {result['fuel_at_trigger_per_mu_kg']:.4f} kg")
    if result["cqi_mean"] is not None:
        counted = "" if result["cqi_all_mean"] is None else f"   (MUs counted: {result['cqi_all_mean']:.2f})"
        print(f"  CQI               {result['cqi_mean']:.2f}{counted}")
    print("  locked pairs      " + ", ".join(f"{pairs}: {n}" for pairs, n in result["locked_pairs"].items()))
    print(f"  errors            {result['errors']}")
    for record in result["scenarios"]:
        if not record["outcome"]["captured"]:
            print(f"  failed at {record['scenario']['debris_position']}: {record['outcome']['verdict']}")


if __name__ == "__main__":
    sys.exit(main())
