"""The whole mission in one call, without ROS: the same physics, control, mission rules and capture test as the
nodes.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_control.law_numbers import law_numbers
from tethernet_core.mission import Mission, Phase, arm, launch, seconds_between
from tethernet_core.parameters import ParameterError, load
from tethernet_core.settings import NANOSECOND_S, ControlParameters, MissionParameters, paper_values
from tethernet_core.system import System
from tethernet_planner.closing_situation import ClosingSituation, closing_situation, off_course
from tethernet_planner.mission_rules import advance
from tethernet_planner.plan_ahead import PlanAhead
from tethernet_sim.compiling import compiling_said
from tethernet_sim.failure import MuFailure
from tethernet_sim.judging import Judge, Spent
from tethernet_sim.kernels import control as control_kernels
from tethernet_sim.memory import most_scenarios
from tethernet_sim.model import build_model
from tethernet_sim.scenario import Outcome, Scenario, default_system, described
from tethernet_sim.sensors import OdometryNoise
from tethernet_sim.settings import PhysicsParameters, check_together
from tethernet_sim.stability import check_stable
from tethernet_sim.state import DEBRIS
from tethernet_sim.world import World, divergence

CHUNK = 64
"""Scenarios flown together: enough to keep all cores busy until the last one ends, small enough for the caches."""

Observer = Callable[[int, World, np.ndarray], None]
"""Called at every control tick with (time since launch [ns], world, indices of the scenarios still flying)."""

AtTrigger = Callable[[int, World, int], None]
"""Called when closing begins with (number of the scenario in the list, world, its index in the world)."""


@dataclass(frozen=True)
class Settings:
    """All parameters of a flight."""

    physics: PhysicsParameters
    control: ControlParameters
    mission: MissionParameters

    def __post_init__(self) -> None:
        """Raises:
        ParameterError: for parameters that do not fit together.
        """
        check_together(self.physics, self.control)

    @classmethod
    def load(cls, system: System | str | Path | None = None, **overrides: Mapping[str, Any]) -> Settings:
        """The parameters that a system is flown with, with some values replaced: the defaults, the system's own over
        them, and over those what is given: ``Settings.load("zenit_8mu", control={"kp": 4.0})``.

        Args:
            system: a system, the name of a shipped one or the path of a description; None: the default one.
            overrides: values by subsystem (control, mission, physics) and name.

        Raises:
            ParameterError: for an unknown subsystem or key, a wrong type, a value out of range, a time step that is
                unstable for the system.
        """
        return cls._load(system, {}, overrides)

    @classmethod
    def paper(cls, system: System | str | Path | None = None, **overrides: Mapping[str, Any]) -> Settings:
        """The paper's control as printed, the baseline; else as :meth:`load`."""
        printed = {name: paper_values(_KINDS[name]) for name in ("control", "mission")}
        return cls._load(system, printed, overrides)

    @classmethod
    def _load(
        cls,
        system: System | str | Path | None,
        printed: Mapping[str, Mapping[str, Any]],
        overrides: Mapping[str, Mapping[str, Any]],
    ) -> Settings:
        of = described(default_system() if system is None else system)
        for name in overrides:
            if name not in _KINDS:
                raise ParameterError(f"no subsystem {name!r} has parameters; allowed: {', '.join(_KINDS)}")
        settings = cls(
            **{
                name: load(kind, {**of.parameters.get(name, {}), **printed.get(name, {}), **overrides.get(name, {})})
                for name, kind in _KINDS.items()
            }
        )
        check_stable(of, settings.physics)
        return settings


_KINDS: Mapping[str, type] = {
    "physics": PhysicsParameters, "control": ControlParameters, "mission": MissionParameters,
}  # fmt: skip


def fly(scenario: Scenario, settings: Settings | None = None, observer: Observer | None = None) -> Outcome:
    """Fly one scenario to its end; see :func:`fly_many`."""
    return fly_many([scenario], settings, observer)[0]


