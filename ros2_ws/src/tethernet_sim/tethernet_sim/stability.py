"""The largest step at which the integration is stable, whatever the net's shape.

Semi-implicit Euler with explicit damping on a linearised system x'' = -K x - C x' (mass-normalised, symmetric) is
stable while h^2 K + 2 h C < 4: with u a unit eigenvector of the step's quadratic eigenvalue problem, kappa = u* K u and
gamma = u* C u, its factor z solves z^2 + (h^2 kappa + h gamma - 2) z + 1 - h gamma = 0, whose roots lie within the unit
circle exactly if h^2 kappa + 2 h gamma < 4.

K and C change with the net's shape. They are bounded here by what no shape exceeds: all threads taut and all along one
line (collapsed meshes), every knot, and every thread where threads touch, pressed to the debris and stuck to it, every
thread pressed on by others where the net touches itself, every closing pair held by a joint and by the winch's thread.
That is the Laplacian of a weighted graph plus a diagonal; its largest eigenvalue is that of the matrix of magnitudes,
found by power iteration and bounded from above by Collatz and Wielandt.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt

from tethernet_core.parameters import ParameterError
from tethernet_core.system import System
from tethernet_sim.crossing_threads import AT_ONCE
from tethernet_sim.model import Model, NetModel, build_net_model
from tethernet_sim.settings import PhysicsParameters

_ITERATIONS = 200


class Springs:
    """Springs and dampers between particles, as they bound the step."""

    def __init__(self, masses: np.ndarray):
        """Args:
        masses: of all particles [kg], shape (P,); infinite for what cannot move.
        """
        self._masses = masses
        self._ends: list[tuple[np.ndarray, np.ndarray]] = []
        self._strengths: list[tuple[np.ndarray, np.ndarray]] = []
        self._held = np.zeros((2, len(masses)))

    def between(
        self, first: npt.ArrayLike, second: npt.ArrayLike, stiffness: npt.ArrayLike, damping: npt.ArrayLike
    ) -> None:
        """Add springs between particles: their numbers, N/m and N s/m, each one for all or one for each."""
        first, second = np.asarray(first), np.asarray(second)
        self._ends.append((first, second))
        self._strengths.append((np.broadcast_to(stiffness, first.shape), np.broadcast_to(damping, first.shape)))

    def to_ground(self, stiffness: npt.ArrayLike, damping: npt.ArrayLike) -> None:
        """Hold every particle [N/m, N s/m], one for all or one for each."""
        self._held[0] += stiffness
        self._held[1] += damping

    def largest_step(self) -> float:
        """The largest stable step [s], infinite without springs."""
        stiffness, damping = self._largest(0), self._largest(1)
        # h^2 K + 2 h C = 4; the sum of both bounds bounds the sum.
        root = math.sqrt(damping * damping + 4.0 * stiffness)
        return 4.0 / (damping + root) if root > 0.0 else math.inf

    def _largest(self, kind: int) -> float:
        """Upper bound of the largest eigenvalue of K [1/s^2] or C [1/s]."""
        count = len(self._masses)
        first = np.concatenate([a for a, _ in self._ends])
        second = np.concatenate([b for _, b in self._ends])
        strength = np.concatenate([s[kind] for s in self._strengths])
        both, other, twice = np.concatenate([first, second]), np.concatenate([second, first]), np.tile(strength, 2)
        diagonal = np.bincount(both, twice, count) + self._held[kind]
        x = np.ones(count)
        bound = math.inf
        for _ in range(_ITERATIONS):
            image = (diagonal * x + np.bincount(both, twice * x[other], count)) / self._masses
            bound = min(bound, float((image / x).max()))
            # The least share keeps the ratio defined where hardly anything arrives.
            x = np.maximum(image / image.max(), 1e-6) if image.max() > 0.0 else x
        return bound


def check_stable(system: System, physics: PhysicsParameters) -> None:
    """Make sure that a system can be flown with this time step.

    Raises:
        ParameterError: naming the largest one that is allowed.
    """
    largest = largest_step_of(system, physics)
    if physics.time_step_s > largest:
        raise ParameterError(
            f"PhysicsParameters.time_step_s = {physics.time_step_s:g}: unstable with the masses, stiffnesses and "
            f"dampings of {system.name}; allowed: at most {math.floor(largest * 1e9) * 1e-9:.5g} s, a whole part of "
            "the control period"
        )


@functools.lru_cache(maxsize=64)
def largest_step_of(system: System, physics: PhysicsParameters) -> float:
    """The largest time step that is stable for a system [s]; the parameters' own step is not looked at."""
    return largest_step(build_net_model(system, physics))


