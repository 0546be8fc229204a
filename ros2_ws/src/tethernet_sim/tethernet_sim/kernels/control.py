"""The controllers of a whole batch: tethernet_control's law and estimator, compiled."""

from __future__ import annotations

from numba.extending import register_jitable

from tethernet_control import estimator, law
from tethernet_sim.kernels.options import ieee

for _function in law.CALLED:
    register_jitable(_function)

_observe = ieee(estimator.observe)
_command = ieee(law.command)
_fuel_used = ieee(law.fuel_used)
_distance = ieee(law.distance)
_of_unit = ieee(law.of_unit)


@ieee
def book_fuel(chosen, thrust, period, specific_impulse, gravity, fuel):
    """Add what one period of constant thrust burnt to ``fuel`` (B, M) [kg]; ``specific_impulse`` (M,) [s]."""
    for b in chosen:
        for m in range(thrust.shape[1]):
            fuel[b, m] += _fuel_used(thrust[b, m], period, specific_impulse[m], gravity)


@ieee
def command(
    law, mass, limit, chosen, position, velocity, elapsed, closing_elapsed, closing_duration, period, off,
    start, aim, close, state, covariance, integral, carry, thrust, largest_error,
):  # fmt: skip
    """Answer one control tick of every chosen scenario.

    Args:
        law: tethernet_control.law_numbers.Law; mass and limit of each unit replace those that it holds.
        mass: of each unit, (M,) [kg].
        limit: of each unit's thrust along each axis, (M,) [N].
        chosen: indices of scenarios.
        position: measured, (B, M, 3) [m].
        velocity: measured, (B, M, 3) [m/s].
        elapsed: time since launch [s].
        closing_elapsed: time since closing began [s], negative before, (B,).
        closing_duration: until the MUs shall meet [s], (B,).
        period: of control [s].
        off: thrusters off, (B, M).
        start: position at launch, (B, M, 3) [m].
        aim: aiming points, (B, M, 3) [m].
        close: closing points, (B, M, 3) [m].
        state: the estimators', (B, M, 9); updated.
        covariance: the estimators', (B, M, 6); updated.
        integral: of the error, (B, M, 3) [m s]; updated.
        carry: impulse not yet fired, (B, M, 3) [N s]; updated.
        thrust: of the last tick on entry, of this one on return, (B, M, 3) [N].
        largest_error: largest tracking error so far, (B,) [m]; updated.
    """
    desired, speed = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    for b in chosen:
        for m in range(thrust.shape[1]):
            p = _of_unit(law, mass[m], limit[m])
            if p.estimate > 0.0:
                _observe(p, thrust[b, m], period, position[b, m], velocity[b, m], state[b, m], covariance[b, m])
            else:
                state[b, m, 0:3] = position[b, m]
                state[b, m, 3:6] = velocity[b, m]
            if off[b, m]:
                thrust[b, m, :] = 0.0
                continue
            _command(
                p, elapsed, closing_elapsed[b], closing_duration[b], period, position[b, m], velocity[b, m],
                start[b, m], aim[b, m], close[b, m], state[b, m], integral[b, m], carry[b, m], thrust[b, m],
                desired, speed,
            )  # fmt: skip
            largest_error[b] = max(largest_error[b], _distance(desired, state[b, m]))
