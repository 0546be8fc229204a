"""What the MUs' odometry tells: where they are and, where nothing measures the net itself, where that is (real MUs
without a simulator).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tethernet_control.layout import design

Point = tuple[float, float, float]


@dataclass(frozen=True)
class SwarmTick:
    """One control tick of the swarm."""

    stamp_ns: int
    """Newest stamp among the samples [ns]."""
    position: Point
    """Centroid of the MUs [m], frame launch."""


class SwarmCentroid:
    """Collects the samples of MUs whose clocks do not tick together.

    A tick is complete when every MU has given a sample newer than at the last tick; there is none before all have
    spoken. Later, an MU that has fallen silent is left out, so that one dead driver does not stop the mission; so is
    one whose clock runs that far behind.
    """

    def __init__(self, mu_count: int, silent_ns: int):
        """Args:
        mu_count: number of MUs.
        silent_ns: an MU whose newest sample is older than the newest of all by more than this [ns] is left out.
        """
        self.positions: dict[int, Point] = {}
        self.velocities: dict[int, Point] = {}
        self._stamps: dict[int, int] = {}
        self._fresh: set[int] = set()
        self._mus = frozenset(range(1, mu_count + 1))
        self._silent_ns = silent_ns

    @property
    def missing(self) -> set[int]:
        """MUs that have never been heard of."""
        return set(self._mus - self._stamps.keys())

    @property
    def behind(self) -> dict[int, int]:
        """MUs that are left out now, with how far their newest sample is behind the newest of all [ns]."""
        newest_ns = max(self._stamps.values(), default=0)
        return {mu: newest_ns - stamp for mu, stamp in self._stamps.items() if newest_ns - stamp > self._silent_ns}

    def awaited(self, stamp_ns: int, period_ns: int) -> set[int]:
        """MUs whose sample of a control tick is still to come: those that keep step with the ticks and have not fallen
        silent. Whose stamps lie between the ticks is never waited for: its newest sample is as good as any.

        Args:
            stamp_ns: of the tick [ns].
            period_ns: control period [ns].
        """
        return {
            mu
            for mu, stamp in self._stamps.items()
            if stamp % period_ns == 0 and 0 < stamp_ns - stamp <= self._silent_ns
        }

    def update(self, mu: int, stamp_ns: int, position: Point, velocity: Point = (0.0, 0.0, 0.0)) -> SwarmTick | None:
        """Take one sample; samples out of order are ignored.

        Args:
            mu: number of the MU.
            stamp_ns: its time [ns].
            position: finite [m].
            velocity: finite [m/s].

        Returns:
            The tick that this sample completes, if it does.
        """
        if stamp_ns <= self._stamps.get(mu, -1):
            return None
        self._stamps[mu], self.positions[mu], self.velocities[mu] = stamp_ns, position, velocity
        self._fresh.add(mu)
        present = self._stamps.keys() - self.behind.keys()
        if self.missing or not present <= self._fresh:
            return None
        self._fresh.clear()
        centroid = tuple(sum(self.positions[mu][axis] for mu in present) / len(present) for axis in range(3))
        return SwarmTick(max(self._stamps.values()), centroid)


class DockedPairs:
    """Which ring neighbours have docked, as far as the MUs' positions tell; once docked, a pair stays so.

    Winches close the net of 4 MUs; the MUs' positions tell nothing of the knots that they lock, so no pair is ever
    counted there.
    """

    def __init__(self, mu_count: int, docking_distance_m: float):
        """Args:
        mu_count: 4 or 8.
        docking_distance_m: neighbours nearer than this dock [m].
        """
        ring = design(mu_count).closing_ring
        self._pairs = [(ring[i], ring[(i + 1) % len(ring)]) for i in range(len(ring))]
        self._distance_m = docking_distance_m
        self.docked: set[tuple[int, int]] = set()

    def update(self, positions: dict[int, Point]) -> int:
        """Look at the newest positions [m]; returns the number of docked pairs."""
        for pair in self._pairs:
            one, other = (positions.get(mu) for mu in pair)
            if one is not None and other is not None and math.dist(one, other) <= self._distance_m:
                self.docked.add(pair)
        return len(self.docked)

    @property
    def locked(self) -> list[bool]:
        """One for each pair of neighbours, in their order round the mouth."""
        return [pair in self.docked for pair in self._pairs]
