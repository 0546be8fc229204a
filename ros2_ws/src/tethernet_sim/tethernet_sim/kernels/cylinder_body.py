"""Debris that is a homogeneous cylinder, or has its symmetry: nothing is looked up, and its loops vectorise."""

from __future__ import annotations

import math
from typing import NamedTuple

from tethernet_sim.kernels import rigid_body
from tethernet_sim.kernels.options import inlined
from tethernet_sim.kernels.shape_formulae import COMPILED

_surface = COMPILED["cylinder"]


class CylinderBody(NamedTuple):
    """A cylinder round body z, its centre of mass in its middle."""

    mass: float  # [kg]
    across: float  # moment of inertia across the axis [kg m^2]
    along: float  # along it [kg m^2]
    radius: float  # [m]
    half_length: float  # [m]


@inlined
def surface(body, x, y, z):
    """Signed distance and normal at a point of the body frame [m]."""
    return _surface((body.radius, body.half_length), x, y, z)


@inlined
def reach(body):
    """Its farthest point from its centre of mass [m]."""
    return math.sqrt(body.radius * body.radius + body.half_length * body.half_length)


@inlined
def farthest(body):
    """A bound of the distance of its farthest point that a rotation moves [m]."""
    return body.radius + body.half_length


@inlined
def frame(body, matrix):
    """What :func:`within` needs of the attitude."""
    return matrix[0, 2], matrix[1, 2], matrix[2, 2]


@inlined
def inflated(body, size):
    """What :func:`within` needs of the body made larger by ``size`` [m]."""
    wide = body.radius + size
    return wide * wide, body.half_length + size


@inlined
def within(body, frame, limits, dx, dy, dz):
    """Whether a point is in the inflated cylinder, without roots; ``dx``, ``dy``, ``dz``: from its centre [m]."""
    along = frame[0] * dx + frame[1] * dy + frame[2] * dz
    return (dx * dx + dy * dy + dz * dz - along * along < limits[0]) & (abs(along) < limits[1])


@inlined
def parts(body):
    """One."""
    return 1


@inlined
def span(body, part):
    """The whole thread: a cylinder is convex."""
    return 0.0, 1.0


@inlined
def part_surface(body, part, x, y, z):
    """Signed distance and normal at a point of the body frame [m]."""
    return _surface((body.radius, body.half_length), x, y, z)


@inlined
def decides(body, part, x, y, z, distance):
    """Always: there is no other part."""
    return True


@inlined
def rate(body, state, matrix, output):
    """Write the angular rate in the launch frame [rad/s] to ``output``."""
    rigid_body.angular_rate(state, matrix, body.across, body.along, output)


@inlined
def drift(body, state, matrix, duration):
    """Move it freely for ``duration`` [s]."""
    rigid_body.drift_body(state, matrix, body.across, body.along, duration)


@inlined
def step(body, state, matrix, duration):
    """Move it freely for one step of the integration [s]."""
    rigid_body.small_rotation_step(state, matrix, body.across, body.along, duration)
