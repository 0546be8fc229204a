"""The controllers of a whole batch: tethernet_control's law, compiled."""

from __future__ import annotations

from tethernet_control import law

from .options import strict

_desired_position = strict(law.desired_position)
_pid_thrust = strict(law.pid_thrust)
_fuel_used = strict(law.fuel_used)
_distance = strict(law.distance)


@strict
def book_fuel(chosen, thrust, period, specific_impulse, gravity, fuel):
    """Add what one period of constant thrust burnt to ``fuel`` (B, M) [kg]."""
    for b in chosen:
        for m in range(thrust.shape[1]):
            fuel[b, m] += _fuel_used(thrust[b, m], period, specific_impulse, gravity)


@strict
def command(
    chosen, position, velocity, elapsed, closing_elapsed, off, deployment_time, closing_duration, period,
    kp, ki, kd, limit, start, aim, close, integral, thrust, largest_error,
):  # fmt: skip
    """Answer one control tick of every chosen scenario.

    Args:
        chosen: indices of scenarios.
        position, velocity: measured, (B, M, 3) [m], [m/s].
        elapsed: time since launch [s].
        closing_elapsed: time since closing began [s], negative before, (B,).
        off: thrusters off, (B,).
        deployment_time, closing_duration, period: [s].
        kp, ki, kd, limit: gains and thrust limit.
        start, aim, close: of the trajectory, (B, M, 3) [m].
        integral: of the error, (B, M, 3) [m s]; updated.
        thrust: output, (B, M, 3) [N].
        largest_error: largest tracking error so far, (B,) [m]; updated.
    """
    desired = [0.0, 0.0, 0.0]
    for b in chosen:
        for m in range(thrust.shape[1]):
            if off[b]:
                thrust[b, m, :] = 0.0
                continue
            _desired_position(
                elapsed,
                deployment_time,
                closing_elapsed[b],
                closing_duration,
                start[b, m],
                aim[b, m],
                close[b, m],
                desired,
            )
            _pid_thrust(
                position[b, m], velocity[b, m], desired, integral[b, m], period, kp, ki, kd, limit, thrust[b, m]
            )
            largest_error[b] = max(largest_error[b], _distance(desired, position[b, m]))
