"""Kalman filter of one MU's motion: position and velocity from noisy odometry, with the commanded thrust as known input
and the thread's pull as a slowly varying disturbance.

Per axis x = (position, velocity, disturbance acceleration), x' = F x + G u with u = thrust / mass. The three axes have
the same noise, so they share one covariance matrix. Scalar arithmetic only: see :mod:`tethernet_control.law`.

``state`` holds nine numbers: position x y z [m], velocity x y z [m/s], disturbance x y z [m/s^2]. ``covariance`` holds
the six different entries of one axis' matrix: pp, pv, pd, vv, vd, dd; all zero means that nothing is known yet.
``p`` is :class:`tethernet_control.law_numbers.Law`.
"""

from __future__ import annotations

from tethernet_control.law_numbers import Law
from tethernet_control.vectors import Output, Vector

DISTURBANCE_SIGMA = 0.5
"""What the disturbance may be at first, per axis, 1 sigma [m/s^2]: at launch the threads are slack, in flight they pull
with a newton or so."""

SURPRISE = 4.0
"""Growth of the covariance with each sample that was turned away: one wild sample is an outlier, a few in a row are a
thread that has snapped taut and changed the velocity, and are believed."""

FORGOTTEN_M2 = 1e4
"""Variance of the position from which on nothing is known any more [m^2], 100 m: farther than any mission reaches. It
bounds the growth of the covariance: beyond 1e13 times the samples' variance rounding would eat its sign. A good sample
that is turned away again and again is believed after 14 of them, whatever came before: by then 4^14 times a settled
variance is beyond."""


def begin(p: Law, position: Vector, velocity: Vector, state: Output, covariance: Output) -> None:
    """Start from one sample; the disturbance is unknown."""
    for axis in range(3):
        state[axis] = position[axis]
        state[3 + axis] = velocity[axis]
        state[6 + axis] = 0.0
    covariance[0] = p.position_variance
    covariance[1] = 0.0
    covariance[2] = 0.0
    covariance[3] = p.velocity_variance
    covariance[4] = 0.0
    covariance[5] = DISTURBANCE_SIGMA * DISTURBANCE_SIGMA


def known(covariance: Vector) -> bool:
    """True while the covariance is positive definite and the position known to 100 m; NaN is neither."""
    pp, pv, pd = covariance[0], covariance[1], covariance[2]
    vv, vd, dd = covariance[3], covariance[4], covariance[5]
    if not 0.0 < pp <= FORGOTTEN_M2:
        return False
    # The Schur complement of pp, two by two: positive definite as well.
    vv, vd, dd = vv - pv * pv / pp, vd - pv * pd / pp, dd - pd * pd / pp
    return vv > 0.0 and vv * dd - vd * vd > 0.0


def predict(p: Law, thrust: Vector, period: float, state: Output, covariance: Output) -> None:
    """Carry the estimate over ``period`` [s] of constant ``thrust`` [N].

    Process noise: white impulses on the velocity (threads that snap taut) and a random walk of the disturbance.
    """
    t = period
    half = 0.5 * t * t
    for axis in range(3):
        acceleration = thrust[axis] / p.mass + state[6 + axis]
        state[axis] += t * state[3 + axis] + half * acceleration
        state[3 + axis] += t * acceleration
    pp, pv, pd = covariance[0], covariance[1], covariance[2]
    vv, vd, dd = covariance[3], covariance[4], covariance[5]
    # F P F' with F = [[1, t, t^2/2], [0, 1, t], [0, 0, 1]]: first F P, row by row, then times F'.
    row_pp, row_pv, row_pd = pp + t * pv + half * pd, pv + t * vv + half * vd, pd + t * vd + half * dd
    row_vv, row_vd = vv + t * vd, vd + t * dd
    impulses = p.velocity_noise * p.velocity_noise * t
    walk = p.disturbance_noise * p.disturbance_noise * t
    covariance[0] = row_pp + t * row_pv + half * row_pd + impulses * t * t / 3.0
    covariance[1] = row_pv + t * row_pd + 0.5 * impulses * t
    covariance[2] = row_pd
    covariance[3] = row_vv + t * row_vd + impulses
    covariance[4] = row_vd
    covariance[5] = dd + walk


def update(p: Law, position: Vector, velocity: Vector, state: Output, covariance: Output) -> float:
    """Correct the estimate by one sample, unless it lies so far off that it is an outlier.

    Returns:
        The normalised innovation squared: chi-square with 6 degrees of freedom for a consistent filter. Beyond
        ``p.innovation_gate`` nothing was corrected.
    """
    pp, pv, pd = covariance[0], covariance[1], covariance[2]
    vv, vd, dd = covariance[3], covariance[4], covariance[5]
    spp, svv = pp + p.position_variance, vv + p.velocity_variance
    determinant = spp * svv - pv * pv
    ipp, ipv, ivv = svv / determinant, -pv / determinant, spp / determinant
    squared = 0.0
    for axis in range(3):
        off_p = position[axis] - state[axis]
        off_v = velocity[axis] - state[3 + axis]
        squared += off_p * off_p * ipp + 2.0 * off_p * off_v * ipv + off_v * off_v * ivv
    if not squared <= p.innovation_gate:  # also NaN, where the square overflows
        for entry in range(6):
            covariance[entry] *= SURPRISE
        return squared
    kpp, kpv = pp * ipp + pv * ipv, pp * ipv + pv * ivv
    kvp, kvv = pv * ipp + vv * ipv, pv * ipv + vv * ivv
    kdp, kdv = pd * ipp + vd * ipv, pd * ipv + vd * ivv
    for axis in range(3):
        off_p = position[axis] - state[axis]
        off_v = velocity[axis] - state[3 + axis]
        state[axis] += kpp * off_p + kpv * off_v
        state[3 + axis] += kvp * off_p + kvv * off_v
        state[6 + axis] += kdp * off_p + kdv * off_v
    covariance[0] = pp - (kpp * pp + kpv * pv)
    covariance[1] = pv - (kpp * pv + kpv * vv)
    covariance[2] = pd - (kpp * pd + kpv * vd)
    covariance[3] = vv - (kvp * pv + kvv * vv)
    covariance[4] = vd - (kvp * pd + kvv * vd)
    covariance[5] = dd - (kdp * pd + kdv * vd)
    return squared


def observe(
    p: Law,
    thrust: Vector,
    period: float,
    position: Vector,
    velocity: Vector,
    state: Output,
    covariance: Output,
) -> bool:
    """One sample: predict by the thrust that acted since the last one, then correct; begin where nothing is known, and
    begin anew where nothing is known any more: after rubbish for longer than the covariance may grow, or where rounding
    has taken its sign. The estimate stays finite and its covariance positive definite for all finite samples.

    Args:
        p: the law's numbers.
        thrust: that acted since the last sample [N].
        period: since the last sample [s].
        position: measured [m].
        velocity: measured [m/s].
        state: nine numbers; updated.
        covariance: six numbers; updated.

    Returns:
        True when the sample was an outlier and only the prediction stands.
    """
    if covariance[0] <= 0.0:
        begin(p, position, velocity, state, covariance)
        return False
    predict(p, thrust, period, state, covariance)
    if not known(covariance):
        begin(p, position, velocity, state, covariance)
        return False
    if not update(p, position, velocity, state, covariance) <= p.innovation_gate:
        return True
    if not known(covariance):
        begin(p, position, velocity, state, covariance)
    return False
