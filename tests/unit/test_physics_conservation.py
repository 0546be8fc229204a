"""What no simulator of free flight may break: momentum, and energy that only goes down without thrust."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics import coast, energy, flying_net
from tethernet_sim import audit


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
    # Joints are left out on purpose: their damper acts across the line of a pair, for units that dock and do not orbit.
    world = flying_net(mus, closing=True)
    before = audit.angular_momentum(world.model, world.state)
    torque_free = world.state.bodies[0, 0, 10:13].copy()
    for _ in coast(world, 100):
        assert not world.state.locked.any()
    after = audit.angular_momentum(world.model, world.state)
    assert np.abs(after - before).max() < 1e-11 * np.abs(before).max()
    assert np.linalg.norm(world.state.bodies[0, 0, 10:13] - torque_free) > 1e-3, "the debris must have been turned"


@pytest.mark.parametrize("mus", [4, 8])
@pytest.mark.parametrize("seed", [0, 1])
def test_energy_never_grows_without_thrust(mus, seed):
    # The winch is a motor; it stands still here. Threads, tether, contact and friction are all at work.
    world = flying_net(mus, closing=True, seed=seed, winch_speed_m_s=0.0)
    energies = [energy(world)]
    touched = 0
    for _ in coast(world, 160):
        energies.append(energy(world))
        touched = max(touched, int(world.state.contacts[0]))
    assert touched > 10
    assert np.diff(energies).max() <= 1e-9 * energies[0]
    assert energies[-1] < 0.99 * energies[0]


def test_without_damping_and_friction_energy_stays():
    # A net that meets nothing, undamped: energy moves between springs and knots only. The small step keeps the
    # symplectic method's own oscillation of the energy, which shrinks with it, below the bound.
    world = flying_net(8, closing=False, thread_damping_ratio=0.0, time_step_s=1e-5)
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
