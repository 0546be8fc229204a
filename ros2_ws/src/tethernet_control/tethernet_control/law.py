"""The control law of one MU: reference, PID, closing guidance, thrusters, fuel. Scalar arithmetic only, on purpose.

The functions run as plain Python in a controller node and are compiled (without fast-math) by the batch engine; both
give the same bits, because only + - * /, square roots and comparisons of doubles occur, in the same order. Arguments
named as vectors are sequences of three floats; outputs are written in place. ``p`` is always :class:`.law_numbers.Law`.
"""

from __future__ import annotations

import math

from tethernet_control import estimator
from tethernet_control.law_numbers import Law
from tethernet_control.vectors import Output, Vector


def reference(
    p: Law,
    elapsed: float,
    closing_elapsed: float,
    closing_duration: float,
    start: Vector,
    aim: Vector,
    close: Vector,
    desired: Output,
    speed: Output,
    push: Output,
) -> None:
    """Where an MU shall be and how fast, written to ``desired`` [m] and ``speed`` [m/s]; ``push`` [N] gets it up to
    speed.

    Deployment is the straight line of the paper's Eq. 1. With a ramp time the MU gets up to speed over that time and
    not at once, and still arrives at t_final. The paper is silent after t_final: the line goes on at the same speed for
    the distance of the follow-through and is held there, because a net that is late by a few ticks must not make the
    MUs spend fuel on a stop that the closing would undo. Closing is a straight line from where deployment's line stood
    when closing began, so that the reference never jumps.

    Args:
        p: the law's numbers.
        elapsed: time since launch [s].
        closing_elapsed: time since closing began [s], negative before.
        closing_duration: time for the closing line [s].
        start: position at launch [m].
        aim: aiming point [m].
        close: closing point [m].
        desired: output [m].
        speed: output [m/s].
        push: output, the thrust that a free MU needs to follow [N].
    """
    deployed = elapsed if closing_elapsed < 0.0 else elapsed - closing_elapsed
    deployed = max(deployed, 0.0)
    cruise = 1.0 / (p.deployment_time - 0.5 * p.ramp_time)
    if deployed < p.ramp_time:
        fraction = 0.5 * cruise * deployed * deployed / p.ramp_time
        rate = cruise * deployed / p.ramp_time
        gain = p.mass * cruise / p.ramp_time
    else:
        fraction = cruise * (deployed - 0.5 * p.ramp_time)
        rate = cruise
        gain = 0.0
    # The square root is only for who is late: most ticks come before t_final.
    if fraction >= 1.0:
        length = distance(start, aim)
        furthest = 1.0 + p.follow_through / length if length > 0.0 else 1.0
        if fraction >= furthest:
            fraction = furthest
            rate = 0.0
    closed = 0.0
    closing_rate = 0.0
    if closing_elapsed >= 0.0:
        rate = 0.0
        gain = 0.0
        closed = closing_elapsed / closing_duration
        closing_rate = 1.0 / closing_duration
        if closed >= 1.0:
            closed = 1.0
            closing_rate = 0.0
    for axis in range(3):
        deployment = start[axis] + fraction * (aim[axis] - start[axis])
        desired[axis] = deployment + closed * (close[axis] - deployment)
        speed[axis] = rate * (aim[axis] - start[axis]) + closing_rate * (close[axis] - deployment)
        push[axis] = gain * (aim[axis] - start[axis])


def pid_thrust(
    p: Law,
    position: Vector,
    velocity: Vector,
    desired: Vector,
    speed: Vector,
    integral: Output,
    period: float,
    thrust: Output,
) -> None:
    """The paper's PID (Eq. 2), before the limit; written to ``thrust`` [N].

    F = Kp e - Kd v + Ki integral(e), e = desired - position; the derivative acts on the velocity itself. With feed
    forward it acts on the velocity's error, F = Kp e + Kd (v_d - v) + Ki integral(e) + m dv_d/dt, so that the integral
    need not wind up to Kd v_d / Ki before the MU moves as fast as its reference. With anti-windup the integral of an
    axis stands
    still while that axis is beyond the limit. A wanted force within the dead band is none, and winds nothing up either.

    Args:
        p: the law's numbers.
        position: [m].
        velocity: [m/s].
        desired: reference [m].
        speed: velocity of the reference [m/s].
        integral: of the error [m s], updated in place before it is used.
        period: time since the last command [s].
        thrust: m dv_d/dt of the reference on entry, output [N].
    """
    for axis in range(3):
        error = desired[axis] - position[axis]
        before = integral[axis]
        integral[axis] = before + error * period
        force = p.kp * error - p.kd * (velocity[axis] - p.feed_forward * speed[axis]) + p.ki * integral[axis]
        force += p.feed_forward * thrust[axis]
        if p.anti_windup > 0.0 and (force > p.limit or force < -p.limit):
            integral[axis] = before
        elif abs(force) < p.dead_band:
            integral[axis] = before
            force = 0.0
        thrust[axis] = force


def intercept_thrust(
    p: Law,
    position: Vector,
    velocity: Vector,
    target: Vector,
    time_to_go: float,
    thrust: Output,
) -> None:
    """Closing guidance: bring the MU to ``target`` in ``time_to_go`` along a free flight; written to ``thrust`` [N].

    The velocity that would carry the MU there without any further thrust is compared with the one it has; what is
    missing is gained over the response time, and nothing is done while less is missing than the dead band: neighbours
    arrive together, and thrust is spent on the difference that matters, not on following a line.

    Args:
        p: the law's numbers.
        position: [m].
        velocity: [m/s].
        target: closing point [m].
        time_to_go: until the MUs shall meet [s]; below the shortest it is held there, or the law would chase noise.
        thrust: output [N].
    """
    time_to_go = max(time_to_go, p.shortest_to_go)
    squared = 0.0
    for axis in range(3):
        missing = (target[axis] - position[axis]) / time_to_go - velocity[axis]
        thrust[axis] = missing
        squared += missing * missing
    gain = p.mass / p.closing_response if math.sqrt(squared) > p.closing_dead_band else 0.0
    for axis in range(3):
        thrust[axis] *= gain


