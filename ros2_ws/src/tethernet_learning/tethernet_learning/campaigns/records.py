"""Statistics and records of flown scenarios, as JSON holds them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from tethernet_core.capture_quality import tight
from tethernet_core.system import System
from tethernet_learning.campaigns.cases import Case
from tethernet_learning.campaigns.statistics import Estimate, summarise
from tethernet_sim.scenario import Outcome


def records(cases: Sequence[Case], outcomes: Sequence[Outcome], system: System) -> dict[str, Any]:
    """Statistics and records of flown scenarios, ready for JSON; missions in error count as not captured."""
    summary = summarise(outcomes)
    return {
        "success_rate": summary.success.value,
        "success_rate_95": _interval(summary.success),
        "held_rate": _value(summary.held),
        "held_rate_95": _interval(summary.held),
        "enclosed_rate": summary.enclosed.value,
        "both_cqi_rate": sum(tight(o.cqi, system) and tight(o.cqi_all, system) for o in outcomes) / len(outcomes),
        "fuel_per_mu_kg": _value(summary.fuel_kg),
        "fuel_per_mu_kg_95": _interval(summary.fuel_kg),
        "fuel_at_trigger_per_mu_kg": _value(summary.fuel_at_trigger_kg),
        "locked_pairs": {str(pairs): count for pairs, count in summary.locked_pairs.items()},
        "cqi_mean": summary.cqi,
        "cqi_below_threshold": sum(tight(outcome.cqi, system) for outcome in outcomes),
        "cqi_all_mean": summary.cqi_all,
        "cqi_all_below_threshold": sum(tight(outcome.cqi_all, system) for outcome in outcomes),
        "mcqi_mean": summary.mcqi,
        "max_load_share": summary.load_share,
        "max_contact_force_n": summary.contact_force_n,
        "errors": summary.errors,
        "scenarios": [
            {"scenario": case.scenario.record(), "outcome": asdict(outcome)}
            for case, outcome in zip(cases, outcomes, strict=True)
        ],
    }


def _value(estimate: Estimate | None) -> float | None:
    return None if estimate is None else estimate.value


def _interval(estimate: Estimate | None) -> list[float] | None:
    return None if estimate is None or math.isnan(estimate.low) else [estimate.low, estimate.high]


def plain(value: Any) -> Any:
    """NaN and infinity are no JSON."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
