"""Fly many random scenarios in full, in process, and say how it went (``python -m tethernet_planner.evaluate``)."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from tethernet_control.layout import nominal_aiming_points
from tethernet_control.parameters import load
from tethernet_control.settings import MissionParameters
from tethernet_sim.fly import Settings, fly_many
from tethernet_sim.scenario import Outcome, Scenario

from . import policies

STEP_M = 0.1
"""Debris positions are multiples of this [m] (paper, Table I)."""


def random_scenarios(mus: int, count: int, seed: int, policy: str) -> list[Scenario]:
    """Scenarios with the debris anywhere within the mission's bounds (paper, Table I), each with noise of its own.

    Args:
        mus: 4 or 8.
        count: how many.
        seed: one seed gives one list; a longer list begins with the shorter one.
        policy: makes the aiming points.

    Raises:
        PolicyError: when the policy is unknown or fails.
    """
    rules = load(MissionParameters)
    policies.check(policy)
    scenarios = []
    for sequence in np.random.SeedSequence(seed).spawn(count):
        random = np.random.default_rng(sequence)
        bound = rules.debris_bound_xy_m
        x, y = random.uniform(-bound, bound, 2)
        z = -random.uniform(rules.debris_near_m, rules.debris_far_m)
        position = tuple(round(round(value / STEP_M) * STEP_M, 6) for value in (x, y, z))
        scenarios.append(
            Scenario(
                mus=mus,
                debris_position=position,
                seed=int(random.integers(2**31)),
                aiming_offsets=_offsets(policy, mus, position),
            )
        )
    return scenarios


def _offsets(policy: str, mus: int, position: policies.Point) -> tuple[tuple[float, float], ...] | None:
    if policy == policies.NOMINAL:
        return None
    points = policies.aiming_points(policy, mus, position)
    nominal = nominal_aiming_points(mus, position)
    return tuple((p[0] - n[0], p[1] - n[1]) for p, n in zip(points, nominal, strict=True))


def summary(scenarios: Sequence[Scenario], outcomes: Sequence[Outcome]) -> dict:
    """Statistics and records of flown scenarios; missions that ended in error count as not captured."""
    from scipy.stats import binomtest

    captured = sum(outcome.captured for outcome in outcomes)
    good = [outcome for outcome in outcomes if not outcome.error]
    interval = binomtest(captured, len(outcomes)).proportion_ci(method="wilson")
    return {
        "success_rate": captured / len(outcomes),
        "success_rate_95": [interval.low, interval.high],
        "fuel_per_mu_kg": _mean([np.mean(outcome.fuel_kg) for outcome in good]),
        "fuel_per_mu_kg_95": _interval([np.mean(outcome.fuel_kg) for outcome in good]),
        "fuel_at_trigger_per_mu_kg": _mean([np.mean(outcome.fuel_at_trigger_kg) for outcome in good]),
        "locked_pairs": {str(pairs): n for pairs, n in sorted(Counter(o.locked_pairs for o in outcomes).items())},
        "cqi_mean": _mean([outcome.cqi for outcome in good]),
        "errors": sum(bool(outcome.error) for outcome in outcomes),
        "scenarios": [
            {"scenario": asdict(scenario), "outcome": asdict(outcome)}
            for scenario, outcome in zip(scenarios, outcomes, strict=True)
        ],
    }


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if len(values) else None


def _interval(values: Sequence[float]) -> list[float] | None:
    """95 % interval of the mean."""
    from scipy.stats import t

    if len(values) < 2:
        return None
    half = t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / math.sqrt(len(values))
    return [float(np.mean(values) - half), float(np.mean(values) + half)]


def _plain(value):
    """NaN and infinity are no JSON."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tethernet_planner.evaluate", description="Fly many random scenarios in full, in process."
    )
    parser.add_argument("--mus", type=int, choices=(4, 8), required=True)
    parser.add_argument("--policy", default=policies.NOMINAL, choices=policies.names())
    parser.add_argument("--control", default="default", choices=("default", "paper"), help="paper: its law as printed")
    parser.add_argument("--scenarios", type=int, default=100, metavar="N", help="how many, default 100")
    parser.add_argument("--seed", type=int, default=0, help="of the list of scenarios, default 0")
    parser.add_argument("--output", type=Path, metavar="FILE.json", help="statistics and one record per scenario")
    options = parser.parse_args(argv)
    if options.scenarios < 1:
        parser.error(f"--scenarios {options.scenarios}: allowed: 1 or more")
    if options.seed < 0:
        parser.error(f"--seed {options.seed}: allowed: 0 or more")
    if options.output and not options.output.absolute().parent.is_dir():
        parser.error(f"--output {options.output}: its folder does not exist")
    return options


def main(argv: Sequence[str] | None = None) -> int:
    """Fly, print a table, write the file. Returns 0; 2 for bad usage."""
    options = _arguments(argv)
    settings = Settings.paper() if options.control == "paper" else Settings.load()
    scenarios = random_scenarios(options.mus, options.scenarios, options.seed, options.policy)
    began = time.monotonic()

    def progress(done: int, total: int) -> None:
        elapsed = time.monotonic() - began
        left = elapsed / done * (total - done)
        print(f"{done} of {total} flown, {elapsed:.0f} s, about {left:.0f} s left", file=sys.stderr, flush=True)

    result = summary(scenarios, fly_many(scenarios, settings, progress=progress))
    head = {name: getattr(options, name) for name in ("mus", "policy", "control", "seed")}
    if options.output:
        partial = options.output.with_suffix(".partial")
        partial.write_text(json.dumps(_plain({**head, **result}), indent=2, allow_nan=False) + "\n", encoding="utf-8")
        partial.replace(options.output)
    low, high = result["success_rate_95"]
    print(f"{options.mus} MUs, policy {options.policy}, control {options.control}, {len(scenarios)} scenarios")
    print(f"  captured          {100 * result['success_rate']:.1f} %   (95 %: {100 * low:.1f} to {100 * high:.1f} %)")
    if result["fuel_per_mu_kg"] is not None:
        spread = result["fuel_per_mu_kg_95"]
        between = f"   (95 %: {spread[0]:.4f} to {spread[1]:.4f} kg)" if spread else ""
        print(f"  fuel per MU       {result['fuel_per_mu_kg']:.4f} kg{between}")
        print(f"  until the trigger {result['fuel_at_trigger_per_mu_kg']:.4f} kg")
        print(f"  CQI               {result['cqi_mean']:.2f}")
    print("  locked pairs      " + ", ".join(f"{pairs}: {n}" for pairs, n in result["locked_pairs"].items()))
    print(f"  errors            {result['errors']}")
    for record in result["scenarios"]:
        if not record["outcome"]["captured"]:
            print(f"  failed at {record['scenario']['debris_position']}: {record['outcome']['verdict']}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
