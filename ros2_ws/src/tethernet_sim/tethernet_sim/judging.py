"""What becomes of the scenarios of a flight: their outcomes at the verdict, and after a hold test."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from tethernet_core.capture_quality import captured, deciding, hull_quality, mouth_area, verdict
from tethernet_core.enclosure import enclosed
from tethernet_core.hold import held, never_held, overload
from tethernet_core.mission import Mission, Phase, seconds_between
from tethernet_core.modified_quality import modified_quality
from tethernet_sim.loads import Loads
from tethernet_sim.scenario import Outcome, Scenario
from tethernet_sim.state import ATTITUDE, DEBRIS
from tethernet_sim.world import World


@dataclass(frozen=True)
class Spent:
    """What one scenario took so far."""

    fuel_kg: np.ndarray
    """Per unit, shape (M,)."""
    fuel_at_trigger_kg: np.ndarray
    """Per unit up to the start of closing, or up to now, shape (M,)."""
    mouth_area_m2: float | None
    largest_error_m: float


class Judge:
    """Judges the scenarios of one world."""

    def __init__(self, world: World, scenarios: list[Scenario]):
        """Args:
        world: that is flown.
        scenarios: its scenarios.
        """
        self.loads = Loads(world)
        self._world, self._scenarios, self._system = world, scenarios, world.system
        self._judged: dict[int, Outcome] = {}
        self._locked: dict[int, list[bool]] = {}

    def mouth_area(self, b: int) -> float | None:
        """Area of the mouth now [m^2]; None where nothing spans it."""
        area = mouth_area(self._world.mus_as_published(b), self._system, self._world.knots_as_published(b))
        return None if math.isnan(area) else area

    def at_trigger(self, b: int, stamp_ns: int, mission: Mission, spent: Spent) -> Outcome:
        """The outcome of a flight that goes no further than the start of closing."""
        text = "flown to the start of closing only"
        unknown = self.outcome(b, stamp_ns, mission, spent, text)
        return dataclasses.replace(unknown, verdict=text, error="", stopped_at_trigger=True)

    def outcome(self, b: int, stamp_ns: int, mission: Mission, spent: Spent, error: str = "") -> Outcome:
        """The outcome as of now: the verdict, or an error. Where a hold test was to follow, it was not passed."""
        scenario, system, world = self._scenarios[b], self._system, self._world
        missed = mission.phase == Phase.MISSED
        locked = int(world.state.locked[b].sum())
        cqi = cqi_all = mcqi = distance = math.nan
        inside: bool | None = None
        if not error:
            knots, mus, debris = world.knots_as_published(b), world.mus_as_published(b), world.debris_position(b)
            attitude = world.state.bodies[b, DEBRIS, ATTITUDE]
            hull = hull_quality(knots, mus, world.net_center(b), debris, system, world.net_center_all(b))
            cqi, cqi_all, distance = hull.cqi, hull.cqi_all, hull.distance
            mcqi = modified_quality(knots, mus, np.array(debris), attitude, system)
            inside = self._inside(b)
        decides, share = deciding(cqi, cqi_all, system), self.loads.share(b)
        text = verdict(decides, locked, system, mission.reason if missed else "") + overload(share)
        return Outcome(
            captured=not error and not missed and captured(decides, locked, system),
            verdict=f"error: {error}" if error else text,
            cqi=cqi,
            cqi_all=cqi_all,
            mcqi=mcqi,
            enclosed=inside,
            locked_pairs=locked,
            trigger_time_s=seconds_between(0, mission.closing_ns) if mission.closing else None,
            end_time_s=seconds_between(0, stamp_ns),
            fuel_kg=tuple(spent.fuel_kg.tolist()),
            fuel_at_trigger_kg=tuple((spent.fuel_at_trigger_kg if mission.closing else spent.fuel_kg).tolist()),
            mouth_area_m2=spent.mouth_area_m2,
            net_debris_distance_m=distance,
            max_tracking_error_m=spent.largest_error_m if scenario.mus else math.nan,
            max_load_share=share,
            max_contact_force_n=self.loads.contact_n(b),
            seed=scenario.seed,
            mus=scenario.mus,
            system=system.name,
            error=error,
        )

    def never_held(self, outcome: Outcome, hold_s: float, tow_n: float) -> Outcome:
        """The outcome of a mission that was to be tested for holding and never got there: it does not hold."""
        if hold_s == 0.0:
            return outcome
        found = never_held(outcome.verdict)
        return dataclasses.replace(outcome, held=found.held, hold_verdict=found.verdict, hold_s=hold_s, tow_n=tow_n)

    def begin_hold(self, b: int, judged: Outcome) -> None:
        """The verdict has been given, and the hold test begins."""
        self._judged[b] = judged
        self._locked[b] = self._world.state.locked[b].tolist()

    def after_hold(self, b: int, hold_s: float, tow_n: float) -> Outcome:
        """The outcome at the end of the hold test: that of the verdict, and whether it held."""
        share = self.loads.share(b)
        found = held(self._inside(b), self._locked[b], self._world.state.locked[b].tolist(), share)
        return dataclasses.replace(
            self._judged[b],
            held=found.held,
            hold_verdict=found.verdict,
            hold_s=hold_s,
            tow_n=tow_n,
            max_load_share=share,
            max_contact_force_n=self.loads.contact_n(b),
        )

    def _inside(self, b: int) -> bool:
        world = self._world
        return enclosed(
            world.knots_as_published(b), world.mus_as_published(b), np.array(world.debris_position(b)),
            world.state.bodies[b, DEBRIS, ATTITUDE], self._system,
        )  # fmt: skip
