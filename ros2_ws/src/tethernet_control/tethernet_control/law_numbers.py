"""The numbers that control law and estimator work with."""

from __future__ import annotations

from typing import NamedTuple

from tethernet_core.settings import ControlParameters
from tethernet_core.system import Unit


class Law(NamedTuple):
    """The numbers of the law, as plain floats: compiled code takes them as they are. Meaning:
    settings.ControlParameters.
    """

    estimate: float  # 1: Kalman filter, 0: raw samples
    position_variance: float  # [m^2]
    velocity_variance: float  # [m^2/s^2]
    velocity_noise: float  # [m/s/sqrt(s)]
    disturbance_noise: float  # [m/s^2/sqrt(s)]
    innovation_gate: float  # [-]
    mass: float  # [kg]
    deployment_time: float  # [s]
    ramp_time: float  # [s]
    follow_through: float  # [m]
    kp: float  # [N/m]
    ki: float  # [N/(m s)]
    kd: float  # [N s/m]
    feed_forward: float  # 0 or 1
    anti_windup: float  # 0 or 1
    dead_band: float  # [N]
    minimum_impulse: float  # [N s]
    limit: float  # [N]
    intercept: float  # 1: closing by intercept guidance, 0: by tracking a line
    closing_coast: float  # [s]
    closing_turn: float  # [s]
    closing_dead_band: float  # [m/s]
    closing_response: float  # [s]
    shortest_to_go: float  # [s]
    hold_kp: float  # [N/m]
    hold_kd: float  # [N s/m]


def law_numbers(control: ControlParameters, unit: Unit) -> Law:
    """The numbers that the control law and the estimator work with.

    Args:
        control: gains, limits of the law, noise.
        unit: gives mass and thrust limit.
    """
    return Law(
        estimate=float(control.estimator == "kalman"),
        # A filter that is told of no noise at all would divide by zero.
        position_variance=max(control.position_sigma_m, 1e-6) ** 2,
        velocity_variance=max(control.velocity_sigma_m_s, 1e-6) ** 2,
        velocity_noise=control.velocity_noise,
        disturbance_noise=control.disturbance_noise,
        innovation_gate=control.innovation_gate,
        mass=unit.mass_kg,
        deployment_time=control.deployment_time_s,
        ramp_time=control.ramp_time_s,
        follow_through=control.follow_through_m,
        kp=control.kp,
        ki=control.ki,
        kd=control.kd,
        feed_forward=float(control.feed_forward),
        anti_windup=float(control.anti_windup),
        dead_band=control.dead_band_n,
        minimum_impulse=control.minimum_impulse_n_s,
        limit=unit.thrust_limit_n,
        intercept=float(control.closing_law == "intercept"),
        closing_coast=control.closing_coast_s,
        closing_turn=control.closing_turn_s,
        closing_dead_band=control.closing_dead_band_m_s,
        closing_response=control.closing_response_s,
        shortest_to_go=control.closing_shortest_s,
        hold_kp=control.closing_hold_kp,
        hold_kd=control.closing_hold_kd,
    )
