"""The validation net as described, hung up at its corners: the equilibrium that was computed for the published one."""

import numpy as np
import pytest

from tethernet_core.system import load_system

GRAVITY = 50.0  # [m/s^2]


def at_rest(net, fixed):
    """Node positions [m] and thread tensions [N] at rest, found by damped motion from the flat net."""
    position, velocity = net.nodes.copy(), np.zeros_like(net.nodes)
    first, second = net.threads.T
    mass = net.node_masses[:, None]
    step, drag = 4e-4, 6.0  # [s], [1/s]

    def tensions():
        apart = position[second] - position[first]
        length = np.linalg.norm(apart, axis=1)
        return net.thread_stiffness * np.maximum(length - net.rest_lengths, 0.0), apart / length[:, None]

    for _ in range(12_000):
        tension, along = tensions()
        pull = tension[:, None] * along
        force = np.stack([np.bincount(first, p, len(mass)) - np.bincount(second, p, len(mass)) for p in pull.T], axis=1)
        force[:, 2] -= GRAVITY * mass[:, 0]
        velocity += step * (force / mass - drag * velocity)
        velocity[fixed] = 0.0
        position += step * velocity
    assert np.abs(velocity).max() < 1e-5
    return position, tensions()[0]


def test_equilibrium_of_the_sagging_net():
    system = load_system("sag_hexagonal_1m")
    net, corners = system.net, list(system.launch.particles)
    np.testing.assert_allclose(np.linalg.norm(net.nodes[corners], axis=1), 1.0)
    position, tension = at_rest(net, corners)
    assert position[net.center_node, 2] == pytest.approx(-0.43501, abs=2e-5)
    assert position[:, 2].min() == pytest.approx(-0.43579, abs=2e-5)
    assert tension.min() == pytest.approx(0.6308, abs=2e-3)
    assert tension.max() == pytest.approx(54.112, abs=2e-3)
    assert GRAVITY * net.mass_kg == pytest.approx(565.487, abs=1e-3)
