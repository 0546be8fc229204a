"""Worlds for the physics tests."""

from __future__ import annotations

import dataclasses

import numpy as np

from tethernet_core.system import load_system
from tethernet_sim import audit, stability
from tethernet_sim.fly import Settings
from tethernet_sim.world import World

DIAGONAL = (-0.5, 0.5, 0.0, np.sqrt(0.5))
"""Attitude with the cylinder's axis along the net's diagonal."""


def make_world(
    mus: int = 8,
    debris=(0.0, 0.0, -50.0),
    attitude=DIAGONAL,
    rate=(0.0, 0.0, 0.0),
    hardware=None,
    body=None,
    **physics,
) -> World:
    """A world of one scenario, with some entries of the system and some physical parameters replaced, and perhaps the
    debris by a homogeneous ``body``: shape and mass [kg].
    """
    system = load_system(f"zenit_{mus}mu", hardware or {})
    if body is not None:
        shape, mass = body
        described = dataclasses.replace(
            system.debris,
            shape=shape,
            mass_kg=mass,
            center_of_mass=shape.centroid,
            inertia=mass * shape.inertia_per_mass,
        )
        system = dataclasses.replace(system, debris=described)
    settings = Settings.load(system, physics=physics)
    return World(
        system,
        np.array([debris], float),
        np.array([attitude], float),
        np.array([rate], float),
        settings.physics,
        settings.control,
    )


def diverging(monkeypatch) -> Settings:
    """Settings with threads so stiff that the integration diverges, which is refused otherwise."""
    monkeypatch.setattr(stability, "largest_step_of", lambda system, physics: np.inf)
    return Settings.load(physics={"joint_stiffness_n_m": 2e4, "contact_stiffness_n_m": 1e5, "time_step_s": 1e-3})


def flying_net(mus: int, closing: bool, seed: int = 0, hardware=None, body=None, **physics) -> World:
    """A flat, shaken net that flies at a rotating debris 3 m away, the chaser drifting and turning: everything
    moves.
    """
    world = make_world(mus, debris=(0.3, -0.2, -50.0), rate=(0.05, 0.02, 0.1), hardware=hardware, body=body, **physics)
    state = world.state
    random = np.random.default_rng(seed)
    state.knot_pos[0, :2] /= world.physics.fold_factor * 1.02
    state.knot_pos[0, 2] = -47.0
    state.mu_pos[0] = state.knot_pos[0][:, world.model.arrays.mu_knot].T
    state.knot_vel[0] = random.normal(0.0, 0.3, state.knot_vel[0].shape)
    state.knot_vel[0, 2] -= 2.0
    state.mu_vel[0] = random.normal(0.0, 0.3, state.mu_vel[0].shape)
    state.mu_vel[0, :, 2] -= 2.5
    state.bodies[0, 1, 3:6] = (0.01, 0.0, 0.02)
    state.bodies[0, 1, 10:13] = (3.0, 1.0, 2.0)
    if closing:
        world.begin_closing(0)
    return world


def coast(world: World, periods: int):
    """Fly without thrust; yields after each control period."""
    zero = np.zeros_like(world.state.mu_pos)
    for _ in range(periods):
        world.advance(zero)
        yield


def energy(world: World) -> float:
    """Kinetic and elastic energy [J]."""
    return float((audit.kinetic_energy(world.model, world.state) + audit.elastic_energy(world.model, world.state))[0])