def largest_step(model: Model | NetModel) -> float:
    """The largest stable time step of a model [s]; its own step is not looked at."""
    n, arrays = model.numbers, model.arrays
    knots, mus = n.knots, len(arrays.mu_knot)
    springs = net_springs(model)
    springs.between(arrays.mu_knot, knots + np.arange(mus), arrays.mu_stiffness, arrays.mu_damping)
    share = np.where(np.arange(knots + mus) < knots, 1.0, n.mu_contact_share)
    springs.to_ground(n.contact_stiffness * share, arrays.contact_damping)
    springs.to_ground(*_thread_contacts(model))
    _add_crossings(model, springs)
    # The main tether is held by the chaser, the stand-ins of external MUs by their targets.
    held = np.zeros((2, knots + mus))
    if n.center_node >= 0:
        held[:, n.center_node] = n.tether_stiffness, n.tether_damping
    held[:, knots:] = arrays.coupling_stiffness, arrays.coupling_damping
    springs.to_ground(*held)
    # Two units that touch are as stiff as one that touches the debris, and damped less.
    a, b = arrays.meeting.T
    springs.between(
        knots + a, knots + b, n.contact_stiffness * n.mu_contact_share, arrays.contact_damping[knots + np.minimum(a, b)]
    )
    # A pair is locked or part of a thread. One tension in s segments is at most as stiff as s times that in each.
    segments = np.append(np.diff(arrays.winch_begin), 0)[arrays.pair_winch]
    stiffness = np.maximum(n.joint_stiffness, segments * n.winch_stiffness)
    springs.between(arrays.pairs[:, 0], arrays.pairs[:, 1], stiffness, arrays.joint_damping)
    return springs.largest_step()


def _thread_contacts(model: Model | NetModel) -> np.ndarray:
    """Bound of what touching threads hold each particle with [N/m, N s/m], shape (2, N + M).

    A contact at the share s of a thread adds k (1 - s)^2 and k s^2 at its ends and k s (1 - s) between them, at most
    k (1 - s) and k s in a row; its damper 2 zeta sqrt(k m) goes with the mass m that the point has, which is at most
    that of an end over the square of the end's share.
    """
    arrays = model.arrays
    masses, held = 1.0 / arrays.inverse_mass, np.zeros((2, len(arrays.inverse_mass)))
    for end in range(2):
        particle = arrays.segments[:, end]
        damping = 2.0 * model.numbers.contact_damping_ratio * np.sqrt(arrays.segment_stiffness * masses[particle])
        held[0] += np.bincount(particle, arrays.segment_stiffness, len(masses))
        held[1] += np.bincount(particle, damping, len(masses))
    return held


def _add_crossings(model: Model | NetModel, springs: Springs) -> None:
    """Contact of net with net: :data:`~tethernet_sim.crossing_threads.AT_ONCE` threads on each.

    A contact of stiffness k at the share s of a thread, along its normal n, holds the ends with at most
    2 k ((1 - s) (n x_i)^2 + s (n x_j)^2), half of it each thread's. The normal is across the thread and the thread's
    own spring K acts along it: for any direction of x_i and x_j both together are at most K (|x_i| + |x_j|)^2 while
    all contacts together have 2 k <= K, and with 2 k in the place of K else; dampers likewise. Friction acts along the
    thread too, and with the turning of all four ends (kernels/crossing_law.py) on them alike: 2 k on each.
    """
    numbers, arrays = model.numbers, model.arrays
    if not len(arrays.crossing_threads.ends):
        return
    together = 2.0 * AT_ONCE
    pressing, grip = together * numbers.crossing_stiffness, together * numbers.crossing_grip
    springs.between(
        arrays.threads[:, 0], arrays.threads[:, 1], np.maximum(pressing - arrays.stiffness, 0.0),
        np.maximum(pressing * numbers.crossing_viscosity - arrays.damping, 0.0),
    )  # fmt: skip
    threads = np.bincount(arrays.threads.ravel(), minlength=len(arrays.inverse_mass))
    springs.to_ground(grip * threads, grip * numbers.crossing_viscosity * threads)


def net_springs(model: Model | NetModel) -> Springs:
    """All threads of the net, between all particles of the model."""
    arrays = model.arrays
    springs = Springs(np.concatenate([arrays.knot_mass, arrays.mu_mass]))
    springs.between(arrays.threads[:, 0], arrays.threads[:, 1], arrays.stiffness, arrays.damping)
    return springs
