"""Bookkeeping of a state's momentum and energy: what a flight-dynamics engineer checks first."""

from __future__ import annotations

import numpy as np

from tethernet_core.rotation import inverse, rotate
from tethernet_sim.debris import body_rate, surface_distance
from tethernet_sim.kernels import crossing_energy, energy
from tethernet_sim.model import Model
from tethernet_sim.state import ATTITUDE, CHASER, DEBRIS, MOMENTUM, POSITION, VELOCITY, State


def particle_masses(model: Model) -> np.ndarray:
    """Masses of all particles, knots then MUs [kg], shape (N + M,)."""
    return np.concatenate([model.arrays.knot_mass, model.arrays.mu_mass])


def particles(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m] and velocities [m/s] of all particles, each of shape (B, N + M, 3)."""
    position = np.concatenate([state.knot_pos.transpose(0, 2, 1), state.mu_pos], axis=1)
    velocity = np.concatenate([state.knot_vel.transpose(0, 2, 1), state.mu_vel], axis=1)
    return position, velocity


def linear_momentum(model: Model, state: State) -> np.ndarray:
    """Momentum of net, MUs, debris and chaser [kg m/s], shape (B, 3)."""
    _, velocity = particles(state)
    total = np.einsum("p,bpx->bx", particle_masses(model), velocity)
    total = total + model.debris.mass * state.bodies[:, DEBRIS, VELOCITY]
    return total + model.numbers.chaser_mass * state.bodies[:, CHASER, VELOCITY]


def angular_momentum(model: Model, state: State) -> np.ndarray:
    """Angular momentum of everything about the origin of the launch frame [N m s], shape (B, 3)."""
    position, velocity = particles(state)
    total = np.einsum("p,bpx->bx", particle_masses(model), np.cross(position, velocity))
    for body, mass in ((DEBRIS, model.debris.mass), (CHASER, model.numbers.chaser_mass)):
        orbital = np.cross(state.bodies[:, body, POSITION], state.bodies[:, body, VELOCITY])
        total = total + mass * orbital + state.bodies[:, body, MOMENTUM]
    return total


def thread_lengths(model: Model, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Lengths of the net's threads, shape (B, T), and of the MU threads, shape (B, M) [m]."""
    threads = model.arrays.threads
    net = np.linalg.norm(state.knot_pos[:, :, threads[:, 1]] - state.knot_pos[:, :, threads[:, 0]], axis=1)
    ends = state.knot_pos[:, :, model.arrays.mu_knot].transpose(0, 2, 1)
    return net, np.linalg.norm(state.mu_pos - ends, axis=2)


def kinetic_energy(model: Model, state: State) -> np.ndarray:
    """Kinetic energy of everything [J], shape (B,)."""
    _, velocity = particles(state)
    total = 0.5 * np.einsum("p,bpx,bpx->b", particle_masses(model), velocity, velocity)
    n = model.numbers
    for body, mass in ((DEBRIS, model.debris.mass), (CHASER, n.chaser_mass)):
        row = state.bodies[:, body]
        total = total + 0.5 * mass * np.sum(row[:, VELOCITY] ** 2, axis=1)
        momentum = rotate(inverse(row[:, ATTITUDE]), row[:, MOMENTUM])
        rate = body_rate(model.debris, momentum) if body == DEBRIS else momentum / n.chaser_inertia
        total = total + 0.5 * np.sum(momentum * rate, axis=1)
    return total


def elastic_energy(model: Model, state: State) -> np.ndarray:
    """Energy in threads, tether, winches' threads, joints, contacts (normal and friction springs) [J], shape (B,)."""
    net, mu = thread_lengths(model, state)
    arrays = model.arrays
    total = 0.5 * np.sum(arrays.stiffness * np.maximum(net - arrays.rest, 0.0) ** 2, axis=1)
    total = total + 0.5 * np.sum(arrays.mu_stiffness * np.maximum(mu - arrays.mu_thread, 0.0) ** 2, axis=1)
    position, _ = particles(state)
    for b in range(state.batch):
        if state.closing[b]:
            if model.numbers.center_node >= 0:
                chaser = state.bodies[b, CHASER]
                anchor = chaser[POSITION] + rotate(chaser[ATTITUDE], np.array([0.0, 0.0, model.numbers.tether_anchor]))
                stretch = np.linalg.norm(anchor - position[b, model.numbers.center_node]) - state.tether_length[b]
                total[b] += 0.5 * model.numbers.tether_stiffness * max(stretch, 0.0) ** 2
            gaps = np.linalg.norm(position[b, model.arrays.pairs[:, 1]] - position[b, model.arrays.pairs[:, 0]], axis=1)
            held = np.maximum(gaps - state.pair_length[b], 0.0)
            if model.winch_threads:
                on_winch = arrays.pair_winch >= 0
                free = np.where(state.locked[b], 0.0, gaps)[on_winch]
                free = np.bincount(arrays.pair_winch[on_winch], free, model.winch_threads)
                drawn = np.maximum(free - state.winch_length[b], 0.0)
                total[b] += 0.5 * model.numbers.winch_stiffness * np.sum(drawn**2)
            total[b] += 0.5 * model.numbers.joint_stiffness * np.sum(held[state.locked[b]] ** 2)
            total[b] += energy.stored_in_collisions(
                model.numbers, arrays, state.knot_pos[b], state.mu_pos[b], state.bodies[b, CHASER]
            )
        touching = state.crossed[b, : state.crossed_count[b]]
        total[b] += crossing_energy.stored(model.numbers, arrays, state.knot_pos[b], touching)
        debris = state.bodies[b, DEBRIS]
        local = rotate(inverse(debris[ATTITUDE])[None], position[b] - debris[POSITION])
        size = np.concatenate([np.full(model.numbers.knots, model.numbers.knot_radius), arrays.mu_radius])
        depth = size - surface_distance(model.debris, local)
        deep = depth > 0.0
        stiffness = np.where(np.arange(len(local)) < model.numbers.knots, 1.0, model.numbers.mu_contact_share)
        stiffness = (model.numbers.contact_stiffness * stiffness)[deep]
        held = np.sum(state.bristle[b, : len(deep)][deep] ** 2, axis=1)
        total[b] += 0.5 * np.sum(stiffness * (depth[deep] ** 2 + held))
        if len(model.arrays.segments):
            total[b] += energy.stored_in_threads(
                model.numbers, model.arrays, model.debris, state.knot_pos[b], state.mu_pos[b], debris, state.bristle[b],
                state.closing[b],
            )  # fmt: skip
    return total
