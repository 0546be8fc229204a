"""Debris of any shape and any inertia: a table of primitive shapes, rotation along the principal axes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from tethernet_core import free_rotation, rotation
from tethernet_sim.kernels import rigid_body
from tethernet_sim.kernels.options import INLINED, inlined
from tethernet_sim.kernels.shape_formulae import surface_of_kind

for _function in (rotation.turned, rotation.product, free_rotation.turn_about, free_rotation.turn_about_principal):
    register_jitable(**INLINED)(_function)
_symmetric_step = inlined(free_rotation.symmetric_step)


class GeneralBody(NamedTuple):
    """A union of P primitive shapes. Everything in the body frame, from the centre of mass."""

    mass: float  # [kg]
    reach: float  # farthest point from the centre of mass [m]
    rates: np.ndarray  # (3,) over one principal moment of inertia [1 / (kg m^2)]
    axes: np.ndarray  # (3, 3) the principal axes, in rows
    kinds: np.ndarray  # (P,) of shape_formulae.KINDS
    begins: np.ndarray  # (P + 1,) where its numbers begin
    numbers: np.ndarray  # (K,) of all primitives
    positions: np.ndarray  # (P, 3) of the primitives' origins [m]
    matrices: np.ndarray  # (P, 3, 3) primitive to body
    centers: np.ndarray  # (P, 3) of their bounding spheres [m]
    radii: np.ndarray  # (P,) of their bounding spheres [m]
    span_of: np.ndarray  # (Q,) primitive of each part that a thread is looked at with
    spans: np.ndarray  # (Q, 2) share of the thread's length, from and to


@inlined
def primitive_surface(body, k, x, y, z):
    """Signed distance and normal at a point of the body frame [m], of one primitive."""
    m = body.matrices[k]
    dx, dy, dz = x - body.positions[k, 0], y - body.positions[k, 1], z - body.positions[k, 2]
    px, py, pz = (
        m[0, 0] * dx + m[1, 0] * dy + m[2, 0] * dz,
        m[0, 1] * dx + m[1, 1] * dy + m[2, 1] * dz,
        m[0, 2] * dx + m[1, 2] * dy + m[2, 2] * dz,
    )
    numbers = body.numbers[body.begins[k] : body.begins[k + 1]]
    distance, ux, uy, uz = surface_of_kind(body.kinds[k], numbers, px, py, pz)
    return (
        distance,
        m[0, 0] * ux + m[0, 1] * uy + m[0, 2] * uz,
        m[1, 0] * ux + m[1, 1] * uy + m[1, 2] * uz,
        m[2, 0] * ux + m[2, 1] * uy + m[2, 2] * uz,
    )


@inlined
def surface(body, x, y, z):
    """Signed distance and normal at a point of the body frame [m]: of the nearest primitive."""
    nearest, nx, ny, nz = np.inf, 0.0, 0.0, 1.0
    for k in range(len(body.kinds)):
        cx, cy, cz = x - body.centers[k, 0], y - body.centers[k, 1], z - body.centers[k, 2]
        beyond = nearest + body.radii[k]
        # No point of a primitive is nearer than its bounding sphere.
        if beyond < 0.0 or cx * cx + cy * cy + cz * cz >= beyond * beyond:
            continue
        distance, ux, uy, uz = primitive_surface(body, k, x, y, z)
        if distance < nearest:
            nearest, nx, ny, nz = distance, ux, uy, uz
    return nearest, nx, ny, nz


@inlined
def reach(body):
    """Its farthest point from its centre of mass [m]."""
    return body.reach


@inlined
def farthest(body):
    """A bound of the distance of its farthest point that a rotation moves [m]."""
    return body.reach


@inlined
def frame(body, matrix):
    """What :func:`within` needs of the attitude."""
    return (
        matrix[0, 0], matrix[0, 1], matrix[0, 2],
        matrix[1, 0], matrix[1, 1], matrix[1, 2],
        matrix[2, 0], matrix[2, 1], matrix[2, 2],
    )  # fmt: skip


@inlined
def inflated(body, size):
    """What :func:`within` needs of the body made larger by ``size`` [m]."""
    wide = body.reach + size
    return wide * wide, size


@inlined
def within(body, frame, limits, dx, dy, dz):
    """Whether a point is in the inflated body; ``dx``, ``dy``, ``dz``: from its centre of mass, launch frame [m]."""
    if dx * dx + dy * dy + dz * dz >= limits[0]:
        return False
    x = frame[0] * dx + frame[3] * dy + frame[6] * dz
    y = frame[1] * dx + frame[4] * dy + frame[7] * dz
    z = frame[2] * dx + frame[5] * dy + frame[8] * dz
    return surface(body, x, y, z)[0] < limits[1]


@inlined
def parts(body):
    """The convex primitives, and the others span by span."""
    return len(body.span_of)


@inlined
def span(body, part):
    """The share of a thread's length that is looked at."""
    return body.spans[part, 0], body.spans[part, 1]


