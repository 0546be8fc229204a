"""Units that meet each other, and net and units that meet the chaser."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.physics import coast, make_world
from tethernet_core.rotation import inverse, rotate
from tethernet_core.system import load_system
from tethernet_sim import audit
from tethernet_sim.energy import Auditor
from tethernet_sim.fly import Settings
from tethernet_sim.model import build_net_model
from tethernet_sim.state import ATTITUDE, CHASER, MOMENTUM, POSITION, VELOCITY
from tethernet_sim.world import World

CORNERS = [0, 1, 2, 3]
REACH_M = 0.2
"""Sum of the radii of two units."""


def stowed(hardware=None, **physics) -> World:
    """The folded net 1.5 m in front of the chaser, its corner units drawn out towards that by 0.9 m, closing begun."""
    world = make_world(8, hardware=hardware, **physics)
    world.state.mu_pos[0, CORNERS, 2] += 0.9
    world.begin_closing(0)
    return world


def momenta(world: World) -> tuple[np.ndarray, np.ndarray]:
    return audit.linear_momentum(world.model, world.state), audit.angular_momentum(world.model, world.state)


def test_two_units_bounce_off_each_other():
    world = stowed()
    state = world.state
    state.mu_vel[0, 0], state.mu_vel[0, 1] = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)
    before, nearest = momenta(world), math.inf
    for _ in coast(world, 20):
        nearest = min(nearest, float(np.linalg.norm(state.mu_pos[0, 1] - state.mu_pos[0, 0])))
    ratio, depth = world.physics.contact_damping_ratio, REACH_M - nearest
    assert depth < 2.0 * math.sqrt(1.25 / world.physics.contact_stiffness_n_m), "no deeper than without damping"
    # A linear spring and damper that cannot pull lets go where its force passes through zero.
    damped = math.sqrt(1.0 - ratio**2)
    left = math.exp(-ratio / damped * math.atan2(2.0 * ratio * damped, 2.0 * ratio**2 - 1.0))
    assert state.mu_vel[0, 1, 0] - state.mu_vel[0, 0, 0] == pytest.approx(2.0 * left, rel=0.01)
    for now, then in zip(momenta(world), before, strict=True):
        assert np.abs(now - then).max() < 1e-10


def test_neighbours_that_dock_do_not_push():
    system = load_system("zenit_8mu")
    meeting = build_net_model(system, Settings.load(system).physics).arrays.meeting
    neighbours = {tuple(sorted(pair)) for pair in system.ring_neighbours}
    assert {(a + 1, b + 1) for a, b in meeting.tolist()}.isdisjoint(neighbours)
    assert len(meeting) + len(neighbours) == 8 * 7 // 2
    system = load_system("zenit_4mu")
    meeting = build_net_model(system, Settings.load(system).physics).arrays.meeting
    assert len(meeting) == 6, "units that do not dock all push each other"


@pytest.mark.parametrize("thrown", ["unit", "net"])
def test_what_meets_the_chaser_bounces_and_pushes_it(thrown):
    world = stowed()
    state = world.state
    if thrown == "unit":
        state.mu_vel[0, 0, 2] = 1.0
    else:
        state.knot_vel[0, 2, :] = state.mu_vel[0, :, 2] = 3.0
        state.knot_pos[0, 0, :] += 0.3
        state.mu_pos[0, :, 0] += 0.3
    before, deepest = momenta(world), -math.inf
    chaser = state.bodies[0, CHASER]
    for _ in coast(world, 40 if thrown == "net" else 16):
        for places, radius in ((state.knot_pos[0].T, world.physics.knot_radius_m), (state.mu_pos[0], 0.5 * REACH_M)):
            local = rotate(inverse(chaser[ATTITUDE]), places - chaser[POSITION])
            deepest = max(deepest, float((radius + 0.75 - np.abs(local)).min(axis=1).max()))
    assert chaser[VELOCITY][2] > 1e-4, "it is pushed back"
    assert np.linalg.norm(chaser[MOMENTUM]) > 0.1, "and turned, because it is met beside its centre"
    assert -0.1 < deepest < 0.08, "nothing flies through its sides of 1.5 m"
    if thrown == "unit":
        assert state.mu_vel[0, 0, 2] < -0.3
    scale = 1.0 + np.abs(before[0]).max()
    for now, then in zip(momenta(world), before, strict=True):
        assert np.abs(now - then).max() < 1e-10 * scale


def test_every_force_between_units_and_on_the_chaser_is_booked():
    world = stowed()
    state = world.state
    state.mu_vel[0, 0], state.mu_vel[0, 1] = (1.0, 0.0, 0.2), (-1.0, 0.0, 0.1)
    state.mu_vel[0, 2, 2], state.knot_vel[0, 2, :] = 2.0, 2.0
    auditor = Auditor()
    auditor.attach(world)
    for _ in coast(world, 20):
        pass
    balance = auditor.balance()
    assert balance.work == pytest.approx(balance.gained, rel=1e-9)
    assert balance.lost["contact"] > 0.1
    start = balance.all_in - balance.gained
    assert abs(balance.residual) < 0.02 * abs(start)


def test_units_of_two_sizes_touch_the_debris_as_far_as_each_reaches():
    world = make_world(8, debris=(0.0, 0.0, -20.0))
    arrays, state = world.model.arrays, world.state
    world.model = world.engine.model = world.model._replace(numbers=world.model.numbers._replace(mu_radius=0.5))
    arrays.mu_radius[0] = 0.5
    # 0.45 m above the middle of the cylinder.
    shift = np.array([0.0, 0.0, -20.0 + 1.95 + 0.45]) - state.mu_pos[0, 0]
    state.knot_pos[0] += shift[:, None]
    state.mu_pos[0] += shift
    assert audit.elastic_energy(world.model, state)[0] > 0.5 * world.physics.contact_stiffness_n_m * 0.049**2
    for _ in coast(world, 1):
        pass
    assert state.mu_vel[0, 0, 2] > 0.1, "the larger one is pushed"
    assert np.abs(state.mu_vel[0, 1:]).max() == 0.0, "the others do not reach it"
