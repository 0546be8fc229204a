"""Tensions as shares of what threads can bear."""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels import pairs, rigid_body
from tethernet_sim.kernels.options import entry_point, inlined
from tethernet_sim.kernels.step import mu_threads, tether_force


@inlined
def largest_of_closing(numbers, arrays, knot_pos, knot_vel, mu_pos, mu_vel, lengths, locked, winch_length, span):
    """Largest tension of a joint or a winch's thread [N]; ``span`` (R, 5) is work space."""
    pairs.measure(knot_pos, knot_vel, mu_pos, mu_vel, numbers.knots, arrays.pairs, span)
    largest = 0.0
    for r in range(len(arrays.pairs)):
        if locked[r] and span[r, 3] > lengths[r]:
            tension = numbers.joint_stiffness * (span[r, 3] - lengths[r]) + arrays.joint_damping[r] * span[r, 4]
            largest = max(largest, tension)
    for thread in range(len(winch_length)):
        length = 0.0
        for r in range(arrays.winch_begin[thread], arrays.winch_begin[thread + 1]):
            length += 0.0 if locked[r] else span[r, 3]
        largest = max(largest, numbers.winch_stiffness * (length - winch_length[thread]))
    return largest


@entry_point
def largest_share(
    numbers, arrays, chosen, thread_strength, tether_strength, knot_pos, knot_vel, mu_pos, mu_vel, bodies, closing,
    pair_length, locked, winch_length, tether_length, share,
):  # fmt: skip
    """Raise ``share`` (B,) to the largest tension over strength of any thread of the ``chosen`` scenarios, as they are:
    of net and units, of joints and winches' threads, which are of the same material, of the main tether.

    Args:
        numbers: scalar constants of the model.
        arrays: constant arrays of the model.
        chosen: indices of scenarios.
        thread_strength: of the threads of net and units [N].
        tether_strength: of the main tether [N].
        knot_pos, knot_vel, mu_pos, mu_vel, bodies, closing, pair_length, locked, winch_length, tether_length: see
            State.
        share: largest so far [-]; updated.
    """
    threads, rests, stiffness, damping = arrays.threads, arrays.rest, arrays.stiffness, arrays.damping
    mu_knot, mu_thread = arrays.mu_knot, arrays.mu_thread
    mu_stiffness, mu_damping = arrays.mu_stiffness, arrays.mu_damping
    mus, center = len(mu_knot), numbers.center_node
    force, torque, rate, matrix = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros((3, 3))
    pulls, mu_force, span = np.zeros((mus, 3)), np.zeros((mus, 3)), np.zeros((len(arrays.pairs), 5))
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
        if closing[b]:
            largest = max(
                largest,
                largest_of_closing(
                    numbers, arrays, x, v, mu_pos[b], mu_vel[b], pair_length[b], locked[b], winch_length[b], span
                ),
            )
        share[b] = max(share[b], largest / thread_strength)
        if closing[b] and center >= 0:
            chaser = bodies[b, 1]
            rigid_body.rotation_matrix(chaser, matrix)
            rigid_body.angular_rate(chaser, matrix, numbers.chaser_inertia, numbers.chaser_inertia, rate)
            tension = tether_force(x, v, chaser, matrix, rate, numbers, tether_length[b], force, torque)
            share[b] = max(share[b], tension / tether_strength)