@inlined
def part_surface(body, part, x, y, z):
    """Signed distance and normal of the part's primitive."""
    return primitive_surface(body, body.span_of[part], x, y, z)


@inlined
def decides(body, part, x, y, z, distance):
    """Whether no other primitive is nearer."""
    return surface(body, x, y, z)[0] >= distance - 1e-9


@inlined
def rate(body, state, matrix, output):
    """Write the angular rate in the launch frame [rad/s] to ``output``."""
    lx, ly, lz = state[10], state[11], state[12]
    bx = matrix[0, 0] * lx + matrix[1, 0] * ly + matrix[2, 0] * lz
    by = matrix[0, 1] * lx + matrix[1, 1] * ly + matrix[2, 1] * lz
    bz = matrix[0, 2] * lx + matrix[1, 2] * ly + matrix[2, 2] * lz
    wx, wy, wz = 0.0, 0.0, 0.0
    for i in range(3):
        ex, ey, ez = body.axes[i, 0], body.axes[i, 1], body.axes[i, 2]
        share = body.rates[i] * (ex * bx + ey * by + ez * bz)
        wx, wy, wz = wx + share * ex, wy + share * ey, wz + share * ez
    for axis in range(3):
        output[axis] = matrix[axis, 0] * wx + matrix[axis, 1] * wy + matrix[axis, 2] * wz


@inlined
def _begin(state, matrix):
    """Attitude, and angular momentum in the body frame."""
    lx, ly, lz = state[10], state[11], state[12]
    return (state[6], state[7], state[8], state[9]), (
        matrix[0, 0] * lx + matrix[1, 0] * ly + matrix[2, 0] * lz,
        matrix[0, 1] * lx + matrix[1, 1] * ly + matrix[2, 1] * lz,
        matrix[0, 2] * lx + matrix[1, 2] * ly + matrix[2, 2] * lz,
    )


@inlined
def _end(state, matrix, q):
    x, y, z, w = q
    norm = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    state[6], state[7], state[8], state[9] = x * norm, y * norm, z * norm, w * norm
    rigid_body.rotation_matrix(state, matrix)


@inlined
def drift(body, state, matrix, duration):
    """Move it freely for ``duration`` [s], however long; ``matrix`` is brought up to date.

    See tethernet_core.free_rotation; the angular momentum in the launch frame is not touched.
    """
    for axis in range(3):
        state[axis] += duration * state[3 + axis]
    q, momentum = _begin(state, matrix)
    length = math.sqrt(momentum[0] * momentum[0] + momentum[1] * momentum[1] + momentum[2] * momentum[2])
    if length == 0.0:
        return
    fastest = length * max(body.rates[0], body.rates[1], body.rates[2])
    parts = max(1, math.ceil(min(fastest * duration / free_rotation.LARGEST_TURN, 1e9)))
    for _ in range(parts):
        for share in free_rotation.COMPOSITION:
            q, momentum = _symmetric_step(body.axes, body.rates, share * duration / parts, q, momentum)
    _end(state, matrix, q)


@inlined
def step(body, state, matrix, duration):
    """:func:`drift` for one step of the integration, to the second order: its turns are below 1e-3 rad."""
    for axis in range(3):
        state[axis] += duration * state[3 + axis]
    q, momentum = _begin(state, matrix)
    q, _ = _symmetric_step(body.axes, body.rates, duration, q, momentum)
    _end(state, matrix, q)
