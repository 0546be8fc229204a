"""One MU's controller without ROS: mission and odometry in, thrust and account out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tethernet_control import estimator, law
from tethernet_control.law_numbers import law_numbers
from tethernet_core.bounds import FARTHEST_M
from tethernet_core.mission import Mission, Mode, Phase, Point, as_point, seconds_between
from tethernet_core.mission_gate import MissionGate
from tethernet_core.settings import NANOSECOND_S, ControlParameters
from tethernet_core.step_guard import StampGuard, Step
from tethernet_core.system import Unit

ZERO = (0.0, 0.0, 0.0)
_FARTHEST = FARTHEST_M
"""[m], [m/s] No MU is so far off or so fast: the estimate's arithmetic stays finite."""


@dataclass
class ControllerStatistics:
    """What a controller reports of itself; the fields of tethernet_msgs/MuStatus."""

    fuel_kg: float = 0.0
    fuel_at_trigger_kg: float = 0.0
    tracking_error_m: float = 0.0
    """From the reference to where the controller thinks it is: the estimate, or the sample where nothing is
    estimated."""
    max_tracking_error_m: float = 0.0
    commands: int = 0
    saturated: int = 0
    rejected_odometry: int = 0
    clock_jumps: int = 0
    """Of the rejected: samples whose stamp was far off the last one."""
    clock_resets: int = 0
    """Times that odometry's clock was found set anew."""
    deadline_misses: int = 0
    outliers: int = 0
    """Samples that the filter turned away."""
    position_sigma_m: float = 0.0
    """Of the estimate, per axis; of the samples where nothing is estimated [m]."""
    velocity_sigma_m_s: float = 0.0
    """Likewise [m/s]."""


