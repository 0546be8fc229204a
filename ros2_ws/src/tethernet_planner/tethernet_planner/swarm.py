"""What the MUs' odometry tells: where they are and, where nothing measures the net itself, where that is (real MUs
without a simulator).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

from tethernet_core.mission import Point, as_point
from tethernet_core.settings import ControlParameters
from tethernet_core.step_guard import StampGuard, Step
from tethernet_core.system import System


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
    one whose clock runs behind or ahead of the others'.
    """

    def __init__(self, mu_count: int, control: ControlParameters, drop: Callable[[str, str], None] = lambda *_: None):
        """Args:
        mu_count: number of MUs.
        control: an MU whose newest sample is off the swarm's time by more than its watchdog's patience is left out; it
            says also which stamps can be.
        drop: told (what, why) of every sample whose stamp cannot be.
        """
        self.positions: dict[int, Point] = {}
        self.velocities: dict[int, Point] = {}
        self._fresh: set[int] = set()
        self._clocks = {mu: StampGuard(control) for mu in range(1, mu_count + 1)}
        self._silent_ns = control.watchdog_periods * control.period_ns
        self._drop = drop

    @property
    def missing(self) -> set[int]:
        """MUs that have never been heard of."""
        return {mu for mu, clock in self._clocks.items() if clock.newest is None}

    @property
    def newest_ns(self) -> int:
        """The swarm's time: the newest stamp that a second clock comes near to [ns]; 0 before anything is heard.

        One clock that is wrong does not move it, and neither do MUs that have fallen silent.
        """
        stamps = sorted((clock.newest for clock in self._clocks.values() if clock.newest is not None), reverse=True)
        for newer, older in itertools.pairwise(stamps):
            if newer - older <= self._silent_ns:
                return newer
        return stamps[0] if stamps else 0

    @property
    def behind(self) -> dict[int, int]:
        """MUs that are left out now, with how far their newest sample is behind the swarm's time [ns]; below 0: ahead
        of it.
        """
        newest_ns = self.newest_ns
        late = {mu: newest_ns - clock.newest for mu, clock in self._clocks.items() if clock.newest is not None}
        return {mu: late_ns for mu, late_ns in late.items() if abs(late_ns) > self._silent_ns}

    def _present(self) -> set[int]:
        """MUs that a tick needs a sample of: all that are not left out, and all before each has spoken."""
        stamps = [clock.newest for clock in self._clocks.values() if clock.newest is not None]
        together = max(stamps) - min(stamps) <= self._silent_ns  # nearly always, and then nobody is left out
        if together or len(stamps) < len(self._clocks):
            return set(self._clocks)
        return self._clocks.keys() - self.behind.keys()

    def awaited(self, stamp_ns: int, period_ns: int) -> set[int]:
        """MUs whose sample of a control tick is still to come: those that keep step with the ticks and have not fallen
        silent. Whose stamps lie between the ticks is never waited for: its newest sample is as good as any.

        Args:
            stamp_ns: of the tick [ns].
            period_ns: control period [ns].
        """
        return {
            mu
            for mu, clock in self._clocks.items()
            if clock.newest is not None
            and clock.newest % period_ns == 0
            and 0 < stamp_ns - clock.newest <= self._silent_ns
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
        clock = self._clocks[mu]
        step = clock.take(stamp_ns)
        if not step.good:
            if step is Step.JUMP:
                self._drop(f"odometry of MU {mu}", clock.why(stamp_ns))
            return None
        self.positions[mu], self.velocities[mu] = position, velocity
        self._fresh.add(mu)
        present = self._present()
        if not present <= self._fresh:
            return None
        self._fresh.clear()
        centroid = as_point(sum(self.positions[mu][axis] for mu in present) / len(present) for axis in range(3))
        return SwarmTick(self.newest_ns, centroid)


class DockedPairs:
    """Which ring neighbours have docked, as far as the MUs' positions tell; once docked, a pair stays so.

    Where winches close the net, the units' positions tell nothing of the nodes that lock: no pair is counted there.
    """

    def __init__(self, system: System):
        """Args:
        system: gives the ring and the docking distance.
        """
        self._pairs = system.ring_neighbours
        self._distance_m = system.closing.docking_distance_m
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
