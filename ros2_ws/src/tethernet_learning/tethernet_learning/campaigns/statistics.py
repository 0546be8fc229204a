"""How well it went: shares and means with their 95 % intervals."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tethernet_sim.scenario import Outcome

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """A value with the 95 % interval around it."""

    value: float
    low: float
    """NaN where nothing can be said."""
    high: float


@dataclass(frozen=True)
class Summary:
    """Statistics of flown missions."""

    count: int
    """Missions, those in error too."""
    captured: int
    errors: int
    success: Estimate
    """Captured of all; a mission in error counts as not captured."""
    fuel_kg: Estimate | None
    """Mean over missions of the mean fuel of one MU, launch to end [kg]; None when every mission ended in error, or
    nothing has units."""
    fuel_at_trigger_kg: Estimate | None
    """The same, launch to the start of closing [kg]."""
    cqi: float | None
    """Mean settled CQI of the missions that have one, with the knots' centre of mass."""
    cqi_all: float | None
    """The same with the MUs counted."""
    mcqi: float | None
    """Mean modified CQI."""
    enclosed: Estimate
    """Round whose whole debris the closed net goes at the verdict, of all."""
    held: Estimate | None
    """Held of all; None without a hold test. A mission that did not get as far counts as not held."""
    load_share: float | None
    """Largest tension of any thread over its strength, of all missions."""
    contact_force_n: float | None
    """Largest contact force on the debris [N], of all missions."""
    locked_pairs: dict[int, int]
    """How often so many pairs were locked."""


def share(count: int, total: int) -> Estimate:
    """A share with Wilson's score interval.

    Args:
        count: how many.
        total: of how many, at least 1.
    """
    from scipy.stats import binomtest

    interval = binomtest(count, total).proportion_ci(CONFIDENCE, method="wilson")
    return Estimate(count / total, interval.low, interval.high)


def mean(values: Sequence[float]) -> Estimate | None:
    """A mean with Student's t interval.

    Args:
        values: any number of them; NaN is left out.

    Returns:
        None without any value; with one value the interval is NaN.
    """
    from scipy.stats import t

    known = np.asarray(values, float)
    known = known[~np.isnan(known)]
    if not len(known):
        return None
    center = float(np.mean(known))
    if len(known) == 1:
        return Estimate(center, math.nan, math.nan)
    half = float(t.ppf(0.5 + CONFIDENCE / 2.0, len(known) - 1) * np.std(known, ddof=1)) / math.sqrt(len(known))
    return Estimate(center, center - half, center + half)


def summarise(outcomes: Sequence[Outcome]) -> Summary:
    """Statistics of missions.

    Args:
        outcomes: at least one.
    """
    good = [outcome for outcome in outcomes if not outcome.error]
    captured = sum(outcome.captured for outcome in outcomes)
    cqi, cqi_all, mcqi = (mean([getattr(outcome, name) for outcome in good]) for name in ("cqi", "cqi_all", "mcqi"))
    tested = any(outcome.hold_s > 0.0 for outcome in outcomes)
    return Summary(
        count=len(outcomes),
        captured=captured,
        errors=len(outcomes) - len(good),
        success=share(captured, len(outcomes)),
        fuel_kg=mean([float(np.mean(outcome.fuel_kg)) for outcome in good if outcome.fuel_kg]),
        fuel_at_trigger_kg=mean([float(np.mean(outcome.fuel_at_trigger_kg)) for outcome in good if outcome.fuel_kg]),
        cqi=None if cqi is None else cqi.value,
        cqi_all=None if cqi_all is None else cqi_all.value,
        mcqi=None if mcqi is None else mcqi.value,
        enclosed=share(sum(outcome.enclosed is True for outcome in outcomes), len(outcomes)),
        held=share(sum(outcome.held is True for outcome in outcomes), len(outcomes)) if tested else None,
        load_share=_largest([outcome.max_load_share for outcome in outcomes]),
        contact_force_n=_largest([outcome.max_contact_force_n for outcome in outcomes]),
        locked_pairs=dict(sorted(Counter(outcome.locked_pairs for outcome in outcomes).items())),
    )


def _largest(values: Sequence[float]) -> float | None:
    known = [value for value in values if math.isfinite(value)]
    return max(known, default=None)