def hold_thrust(p: Law, position: Vector, velocity: Vector, target: Vector, thrust: Output) -> None:
    """Closing, when the MUs should have met: a spring and a damper hold the MU at ``target`` against the net's pull;
    written to ``thrust`` [N].
    """
    for axis in range(3):
        thrust[axis] = p.hold_kp * (target[axis] - position[axis]) - p.hold_kd * velocity[axis]


def apply_thruster_limits(p: Law, period: float, carry: Output, thrust: Output) -> bool:
    """What the thrusters do of a wanted thrust: minimum impulse bit, limit. ``thrust`` is changed in place.

    Args:
        p: the law's numbers.
        period: for which the command will be held [s].
        carry: impulse too small to be fired so far [N s], updated in place.
        thrust: wanted, then fired [N].

    Returns:
        True when the limit was reached on any axis.
    """
    saturated = False
    for axis in range(3):
        force = thrust[axis]
        if p.minimum_impulse > 0.0:
            impulse = carry[axis] + force * period
            if abs(impulse) < p.minimum_impulse:
                carry[axis] = impulse
                force = 0.0
            else:
                carry[axis] = 0.0
                force = impulse / period
        if force > p.limit:
            force = p.limit
            saturated = True
        elif force < -p.limit:
            force = -p.limit
            saturated = True
        thrust[axis] = force
    return saturated


def command(
    p: Law,
    elapsed: float,
    closing_elapsed: float,
    closing_duration: float,
    period: float,
    position: Vector,
    velocity: Vector,
    start: Vector,
    aim: Vector,
    close: Vector,
    state: Vector,
    integral: Output,
    carry: Output,
    thrust: Output,
    desired: Output,
    speed: Output,
) -> bool:
    """Command one MU in flight, from where it is thought to be; see :func:`estimator.observe` for that.

    Args:
        p: the law's numbers.
        elapsed: time since launch [s].
        closing_elapsed: time since closing began [s], negative before.
        closing_duration: until the MUs shall meet [s].
        period: time since the last command [s].
        position: measured [m]; used where nothing is estimated.
        velocity: measured [m/s]; likewise.
        start: position at launch [m].
        aim: aiming point [m].
        close: closing point [m].
        state: the estimator's: position [m], velocity [m/s], disturbance [m/s^2], nine numbers.
        integral: of the error [m s]; updated.
        carry: impulse not yet fired [N s]; updated.
        thrust: output [N].
        desired: output, reference [m].
        speed: output, velocity of the reference [m/s].

    Returns:
        True when the limit was reached on any axis.
    """
    at, moving = position, velocity
    if p.estimate > 0.0:
        at, moving = state[0:3], state[3:6]
    reference(p, elapsed, closing_elapsed, closing_duration, start, aim, close, desired, speed, thrust)
    if closing_elapsed < 0.0 or p.intercept == 0.0:
        pid_thrust(p, at, moving, desired, speed, integral, period, thrust)
    elif closing_elapsed < p.closing_coast or elapsed < p.deployment_time + p.closing_turn:
        thrust[0] = thrust[1] = thrust[2] = 0.0
    elif closing_elapsed > closing_duration:
        hold_thrust(p, at, moving, close, thrust)
    else:
        intercept_thrust(p, at, moving, close, closing_duration - closing_elapsed, thrust)
    return apply_thruster_limits(p, period, carry, thrust)


def fuel_used(thrust: Vector, duration: float, specific_impulse: float, gravity: float) -> float:
    """Fuel for a constant thrust [kg] (paper, Eq. 3).

    Args:
        thrust: after the limit [N].
        duration: how long it acts [s].
        specific_impulse: Isp [s].
        gravity: g0 [m/s^2].
    """
    squared = thrust[0] * thrust[0] + thrust[1] * thrust[1] + thrust[2] * thrust[2]
    return math.sqrt(squared) * duration / (gravity * specific_impulse)


def distance(first: Vector, second: Vector) -> float:
    """Distance of two points [m]."""
    x = first[0] - second[0]
    y = first[1] - second[1]
    z = first[2] - second[2]
    return math.sqrt(x * x + y * y + z * z)


def of_unit(p: Law, mass: float, limit: float) -> Law:
    """The same law for a unit of another mass [kg] and thrust limit [N]."""
    return Law(
        p.estimate, p.position_variance, p.velocity_variance, p.velocity_noise, p.disturbance_noise, p.innovation_gate,
        mass, p.deployment_time, p.ramp_time, p.follow_through, p.kp, p.ki, p.kd, p.feed_forward, p.anti_windup,
        p.dead_band, p.minimum_impulse, limit, p.intercept, p.closing_coast, p.closing_turn,
        p.closing_dead_band, p.closing_response, p.shortest_to_go, p.hold_kp, p.hold_kd,
    )  # fmt: skip


CALLED = (
    reference, pid_thrust, intercept_thrust, hold_thrust, apply_thruster_limits, fuel_used, distance, estimator.predict,
    estimator.update, estimator.begin, estimator.known, of_unit,
)  # fmt: skip
"""Functions that others here call: what compiles one of those must know these too."""
