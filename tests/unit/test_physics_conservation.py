"""What no simulator of free flight may break: momentum, and energy that only goes down without thrust."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics import coast, energy, flying_net, make_world
from tethernet_sim import audit
from tethernet_sim.fly import fly
from tethernet_sim.scenario import Scenario
from tethernet_sim.world import World


@pytest.mark.parametrize("mus", [4, 8])
@pytest.mark.parametrize("closing", [False, True])
def test_linear_momentum_is_conserved_to_rounding(mus, closing):
    world = flying_net(mus, closing)  # 4 MUs closing: the winches pull, pairs lock
    before = audit.linear_momentum(world.model, world.state)
    touched = 0
    for _ in coast(world, 100):
        touched = max(touched, int(world.state.contacts[0]))
    after = audit.linear_momentum(world.model, world.state)
    assert touched > 10, "the net must have met the debris, or the test shows nothing"
    assert np.abs(after - before).max() < 1e-11 * np.abs(before).max()
    assert np.linalg.norm(world.state.bodies[0, 0, 3:6]) > 1e-5, "the debris must have been pushed"


@pytest.mark.parametrize("mus", [4, 8])
def test_angular_momentum_is_conserved_to_rounding(mus):
    world = flying_net(mus, closing=True)
    before = audit.angular_momentum(world.model, world.state)
    torque_free = world.state.bodies[0, 0, 10:13].copy()
    for _ in coast(world, 100):
        pass
    after = audit.angular_momentum(world.model, world.state)
    assert np.abs(after - before).max() < 1e-11 * np.abs(before).max()
    assert np.linalg.norm(world.state.bodies[0, 0, 10:13] - torque_free) > 1e-3, "the debris must have been turned"


def closed(mus: int, pairs: int) -> World:
    """A world as a mission with a tumbling debris leaves it when so many pairs are locked, without thrust from here."""
    found = []

    def look(_stamp_ns, world, _flying):
        if not found and world.state.closing[0] and world.state.locked[0].sum() >= pairs:
            found.append(world.state.copy())

    fly(Scenario(f"zenit_{mus}mu", debris_rate=(0.02, 0.03, 0.0)), None, look)
    world = make_world(mus)
    world.state = found[0]
    return world


@pytest.mark.parametrize(("mus", "pairs"), [(4, 0), (8, 1)])
def test_angular_momentum_is_conserved_to_rounding_while_pairs_lock(mus, pairs):
    """Winches from the start of closing on; docking, for which thrusters are needed, from the first joint on."""
    world = closed(mus, pairs)
    before = audit.angular_momentum(world.model, world.state)
    linear = audit.linear_momentum(world.model, world.state)
    turning = world.state.bodies[0, 0, 10:13].copy()
    for _ in coast(world, 240):  # 12 s
        pass
    assert world.state.locked.sum() >= pairs + 3, "joints must have been at work"
    assert np.abs(audit.angular_momentum(world.model, world.state) - before).max() < 1e-10 * np.abs(before).max()
    assert np.abs(audit.linear_momentum(world.model, world.state) - linear).max() < 1e-10 * np.abs(linear).max()
    assert np.linalg.norm(world.state.bodies[0, 0, 10:13] - turning) > 0.1, "the debris must have been turned"


@pytest.mark.parametrize("mus", [4, 8])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(("contact", "share"), [("knots", 1e-9), ("threads", 1e-4)])
def test_energy_never_grows_without_thrust(mus, seed, contact, share):
    """Where threads touch, the point that touches is found anew every few steps: once in some missions it then lies
    deeper at once, by a spring's few millijoules.
    """
    # The winch is a motor; it stands still here and holds its thread. Threads, tether, contact, friction are at work.
    still = {"closing.winch.speed_m_s": 0.0} if mus == 4 else None
    world = flying_net(mus, closing=True, seed=seed, hardware=still, contact=contact)
    energies = [energy(world)]
    touched, held = 0, 0.0
    for _ in coast(world, 160):
        energies.append(energy(world))
        touched = max(touched, int(world.state.contacts[0]))
        held = max(held, winch_pull(world))
    assert touched > 10
    assert mus == 8 or held > 1.0, "the winches must have held something"
    assert np.maximum(np.diff(energies), 0.0).sum() <= share * energies[0]
    assert energies[-1] < 0.99 * energies[0]


def winch_pull(world: World) -> float:
    """Largest tension of a winch's thread [N]; 0 where there is none."""
    if not world.model.winch_threads:
        return 0.0
    state, pairs = world.state, world.model.arrays.pairs
    span = np.linalg.norm(state.knot_pos[0][:, pairs[:, 1]] - state.knot_pos[0][:, pairs[:, 0]], axis=0)
    free = np.where(state.locked[0], 0.0, span).reshape(world.model.winch_threads, -1).sum(axis=1)
    return float(world.system.closing.winch_stiffness_n_m * (free - state.winch_length[0]).max())


def test_without_damping_and_friction_energy_stays():
    # A net that meets nothing, undamped: energy moves between springs and knots only. The small step keeps the
    # symplectic method's own oscillation of the energy, which shrinks with it, below the bound.
    world = flying_net(8, closing=False, hardware={"net.thread.damping_ratio": 0.0}, time_step_s=1e-5)
    world.state.bodies[0, 0, 2] = -80.0
    before = energy(world)
    for _ in coast(world, 20):
        pass
    assert energy(world) == pytest.approx(before, rel=1e-3)


def test_with_damping_energy_goes():
    world = flying_net(8, closing=False)
    world.state.bodies[0, 0, 2] = -80.0
    before = energy(world)
    for _ in coast(world, 20):
        pass
    assert energy(world) < 0.9999 * before


@pytest.mark.parametrize("mus", [4, 8])
def test_a_chaser_that_tows_gives_its_thrust_to_the_whole_system(mus):
    """The momentum of everything grows by force times time; a chaser whose net is not held yet coasts."""
    force = np.array([1.0, -2.0, 20.0])
    for closing, felt in ((True, force), (False, np.zeros(3))):
        world = flying_net(mus, closing)
        world.chaser_force[0] = force
        before = audit.linear_momentum(world.model, world.state)
        periods = sum(1 for _ in coast(world, 40))
        gained = audit.linear_momentum(world.model, world.state) - before
        duration_s = periods * world.steps * world.model.numbers.time_step
        assert gained[0] == pytest.approx(felt * duration_s, abs=1e-9 * np.abs(before).max())
