"""Tensions as shares of what threads can bear."""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels import rigid_body
from tethernet_sim.kernels.options import entry_point
from tethernet_sim.kernels.step import mu_threads, tether_force


@entry_point
def largest_share(
    numbers, arrays, chosen, thread_strength, tether_strength, knot_pos, knot_vel, mu_pos, mu_vel, bodies, closing,
    tether_length, share,
):  # fmt: skip
    """Raise ``share`` (B,) to the largest tension over strength of any thread of the ``chosen`` scenarios, as they are.

    Args:
        numbers: scalar constants of the model.
        arrays: constant arrays of the model.
        chosen: indices of scenarios.
        thread_strength: of the threads of net and units [N].
        tether_strength: of the main tether [N].
        knot_pos, knot_vel, mu_pos, mu_vel, bodies, closing, tether_length: see State.
        share: largest so far [-]; updated.
    """
    threads, rests, stiffness, damping = arrays.threads, arrays.rest, arrays.stiffness, arrays.damping
    mu_knot, mu_thread = arrays.mu_knot, arrays.mu_thread
    mu_stiffness, mu_damping = arrays.mu_stiffness, arrays.mu_damping
    mus, center = len(mu_knot), numbers.center_node
    force, torque, rate, matrix = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros((3, 3))
    pulls, mu_force = np.zeros((mus, 3)), np.zeros((mus, 3))
    for b in chosen:
        x, v = knot_pos[b], knot_vel[b]
        largest = 0.0
        for t in range(len(threads)):
            i, j, rest = threads[t, 0], threads[t, 1], rests[t]
            dx, dy, dz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
            squared = dx * dx + dy * dy + dz * dz
            if squared > rest * rest:
                length = math.sqrt(squared)
                way = dx * (v[0, j] - v[0, i]) + dy * (v[1, j] - v[1, i]) + dz * (v[2, j] - v[2, i])
                largest = max(largest, stiffness[t] * (length - rest) + damping[t] * way / length)
        mu_threads(
            x, v, mu_pos[b], mu_vel[b], mu_knot, mu_thread, mu_stiffness, mu_damping, mu_force, pulls
        )  # fmt: skip
        for m in range(mus):
            squared = pulls[m, 0] * pulls[m, 0] + pulls[m, 1] * pulls[m, 1] + pulls[m, 2] * pulls[m, 2]
            largest = max(largest, math.sqrt(squared))
        share[b] = max(share[b], largest / thread_strength)
        if closing[b] and center >= 0:
            chaser = bodies[b, 1]
            rigid_body.rotation_matrix(chaser, matrix)
            rigid_body.angular_rate(chaser, matrix, numbers.chaser_inertia, numbers.chaser_inertia, rate)
            tension = tether_force(x, v, chaser, matrix, rate, numbers, tether_length[b], force, torque)
            share[b] = max(share[b], tension / tether_strength)
