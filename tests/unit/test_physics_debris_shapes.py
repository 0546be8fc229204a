"""Contact with debris of any shape and inertia: the same law, the same conservation."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from tests.physics import coast, flying_net, make_world
from tethernet_core.rotation import inverse, rotate
from tethernet_core.shapes import Box, Capsule, Compound, Cone, Cylinder, Mesh, Part, Shape, Sphere
from tethernet_sim import audit
from tethernet_sim.debris import body_rate, debris_body, inertia_tensor, surface_distance
from tethernet_sim.energy import Auditor
from tethernet_sim.kernels import debris_body as kernels
from tethernet_sim.kernels.general_body import GeneralBody
from tethernet_sim.state import ATTITUDE, DEBRIS, MOMENTUM, POSITION, VELOCITY

BUS_AND_PANEL = Compound(
    (
        Part(Box((2.5, 2.5, 6.0)), mass_share=0.9),
        Part(Box((0.1, 8.0, 2.5)), (0.0, 5.0, 1.0), (0.1, 0.0, 0.0, math.sqrt(0.99)), mass_share=0.06),
        Part(Cone(0.6, 1.5, 0.9), (0.0, 0.0, -3.6), mass_share=0.04),
    )
)
SHAPES = {
    "box": Box((3.0, 4.0, 9.0)),
    "sphere": Sphere(2.5),
    "capsule": Capsule(1.5, 8.0),
    "cone": Cone(2.0, 8.0, 0.5),
    "compound": BUS_AND_PANEL,
    "mesh": Mesh(*Cone(2.0, 8.0, 0.5).triangles()),
    "cylinder off centre": Compound((Part(Cylinder(1.5, 8.0), (0.4, 0.2, -0.3), (0.0, 0.1, 0.0, math.sqrt(0.99))),)),
}


@numba.njit
def _surface(body, points, output):
    for i in range(len(points)):
        output[i] = kernels.surface(body, points[i, 0], points[i, 1], points[i, 2])


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_the_compiled_surface_is_the_shapes_own(shape: Shape):
    body = debris_body(shape, 1000.0)
    assert isinstance(body, GeneralBody)
    points = np.random.default_rng(1).uniform(-6.0, 6.0, (3000, 3))
    got = np.empty((len(points), 4))
    _surface(body, points, got)
    distance, normal = shape.distance(points + shape.centroid)
    np.testing.assert_allclose(got[:, 0], distance, atol=1e-12)
    np.testing.assert_allclose(surface_distance(body, points), distance, atol=1e-12)
    agree = np.einsum("ij,ij->i", got[:, 1:], normal) > 1.0 - 1e-9
    assert agree.mean() > 0.999  # but where two parts, or two faces, are equally near


SOME = 3
"""Points of a net that touch the debris at once."""


def test_a_cylinder_with_its_own_inertia_keeps_the_fast_path_and_others_do_not():
    cylinder = Cylinder(1.0, 4.0)
    assert not isinstance(debris_body(cylinder, 10.0), GeneralBody)
    assert not isinstance(debris_body(cylinder, 10.0, np.diag([9.0, 9.0, 3.0])), GeneralBody)
    assert isinstance(debris_body(cylinder, 10.0, np.diag([9.0, 8.0, 3.0])), GeneralBody)
    assert isinstance(debris_body(cylinder, 10.0, center_of_mass=np.array([0.0, 0.0, 0.1])), GeneralBody)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_a_net_thrown_at_it_stops_at_its_surface_and_momentum_stays(shape):
    world = flying_net(8, closing=False, body=(shape, 5000.0))
    body = world.model.debris
    linear, angular = audit.linear_momentum(world.model, world.state), audit.angular_momentum(world.model, world.state)
    deepest, touched = 0.0, 0
    for _ in coast(world, 60):
        state = world.state
        row = state.bodies[0, DEBRIS]
        position, _ = audit.particles(state)
        local = rotate(inverse(row[ATTITUDE]), position[0] - row[POSITION])
        deepest = min(deepest, float(surface_distance(body, local).min()))
        touched = max(touched, int(state.contacts[0]))
    assert touched > 5
    assert deepest > -0.02
    assert np.abs(audit.linear_momentum(world.model, world.state) - linear).max() < 1e-9
    assert np.abs(audit.angular_momentum(world.model, world.state) - angular).max() < 1e-7


@pytest.mark.parametrize("name", ["box", "compound", "mesh", "cylinder off centre"])
def test_every_force_is_booked_whatever_the_debris(name):
    world = flying_net(8, closing=True, body=(SHAPES[name], 3000.0))
    auditor = Auditor()
    auditor.attach(world)
    for _ in coast(world, 60):
        pass
    balance = auditor.balance()
    assert balance.work == pytest.approx(balance.gained, rel=1e-9)
    assert balance.lost["contact"] > 0.0
    assert balance.lost["friction"] > 0.0
    moving = audit.kinetic_energy(world.model, world.state)[0]
    assert abs(balance.residual) < 0.01 * moving


def test_a_cylinder_flies_the_same_in_its_own_and_in_the_general_form():
    shape = Cylinder(1.95, 11.1)
    first, second = (flying_net(8, closing=True, body=(s, 9000.0)) for s in (shape, Compound((Part(shape),))))
    assert not isinstance(first.model.debris, GeneralBody)
    assert isinstance(second.model.debris, GeneralBody)
    # How many touch at once in a shaken net hangs on the last digits, which are the processor's: some are enough.
    assert any(first.state.contacts[0] >= SOME for _ in coast(first, 80))
    second.state = first.state.copy()
    velocity = first.state.bodies[0, DEBRIS, VELOCITY].copy()
    first.steps = second.steps = 100
    for _ in zip(coast(first, 1), coast(second, 1), strict=True):
        pass
    a, b = first.state, second.state
    # Their arithmetic differs in the last digits, which contacts and threads that snap multiply by ten in 30 steps.
    assert a.contacts[0] == b.contacts[0]
    assert (a.bodies[0, DEBRIS, VELOCITY] != velocity).all(), "it was pushed in the meantime"
    np.testing.assert_allclose(b.knot_pos, a.knot_pos, atol=1e-10)
    np.testing.assert_allclose(b.bodies, a.bodies, rtol=1e-10, atol=1e-9)


def test_the_published_rate_is_that_of_the_full_tensor():
    rate = np.array([0.02, -0.05, 0.03])
    world = make_world(8, rate=rate, body=(BUS_AND_PANEL, 5000.0))
    body = world.model.debris
    np.testing.assert_allclose(world.body_motion(0, DEBRIS)[3], rate, rtol=1e-12)
    row = world.state.bodies[0, DEBRIS]
    local = rotate(inverse(row[ATTITUDE]), row[MOMENTUM])
    np.testing.assert_allclose(local, inertia_tensor(body) @ rate, rtol=1e-12)
    for _ in coast(world, 100):
        pass
    row = world.state.bodies[0, DEBRIS]
    local = rotate(inverse(row[ATTITUDE]), row[MOMENTUM])
    np.testing.assert_allclose(world.body_motion(0, DEBRIS)[3], body_rate(body, local), rtol=1e-12)


def test_the_attitude_is_that_of_the_described_axes():
    """A box that turns about its own x axis: its principal axes are ordered otherwise, its attitude is not."""
    box = Box((1.0, 2.0, 9.0))
    world = make_world(8, attitude=(0.0, 0.0, 0.0, 1.0), rate=(0.1, 0.0, 0.0), body=(box, 100.0))
    for _ in coast(world, 100):  # 5 s
        pass
    expected = np.array([math.sin(0.25), 0.0, 0.0, math.cos(0.25)])
    np.testing.assert_allclose(world.state.bodies[0, DEBRIS, ATTITUDE], expected, atol=1e-12)
