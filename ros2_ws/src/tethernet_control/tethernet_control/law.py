"""The control law of one MU: trajectory, PID, fuel. Scalar arithmetic only, on purpose.

The functions run as plain Python in a controller node and are compiled (without fast-math) by the batch engine; both
give the same bits, because only + - * /, square roots and comparisons of doubles occur, in the same order. Arguments
named as vectors are sequences of three floats; outputs are written in place. Nothing here may call another function of
the project, so that each can be compiled by itself.
"""

from __future__ import annotations

import math


def desired_position(elapsed, deployment_time, closing_elapsed, closing_duration, start, aim, close, desired):
    """Where an MU shall be, written to ``desired`` [m].

    Deployment is the straight line of the paper's Eq. 1, held at its end [A: the paper is silent after t_final].
    Closing is a straight line from where deployment's line stood when closing began, so that the reference never jumps.

    Args:
        elapsed: time since launch [s].
        deployment_time: t_final [s].
        closing_elapsed: time since closing began [s], negative before.
        closing_duration: time for the closing line [s].
        start: position at launch [m].
        aim: aiming point [m].
        close: closing point [m].
        desired: output [m].
    """
    deployed = elapsed if closing_elapsed < 0.0 else elapsed - closing_elapsed
    fraction = deployed / deployment_time
    fraction = min(max(fraction, 0.0), 1.0)
    closed = 0.0 if closing_elapsed < 0.0 else closing_elapsed / closing_duration
    closed = min(closed, 1.0)
    for axis in range(3):
        deployment = start[axis] + fraction * (aim[axis] - start[axis])
        desired[axis] = deployment + closed * (close[axis] - deployment)


def pid_thrust(position, velocity, desired, integral, period, kp, ki, kd, limit, thrust):
    """The paper's PID (Eq. 2), limited per axis; written to ``thrust`` [N].

    F = Kp e - Kd v + Ki integral(e), e = desired - position; the derivative acts on the velocity itself. No
    anti-windup.

    Args:
        position: measured [m].
        velocity: measured [m/s].
        desired: reference [m].
        integral: integral of the error [m s], updated in place before it is used.
        period: time since the last command [s].
        kp: gain [N/m].
        ki: gain [N/(m s)].
        kd: gain [N s/m].
        limit: largest thrust per axis [N].
        thrust: output [N].

    Returns:
        True when the limit was reached on any axis.
    """
    saturated = False
    for axis in range(3):
        error = desired[axis] - position[axis]
        integral[axis] += error * period
        force = kp * error - kd * velocity[axis] + ki * integral[axis]
        if force > limit:
            force = limit
            saturated = True
        elif force < -limit:
            force = -limit
            saturated = True
        thrust[axis] = force
    return saturated


def fuel_used(thrust, duration, specific_impulse, gravity):
    """Fuel for a constant thrust [kg] (paper, Eq. 3).

    Args:
        thrust: after the limit [N].
        duration: how long it acts [s].
        specific_impulse: Isp [s].
        gravity: g0 [m/s^2].
    """
    squared = thrust[0] * thrust[0] + thrust[1] * thrust[1] + thrust[2] * thrust[2]
    return math.sqrt(squared) * duration / (gravity * specific_impulse)


def distance(first, second):
    """Distance of two points [m]."""
    x = first[0] - second[0]
    y = first[1] - second[1]
    z = first[2] - second[2]
    return math.sqrt(x * x + y * y + z * z)
