"""One MU's controller without ROS: mission and odometry in, thrust and account out."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from . import estimator, law
from .mission import Mission, Phase, seconds_between
from .settings import ControlParameters

ZERO = (0.0, 0.0, 0.0)


class Mode(enum.IntEnum):
    """What the controller does; the numbers are those of tethernet_msgs/MuStatus."""

    IDLE = 0
    DEPLOYING = 1
    CLOSING = 2
    OFF = 3
    NO_ODOMETRY = 4


@dataclass
class Account:
    """What a controller reports of itself; the fields of tethernet_msgs/MuStatus."""

    fuel_kg: float = 0.0
    fuel_at_trigger_kg: float = 0.0
    tracking_error_m: float = 0.0
    max_tracking_error_m: float = 0.0
    commands: int = 0
    saturated: int = 0
    rejected_odometry: int = 0
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

    def __init__(self, mu: int, parameters: ControlParameters):
        """Args:
        mu: number of the MU, 1..8.
        parameters: gains, limits, periods.
        """
        self.mu = mu
        self.parameters = parameters
        self.mission = Mission(mu_count=8)
        self.mode = Mode.IDLE
        self.account = Account()
        self.aiming_point: tuple[float, float, float] | None = None
        self.aiming_source = ""
        self.desired = [math.nan] * 3
        self.stamp_ns: int | None = None
        self._start: list[float] | None = None
        self._close_before: tuple = ()
        self._law = parameters.law()
        self._state = [0.0] * 9
        self._covariance = [0.0] * 6
        self._integral = [0.0, 0.0, 0.0]
        self._carry = [0.0, 0.0, 0.0]
        self._speed = [0.0, 0.0, 0.0]
        self._thrust = [0.0, 0.0, 0.0]

    def take_mission(self, mission: Mission) -> bool:
        """Take over a newer state of the mission.

        Returns:
            True when it was newer.
        """
        if mission.sequence <= self.mission.sequence and self.mission.sequence:
            return False
        if self.mission.closing_points:
            self._close_before = self.mission.closing_points
        self.mission = mission
        if mission.phase.over:
            self.mode = Mode.OFF
        return True

    def aim(self, point, source: str) -> None:
        """Set the aiming point [m] and where it comes from."""
        self.aiming_point = tuple(float(value) for value in point)
        self.aiming_source = source

    def on_odometry(self, stamp_ns: int, position, velocity) -> tuple[float, float, float] | None:
        """Answer one odometry sample.

        Args:
            stamp_ns: its time [ns].
            position: measured, x y z [m], frame launch.
            velocity: measured, x y z [m/s], frame launch.

        Returns:
            The thrust [N] until the next sample, or None when the sample was dropped (not finite, or not newer than
            the last one).
        """
        total = 0.0
        for value in (*position, *velocity):
            total += value
        if not math.isfinite(total) or (self.stamp_ns is not None and stamp_ns <= self.stamp_ns):
            self.account.rejected_odometry += 1
            return None
        period = self._account_for_time(stamp_ns)
        self.stamp_ns = stamp_ns
        self._observe(period, position, velocity)
        self._command(stamp_ns, position, velocity, period)
        self.account.commands += 1
        return tuple(self._thrust)

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
        """Book the fuel and the missed periods since the last sample; return the time step for the integral [s]."""
        p = self.parameters
        if self.stamp_ns is None:
            return p.period_ns * 1e-9
        gap = seconds_between(self.stamp_ns, stamp_ns)
        period = min(gap, p.watchdog_periods * p.control_period_s)
        self._burn(period)
        if self.mode in (Mode.DEPLOYING, Mode.CLOSING, Mode.NO_ODOMETRY):
            self.account.deadline_misses += max(0, round(gap / p.control_period_s) - 1)
        return period

    def _burn(self, duration: float) -> None:
        p = self.parameters
        used = law.fuel_used(self._thrust, duration, p.specific_impulse_s, p.standard_gravity_m_s2)
        self.account.fuel_kg += used
        # The interval being booked began at the last sample: before closing it counts for the trigger too.
        if not self.mission.closing or self.stamp_ns is None or self.stamp_ns < self.mission.closing_ns:
            self.account.fuel_at_trigger_kg = self.account.fuel_kg

    def _observe(self, period: float, position, velocity) -> None:
        """Take the sample into the estimate; the thrust on the account is what acted since the last one."""
        account, law_ = self.account, self._law
        if law_.estimate > 0.0:
            if estimator.observe(law_, self._thrust, period, position, velocity, self._state, self._covariance):
                account.outliers += 1
            account.position_sigma_m = math.sqrt(self._covariance[0])
            account.velocity_sigma_m_s = math.sqrt(self._covariance[3])
        else:
            self._state[0:3], self._state[3:6] = position, velocity
            account.position_sigma_m = math.sqrt(law_.position_variance)
            account.velocity_sigma_m_s = math.sqrt(law_.velocity_variance)

    def _command(self, stamp_ns: int, position, velocity, period: float) -> None:
        mission = self.mission
        flying = mission.phase in (Phase.DEPLOYING, Phase.CLOSING) and self.aiming_point is not None
        if not flying or stamp_ns < mission.launch_ns or (mission.closing and stamp_ns >= mission.end_ns):
            self._thrust[:] = ZERO
            self.mode = Mode.OFF if mission.phase.over or mission.closing else Mode.IDLE
            return
        if self._start is None:
            self._start = [float(value) for value in position]
        closing_elapsed = seconds_between(mission.closing_ns, stamp_ns) if mission.closing else -1.0
        if closing_elapsed >= 0.0 and (mission.docked(self.mu, stamp_ns) or not mission.closing_points):
            self._thrust[:] = ZERO
            self.mode = Mode.OFF
            return
        self.mode = Mode.CLOSING if closing_elapsed >= 0.0 else Mode.DEPLOYING
        points = mission.closing_points
        if self._close_before and stamp_ns < mission.points_ns:
            points = self._close_before  # news of the planner hold from the next tick on
        close = points[self.mu - 1] if points else self.aiming_point
        if law.command(
            self._law, seconds_between(mission.launch_ns, stamp_ns), closing_elapsed,
            mission.closing_duration_s if mission.closing else 1.0, period, position, velocity,
            self._start, self.aiming_point, close, self._state, self._integral, self._carry,
            self._thrust, self.desired, self._speed,
        ):  # fmt: skip
            self.account.saturated += 1
        error = law.distance(self.desired, self._state)
        self.account.tracking_error_m = error
        self.account.max_tracking_error_m = max(self.account.max_tracking_error_m, error)