class MuController:
    """Flies one MU: follows the mission's phases, tracks the trajectory, keeps the fuel account.

    It knows nothing of where odometry comes from. Time is the odometry's stamp; the only use of another clock is the
    watchdog, whose caller decides when odometry is late.
    """

    def __init__(self, mu: int, parameters: ControlParameters, unit: Unit):
        """Args:
        mu: number of the unit, from 1.
        parameters: gains, periods.
        unit: its mass, thrusters and propellant.
        """
        self.mu = mu
        self.parameters = parameters
        self.unit = unit
        self.mode = Mode.IDLE
        self.statistics = ControllerStatistics()
        self.aiming_point: Point | None = None
        self.aiming_source = ""
        self.desired = [math.nan] * 3
        self.stamp_ns: int | None = None
        self.dropped_because = ""
        """Why the newest dropped sample was."""
        self._gate = MissionGate(Mission(mu_count=mu))
        self._clock, self._beats = StampGuard(parameters), StampGuard(parameters)
        self._planner_ns: int | None = None
        self._start: list[float] | None = None
        self._close_before: tuple[Point, ...] = ()
        self._law = law_numbers(parameters, unit)
        self._state = [0.0] * 9
        self._covariance = [0.0] * 6
        self._integral = [0.0, 0.0, 0.0]
        self._carry = [0.0, 0.0, 0.0]
        self._speed = [0.0, 0.0, 0.0]
        self._thrust = [0.0, 0.0, 0.0]

    @property
    def mission(self) -> Mission:
        """The newest state of the mission that counts."""
        return self._gate.mission

    @property
    def refused_states(self) -> int:
        """States of the mission that were refused; see :class:`MissionGate`."""
        return self._gate.refused

    @property
    def propellant_kg(self) -> float:
        """What is left on board [kg]."""
        return max(0.0, self.unit.propellant_kg - self.statistics.fuel_kg)

    def take_mission(self, mission: Mission) -> bool:
        """Take over a newer state of the mission.

        A state of another planner's mission, where it counts, begins a new flight: its aiming point is still to come.

        Returns:
            True when it counts; see :class:`MissionGate`.
        """
        before = self.mission
        news = self._gate.take(mission, self._planner_lost(self.stamp_ns))
        if self._gate.is_present(mission):  # also said again, as confirmed
            self._planner_ns = self.stamp_ns
        if not news:
            return False
        if mission.mission_id != before.mission_id and not mission.phase.over:
            self._begin_flight()
        elif before.closing_points:
            self._close_before = before.closing_points
        if mission.phase.over:
            self.mode = Mode.OFF
        return True

    def on_heartbeat(self, stamp_ns: int) -> None:
        """The planner has decided on the control tick at ``stamp_ns``."""
        if self._beats.take(stamp_ns).good:
            self._planner_ns = self.stamp_ns

    def _planner_lost(self, stamp_ns: int | None) -> bool:
        """Whether nothing has been heard of the planner for too long, by the odometry's stamps: where they stand still,
        as in a lock-step that halts, no time has passed.
        """
        if self._planner_ns is None or stamp_ns is None:
            return False
        return seconds_between(self._planner_ns, stamp_ns) > self.parameters.planner_timeout_s

    def _begin_flight(self) -> None:
        self.aiming_point, self.aiming_source = None, ""
        self.desired[:] = [math.nan] * 3
        self._start, self._close_before = None, ()
        self._integral[:] = self._carry[:] = ZERO
        self.statistics.tracking_error_m = self.statistics.max_tracking_error_m = 0.0

    def aim(self, point: Iterable[float], source: str) -> None:
        """Set the aiming point [m] and where it comes from."""
        self.aiming_point = as_point(point)
        self.aiming_source = source

    def on_odometry(
        self, stamp_ns: int, position: Sequence[float], velocity: Sequence[float]
    ) -> tuple[float, float, float] | None:
        """Answer one odometry sample.

        Args:
            stamp_ns: its time [ns].
            position: measured, x y z [m], frame launch.
            velocity: measured, x y z [m/s], frame launch.

        Returns:
            The thrust [N] until the next sample, or None when the sample was dropped, see ``dropped_because``: its
            numbers or its stamp cannot be.
        """
        if not all(abs(value) < _FARTHEST for value in (*position, *velocity)):  # NaN is not
            self._drop(f"not finite, or not within {_FARTHEST:g} m and m/s")
            return None
        step = self._clock.take(stamp_ns)
        if not step.good:
            self.statistics.clock_jumps += step is Step.JUMP
            self._drop(self._clock.why(stamp_ns))
            return None
        if step is Step.ANEW:
            self._begin_clock()
        if self._planner_ns is None:
            self._planner_ns = stamp_ns
        period = self._account_for_time(stamp_ns)
        self._observe(stamp_ns, position, velocity)
        self.stamp_ns = stamp_ns
        self._command(stamp_ns, position, velocity, period)
        self.statistics.commands += 1
        x, y, z = self._thrust
        return (x, y, z)

    def _drop(self, why: str) -> None:
        self.statistics.rejected_odometry += 1
        self.dropped_because = why

    def _begin_clock(self) -> None:
        """Odometry's clock was set anew: nothing that was measured by the old one can be carried over."""
        self._burn(seconds_between(0, self.parameters.held_ns))
        self._covariance[:] = [0.0] * 6
        self.stamp_ns = self._planner_ns = None
        self.statistics.clock_resets += 1

    def odometry_lost(self) -> bool:
        """The watchdog found odometry too old: zero thrust until it comes back.

        Returns:
            True when that is news.
        """
        if self.mode not in (Mode.DEPLOYING, Mode.CLOSING):
            return False
        # The held thrust stays on the account: the next sample's stamp will tell how long it acted. In lock-step a
        # slow machine may trip this watchdog although no time has passed at all.
        self.mode = Mode.NO_ODOMETRY
        return True

    def _account_for_time(self, stamp_ns: int) -> float:
        """Book the fuel and the missed periods since the last sample; return the time step for the integral [s].

        The integral goes on for no longer than the watchdog's patience: over a long gap the error at its end says
        little of the error within.
        """
        p = self.parameters
        if self.stamp_ns is None:
            return p.period_ns * NANOSECOND_S
        gap = seconds_between(self.stamp_ns, stamp_ns)
        self._burn(min(gap, seconds_between(0, p.held_ns)))
        if self.mode.flying:
            self.statistics.deadline_misses += max(0, round(gap / p.control_period_s) - 1)
        return min(gap, p.watchdog_periods * p.control_period_s)

    def _burn(self, duration: float) -> None:
        p = self.parameters
        used = law.fuel_used(self._thrust, duration, self.unit.specific_impulse_s, p.standard_gravity_m_s2)
        self.statistics.fuel_kg += used
        # The interval being booked began at the last sample: before closing it counts for the trigger too.
        if not self.mission.closing or self.stamp_ns is None or self.stamp_ns < self.mission.closing_ns:
            self.statistics.fuel_at_trigger_kg = self.statistics.fuel_kg

    def _observe(self, stamp_ns: int, position: Sequence[float], velocity: Sequence[float]) -> None:
        """Take the sample into the estimate; the thrust on the account is what acted since the last one."""
        statistics, law_ = self.statistics, self._law
        if law_.estimate > 0.0:
            thrust, period = self._bridge(stamp_ns)
            if estimator.observe(law_, thrust, period, position, velocity, self._state, self._covariance):
                statistics.outliers += 1
            statistics.position_sigma_m = math.sqrt(self._covariance[0])
            statistics.velocity_sigma_m_s = math.sqrt(self._covariance[3])
        else:
            self._state[0:3], self._state[3:6] = position, velocity
            statistics.position_sigma_m = math.sqrt(law_.position_variance)
            statistics.velocity_sigma_m_s = math.sqrt(law_.velocity_variance)

    def _bridge(self, stamp_ns: int) -> tuple[Sequence[float], float]:
        """Carry the estimate over the periods that were missed, with the thrust that acted: held, then zeroed.

        Period by period, because the process noise is that of short ones.

        Returns:
            Thrust [N] and duration [s] of the last period, which ends with the sample.
        """
        p = self.parameters
        if self.stamp_ns is None:
            return self._thrust, p.period_ns * NANOSECOND_S
        gap_ns = stamp_ns - self.stamp_ns
        missed = max(0, gap_ns // p.period_ns - 1)
        for period in range(missed):
            acting = self._thrust if period * p.period_ns < p.held_ns else ZERO
            estimator.predict(self._law, acting, p.period_ns * NANOSECOND_S, self._state, self._covariance)
        acting = self._thrust if missed * p.period_ns < p.held_ns else ZERO
        return acting, (gap_ns - missed * p.period_ns) * NANOSECOND_S

    def _command(self, stamp_ns: int, position: Sequence[float], velocity: Sequence[float], period: float) -> None:
        mission, aim = self.mission, self.aiming_point
        flying = mission.phase in (Phase.DEPLOYING, Phase.CLOSING)
        if not flying or aim is None or stamp_ns < mission.launch_ns:
            self._stop(Mode.OFF if mission.phase.over or mission.closing else Mode.IDLE)
            return
        elapsed = seconds_between(mission.launch_ns, stamp_ns)
        if (mission.closing and stamp_ns >= mission.end_ns) or elapsed >= self.parameters.longest_flight_s:
            self._stop(Mode.OFF)
            return
        if self._start is None:
            self._start = [float(value) for value in position]
        closing_elapsed = -1.0
        if mission.closing and not mission.units_fly_on:
            closing_elapsed = seconds_between(mission.closing_ns, stamp_ns)
        if closing_elapsed >= 0.0 and (mission.docked(self.mu, stamp_ns) or not mission.closing_points):
            self._stop(Mode.OFF)
            return
        if self.statistics.fuel_kg >= self.unit.propellant_kg:
            self._stop(Mode.EMPTY)
            return
        if self._planner_lost(stamp_ns):
            self._stop(Mode.NO_PLANNER)
            return
        self.mode = Mode.CLOSING if closing_elapsed >= 0.0 else Mode.DEPLOYING
        points = mission.closing_points
        if self._close_before and stamp_ns < mission.points_ns:
            points = self._close_before  # news of the planner hold from the next tick on
        close = points[self.mu - 1] if points else aim
        if law.command(
            self._law, elapsed, closing_elapsed,
            mission.closing_duration_s if closing_elapsed >= 0.0 else 1.0, period, position, velocity,
            self._start, aim, close, self._state, self._integral, self._carry,
            self._thrust, self.desired, self._speed,
        ):  # fmt: skip
            self.statistics.saturated += 1
        error = law.distance(self.desired, self._state)
        self.statistics.tracking_error_m = error
        self.statistics.max_tracking_error_m = max(self.statistics.max_tracking_error_m, error)

    def _stop(self, mode: Mode) -> None:
        self._thrust[:] = ZERO
        self.mode = mode
