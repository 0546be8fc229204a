"""Rigid bodies with an axis of symmetry (body z): kick by force and torque, exact torque-free drift."""

from __future__ import annotations

import math

from tethernet_core.rotation import entries, product
from tethernet_sim.kernels.options import inlined

_entries = inlined(entries)
_product = inlined(product)


@inlined
def rotation_matrix(body, matrix):
    """Write the body-to-launch rotation of ``body`` (13,) to ``matrix`` (3, 3)."""
    m00, m01, m02, m10, m11, m12, m20, m21, m22 = _entries(body[6], body[7], body[8], body[9])
    matrix[0, 0], matrix[0, 1], matrix[0, 2] = m00, m01, m02
    matrix[1, 0], matrix[1, 1], matrix[1, 2] = m10, m11, m12
    matrix[2, 0], matrix[2, 1], matrix[2, 2] = m20, m21, m22


@inlined
def angular_rate(body, matrix, across, along, rate):
    """Write the angular rate in the launch frame [rad/s] to ``rate``; inertia across and along the axis [kg m^2]."""
    axial = matrix[0, 2] * body[10] + matrix[1, 2] * body[11] + matrix[2, 2] * body[12]
    spin = axial / along - axial / across
    for axis in range(3):
        rate[axis] = body[10 + axis] / across + spin * matrix[axis, 2]


@inlined
def kick(body, mass, force, torque, time_step):
    """Change velocity and angular momentum by one step under ``force`` [N] and ``torque`` [N m] (about the centre of
    mass).
    """
    for axis in range(3):
        body[3 + axis] += time_step / mass * force[axis]
        body[10 + axis] += time_step * torque[axis]


@inlined
def drift_body(body, matrix, across, along, duration):
    """Move a body freely for ``duration`` [s]: exact for a body of revolution, for any duration.

    The angular rate is the constant vector L / I_across plus a spin about the body's own axis, so the attitude is
    exp(L t / I_across) q exp(spin t e_z). ``matrix`` is brought up to date.
    """
    for axis in range(3):
        body[axis] += duration * body[3 + axis]
    momentum = math.sqrt(body[10] * body[10] + body[11] * body[11] + body[12] * body[12])
    if momentum > 0.0:
        axial = matrix[0, 2] * body[10] + matrix[1, 2] * body[11] + matrix[2, 2] * body[12]
        half_spin = 0.5 * duration * (axial / along - axial / across)
        half_turn = 0.5 * duration * momentum / across
        scale = math.sin(half_turn) / momentum
        turn = body[10] * scale, body[11] * scale, body[12] * scale, math.cos(half_turn)
        spin = 0.0, 0.0, math.sin(half_spin), math.cos(half_spin)
        x, y, z, w = _product(turn, _product((body[6], body[7], body[8], body[9]), spin))
        norm = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
        body[6], body[7], body[8], body[9] = x * norm, y * norm, z * norm, w * norm
        rotation_matrix(body, matrix)


@inlined
def small_rotation_step(body, matrix, across, along, duration):
    """:func:`drift_body` for one step of the integration: the same motion without sines, roots and divisions.

    Sine and cosine are series, exact to the last digit or so for turns below 2e-3 rad a step, that is below 16 rad/s.
    """
    for axis in range(3):
        body[axis] += duration * body[3 + axis]
    half = 0.5 * duration / across
    px, py, pz = half * body[10], half * body[11], half * body[12]
    squared = px * px + py * py + pz * pz
    if squared == 0.0:
        return
    axial = matrix[0, 2] * body[10] + matrix[1, 2] * body[11] + matrix[2, 2] * body[12]
    spin = 0.5 * duration * (1.0 / along - 1.0 / across) * axial
    sine = 1.0 - squared * (1.0 / 6.0)
    turn = px * sine, py * sine, pz * sine, 1.0 - 0.5 * squared + squared * squared * (1.0 / 24.0)
    own = 0.0, 0.0, spin * (1.0 - spin * spin * (1.0 / 6.0)), 1.0 - 0.5 * spin * spin + spin**4 * (1.0 / 24.0)
    x, y, z, w = _product(turn, _product((body[6], body[7], body[8], body[9]), own))
    norm = 1.5 - 0.5 * (x * x + y * y + z * z + w * w)  # one step of Newton's: it never strays far from 1
    body[6], body[7], body[8], body[9] = x * norm, y * norm, z * norm, w * norm
    rotation_matrix(body, matrix)