def fly_many(
    scenarios: Iterable[Scenario],
    settings: Settings | None = None,
    observer: Observer | None = None,
    progress: Callable[[int, int], None] | None = None,
    at_trigger: AtTrigger | None = None,
    stop_at_trigger: bool = False,
) -> list[Outcome]:
    """Fly scenarios to their ends, on all cores (NUMBA_NUM_THREADS limits them).

    Each scenario gives the same bits whether it is flown alone or among others.

    Args:
        scenarios: of any mixture of systems.
        settings: parameters for all; None for those that each system is flown with.
        observer: looks at every control tick of every chunk.
        progress: called with (scenarios done, scenarios in all) after each chunk.
        at_trigger: looks at every scenario at the control tick at which its closing begins.
        stop_at_trigger: fly no further than that tick; such outcomes are marked ``stopped_at_trigger``, what they
            would have come to is unknown (NaN, not captured).

    Returns:
        Outcomes in the order of the scenarios.

    Raises:
        ParameterError: for a system of which not one scenario fits into the memory.
    """
    scenarios = list(scenarios)
    outcomes: dict[int, Outcome] = {}
    done = 0
    by_system: dict[System, list[int]] = {}
    for i, scenario in enumerate(scenarios):
        by_system.setdefault(scenario.system, []).append(i)
    for system, indices in by_system.items():
        parameters = settings or Settings.load(system)
        model, begin = build_model(system, parameters.physics), 0
        while begin < len(indices):
            chunk = indices[begin : begin + most_scenarios(model, min(CHUNK, len(indices) - begin), system.name)]
            begin += len(chunk)
            look = None if at_trigger is None else functools.partial(_look_at, at_trigger, chunk)
            with compiling_said():
                flown = _Flight([scenarios[i] for i in chunk], parameters).fly(observer, look, stop_at_trigger)
            for i, outcome in zip(chunk, flown, strict=True):
                outcomes[i] = outcome
            done += len(chunk)
            if progress:
                progress(done, len(scenarios))
    return [outcomes[i] for i in range(len(scenarios))]


def _look_at(at_trigger: AtTrigger, chunk: Sequence[int], world: World, b: int) -> None:
    """Tell which scenario of the list the one with index ``b`` of a chunk is."""
    at_trigger(chunk[b], world, b)


