"""Two policies on the same scenarios with the same sensor noise, pair by pair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tethernet_learning.campaigns.statistics import Estimate, mean
from tethernet_sim.scenario import Outcome


@dataclass(frozen=True)
class Comparison:
    """A policy against the nominal aiming points. Intervals are Student's, of the mean over pairs, 95 %."""

    pairs: int
    """Scenarios that neither ended in error; all others are left out of what follows."""
    both: int
    """Captured with both."""
    only_nominal: int
    """Captured with the nominal points only."""
    only_policy: int
    """Captured with the policy only."""
    neither: int
    reduction: Estimate | None
    """Mean of (nominal fuel - the policy's) / nominal fuel [-], fuel of all MUs, launch to end."""
    reduction_where_captured: Estimate | None
    """The same over the scenarios that were captured with both."""
    saved_kg: tuple[float, ...]
    """Nominal fuel minus the policy's, of all MUs [kg], for each pair."""


def compare(nominal: Sequence[Outcome], policy: Sequence[Outcome]) -> Comparison:
    """Compare outcomes.

    Args:
        nominal: with the nominal aiming points.
        policy: of the same scenarios, in the same order, with the policy's.

    Raises:
        ValueError: when they are not of the same scenarios.
    """
    if [(o.mus, o.seed) for o in nominal] != [(o.mus, o.seed) for o in policy]:
        raise ValueError("these outcomes are not of the same scenarios in the same order")
    pairs = [(n, p) for n, p in zip(nominal, policy, strict=True) if not n.error and not p.error]
    counts = {(n, p): sum((a.captured, b.captured) == (n, p) for a, b in pairs) for n in (0, 1) for p in (0, 1)}
    return Comparison(
        pairs=len(pairs),
        both=counts[1, 1],
        only_nominal=counts[1, 0],
        only_policy=counts[0, 1],
        neither=counts[0, 0],
        reduction=mean([_reduction(n, p) for n, p in pairs]),
        reduction_where_captured=mean([_reduction(n, p) for n, p in pairs if n.captured and p.captured]),
        saved_kg=tuple(sum(n.fuel_kg) - sum(p.fuel_kg) for n, p in pairs),
    )


def _reduction(nominal: Outcome, policy: Outcome) -> float:
    return 1.0 - sum(policy.fuel_kg) / sum(nominal.fuel_kg)