class _Flight:
    """A chunk of scenarios of one system in flight."""

    def __init__(self, scenarios: list[Scenario], settings: Settings):
        self.scenarios, self.settings = scenarios, settings
        self.system = system = scenarios[0].system
        batch, mus = len(scenarios), system.unit_count
        self.world = World(
            system,
            np.array([s.debris_position for s in scenarios], float),
            np.array([s.debris_attitude for s in scenarios], float),
            np.array([s.debris_rate for s in scenarios], float),
            settings.physics,
            settings.control,
        )
        self.judge = Judge(self.world, scenarios)
        asked = Mission(mus, hold_s=settings.mission.hold_s, tow_n=settings.mission.tow_n)
        self.missions = [launch(arm(asked, s.debris_position, ""), 0) for s in scenarios]
        self.ahead = [PlanAhead(system, settings.mission) for _ in scenarios]
        self.noise = [OdometryNoise(s.seed, mus, settings.control) for s in scenarios]
        self.heard_position, self.heard_velocity = np.zeros((2, batch, mus, 3))
        self.aim = np.array([s.aiming_points() for s in scenarios])
        self.close = self.aim.copy()
        self.start = np.zeros((batch, mus, 3))
        self.law = law_numbers(settings.control, system.units[0]) if mus else None
        units = system.units
        self.mass = np.array([unit.mass_kg for unit in units])
        self.limit = np.array([unit.thrust_limit_n for unit in units])
        self.specific_impulse = np.array([unit.specific_impulse_s for unit in units])
        self.propellant = np.array([unit.propellant_kg for unit in units])
        self.estimate = np.zeros((batch, mus, 9))
        self.covariance = np.zeros((batch, mus, 6))
        self.integral = np.zeros((batch, mus, 3))
        self.carry = np.zeros((batch, mus, 3))
        self.thrust = np.zeros((batch, mus, 3))
        self.closing_elapsed = np.full(batch, -1.0)
        self.closing_duration = np.ones(batch)
        self.off = np.zeros((batch, mus), bool)
        self.failures = [MuFailure(s.failure, settings.control) for s in scenarios]
        self.fuel = np.zeros((batch, mus))
        self.fuel_at_trigger = np.zeros((batch, mus))
        self.largest_error = np.zeros(batch)
        self.mouth: list[float | None] = [None] * batch
        self.outcomes: dict[int, Outcome] = {}

    def fly(
        self,
        observer: Observer | None,
        at_trigger: Callable[[World, int], None] | None,
        stop_at_trigger: bool,
    ) -> list[Outcome]:
        control = self.settings.control
        flying = np.arange(len(self.scenarios))
        stamp_ns = 0
        for index in range(len(self.scenarios)):
            self.world.launch(index)
        while len(flying):
            for b in self._begin_closing(flying, stamp_ns):
                if at_trigger:
                    at_trigger(self.world, b)
                if stop_at_trigger:
                    self.outcomes[b] = self.judge.at_trigger(b, stamp_ns, self.missions[b], self._spent(b))
            flying = np.array([b for b in flying if int(b) not in self.outcomes], dtype=int)
            if not len(flying):
                break
            if observer:
                observer(stamp_ns, self.world, flying)
            self._command(flying, stamp_ns)
            flying = self._decide(flying, stamp_ns)
            fired = self._fired(flying, stamp_ns)
            self.world.advance(fired, flying)
            self.judge.loads.look(flying)
            control_kernels.book_fuel(
                flying,
                fired,
                control.period_ns * NANOSECOND_S,
                self.specific_impulse,
                control.standard_gravity_m_s2,
                self.fuel,
            )
            stamp_ns += control.period_ns
        return [self.outcomes[b] for b in range(len(self.scenarios))]

    def _begin_closing(self, flying: np.ndarray, stamp_ns: int) -> list[int]:
        """What happens at the tick at which closing begins, before anything is measured; returns where it begins."""
        begun = []
        for b in flying:
            mission = self.missions[b]
            if mission.closing and stamp_ns == mission.closing_ns:
                self.world.begin_closing(b)
                self.fuel_at_trigger[b] = self.fuel[b]
                self.mouth[b] = self.judge.mouth_area(b)
                if not mission.closing_points and not mission.units_fly_on:
                    self.off[b] = True
                begun.append(b)
        return begun

    def _command(self, flying: np.ndarray, stamp_ns: int) -> None:
        """Sense and command."""
        if self.law is None:
            return
        control, state = self.settings.control, self.world.state
        noise = np.array([self.noise[b].draw_next() for b in flying])
        position, velocity = state.mu_pos.copy(), state.mu_vel.copy()
        position[flying] += noise[:, :, 0]
        velocity[flying] += noise[:, :, 1]
        if stamp_ns == 0:
            self.start[:] = position
        self._hear(flying, stamp_ns, position, velocity)
        for b in flying:
            mission = self.missions[b]
            if mission.closing:
                if not mission.units_fly_on:
                    self.closing_elapsed[b] = seconds_between(mission.closing_ns, stamp_ns)
                    self.closing_duration[b] = mission.closing_duration_s
                if mission.closing_points:
                    self.close[b] = mission.closing_points
                if mission.docked_ns:
                    self.off[b] = [mission.docked(mu, stamp_ns) for mu in range(1, mission.mu_count + 1)]
                if stamp_ns >= mission.end_ns:
                    self.off[b] = True
            self.off[b] |= self.fuel[b] >= self.propellant
        control_kernels.command(
            self.law, self.mass, self.limit, flying, position, velocity, seconds_between(0, stamp_ns),
            self.closing_elapsed, self.closing_duration, control.period_ns * NANOSECOND_S, self.off, self.start,
            self.aim, self.close, self.estimate, self.covariance, self.integral, self.carry, self.thrust,
            self.largest_error,
        )  # fmt: skip

    def _hear(self, flying: np.ndarray, stamp_ns: int, position: np.ndarray, velocity: np.ndarray) -> None:
        """Keep the MUs' odometry as the planner has it: of an MU that has fallen silent, the last sample."""
        heard = np.zeros(position.shape[:2], bool)
        heard[flying] = True
        for b in flying:
            if self.failures[b].mute(stamp_ns):
                heard[b, self.failures[b].mu] = False
        self.heard_position[heard], self.heard_velocity[heard] = position[heard], velocity[heard]

    def _fired(self, flying: np.ndarray, stamp_ns: int) -> np.ndarray:
        """What the thrusters do of what was commanded [N], (B, M, 3): the same, but where an MU has failed."""
        fired = self.thrust
        for b in flying:
            if self.failures[b].begun(stamp_ns):
                fired = self.thrust.copy() if fired is self.thrust else fired
                fired[b, self.failures[b].mu] = self.failures[b].fired(stamp_ns, self.thrust[b, self.failures[b].mu])
        return fired

    def _look(self, b: int, stamp_ns: int) -> ClosingSituation:
        """What the planner knows of one scenario: the units' odometry, and the debris as it is."""
        mus = self.heard_position[b].copy()
        lost = list(off_course(mus, self.aim[b], self.system, self.settings.mission))
        if self.failures[b].silent(stamp_ns):
            lost[self.failures[b].mu] = True
        return closing_situation(mus, self.heard_velocity[b].copy(), *self.world.body_motion(b, DEBRIS), lost)

    def _decide(self, flying: np.ndarray, stamp_ns: int) -> np.ndarray:
        """The planner's part: trigger, end. Returns the scenarios that fly on."""
        rules, control = self.settings.mission, self.settings.control
        going_on = []
        for b, diverged in zip(flying, self.world.diverged(flying), strict=True):
            if diverged:
                self.outcomes[b] = self._outcome(b, stamp_ns, error=divergence(seconds_between(0, stamp_ns)))
                continue
            before = self.missions[b]
            self.missions[b] = advance(
                before,
                self.system,
                stamp_ns,
                self.world.net_center(b),
                self.world.debris_position(b),
                rules,
                control,
                self.world.state.locked[b],
                functools.partial(self._look, b, stamp_ns),
                self.ahead[b],
            )
            mission = self.missions[b]
            if mission.phase.over:
                tested = before.phase == Phase.HOLDING
                self.outcomes[b] = self._after_hold(b) if tested else self._outcome(b, stamp_ns)
                continue
            if mission.phase == Phase.HOLDING:
                self._hold(b, stamp_ns)
            going_on.append(b)
        return np.array(going_on, dtype=int)

    def _spent(self, b: int) -> Spent:
        return Spent(self.fuel[b], self.fuel_at_trigger[b], self.mouth[b], float(self.largest_error[b]))

    def _outcome(self, b: int, stamp_ns: int, error: str = "") -> Outcome:
        """The end of a mission that has no hold test, or does not get through it."""
        mission = self.missions[b]
        outcome = self.judge.outcome(b, stamp_ns, mission, self._spent(b), error)
        return self.judge.never_held(outcome, mission.hold_s, mission.tow_n)

    def _after_hold(self, b: int) -> Outcome:
        return self.judge.after_hold(b, self.missions[b].hold_s, self.missions[b].tow_n)

    def _hold(self, b: int, stamp_ns: int) -> None:
        """A control tick of a hold test, the one of the verdict included."""
        mission = self.missions[b]
        if stamp_ns < mission.hold_ns:
            self.judge.begin_hold(b, self.judge.outcome(b, stamp_ns, mission, self._spent(b)))
        else:
            self.world.tow(b, mission.tow_n)
