"""The varying part of a simulation: arrays with a leading scenario axis B. One scenario is the batch of one."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tethernet_core.rotation import rotate
from tethernet_core.system import System
from tethernet_sim.debris import body_momentum
from tethernet_sim.kernels.crossing_work import RECORD
from tethernet_sim.model import Model
from tethernet_sim.settings import PhysicsParameters

DEBRIS, CHASER = 0, 1
POSITION, VELOCITY, ATTITUDE, MOMENTUM = slice(0, 3), slice(3, 6), slice(6, 10), slice(10, 13)
"""Columns of :attr:`State.bodies`."""


@dataclass
class State:
    """State of B scenarios, frame launch. Particles are the net's N knots, then the M MUs."""

    knot_pos: np.ndarray  # (B, 3, N)
    """Knot positions [m], one contiguous row per coordinate, so that the thread forces vectorise."""
    knot_vel: np.ndarray  # (B, 3, N)
    """Knot velocities [m/s]."""
    mu_pos: np.ndarray  # (B, M, 3)
    """MU positions [m]."""
    mu_vel: np.ndarray  # (B, M, 3)
    """MU velocities [m/s]."""
    bodies: np.ndarray  # (B, 2, 13)
    """Debris and chaser: position [m], velocity [m/s], attitude (x y z w, body to launch), angular momentum about the
    centre of mass [N m s].
    """
    bristle: np.ndarray  # (B, N + M + 2 S Q, 3)
    """Tangential displacement of each contact since it stuck, debris body frame [m]: of each particle, then, where
    threads touch, of two points of each of S threads on each of Q parts of the debris.
    """
    crossed: np.ndarray  # (B, C, 9)
    """Pairs of threads of the net that touch each other, where they do: see RECORD of kernels.crossing_work."""
    crossed_count: np.ndarray  # (B,) int64
    """How many of these there are; C has room for more."""
    closing: np.ndarray  # (B,) bool
    """Closing has begun: tether locked, winches on, docking enabled."""
    tether_length: np.ndarray  # (B,)
    """Length of the locked main tether [m]; as paid out while it is free."""
    pair_length: np.ndarray  # (B, R)
    """Rest length of each joint; of a pair that is not locked, its distance at the last step of closing [m]."""
    locked: np.ndarray  # (B, R) bool
    """Closing pairs held for good."""
    winch_length: np.ndarray  # (B, S)
    """Rest length of what is not locked of each winch's thread [m]; S is 0 where the MUs dock."""
    contacts: np.ndarray  # (B,) int64
    """Particles in contact with the debris at the last step."""

    @property
    def batch(self) -> int:
        """Number of scenarios."""
        return len(self.closing)

    def take(self, other: State, chosen: np.ndarray) -> None:
        """Become as another state of the same model in some scenarios, with room for as many touching pairs as here.

        Args:
            other: no more room for touching pairs than here.
            chosen: indices of the scenarios.
        """
        for f in fields(self):
            if f.name != "crossed":
                getattr(self, f.name)[chosen] = getattr(other, f.name)[chosen]
        self.crossed[chosen, : other.crossed.shape[1]] = other.crossed[chosen]

    def make_room(self, pairs: int) -> None:
        """Have room for so many touching pairs of threads in each scenario, at least."""
        more = np.zeros((self.batch, max(pairs - self.crossed.shape[1], 0), self.crossed.shape[2]))
        self.crossed = np.concatenate([self.crossed, more], axis=1)

    def copy(self) -> State:
        """An independent copy."""
        return State(**{f.name: getattr(self, f.name).copy() for f in fields(self)})


def crossed_room(model: Model) -> int:
    """Touching pairs of threads that a state has room for at first."""
    return (len(model.arrays.crossing_threads.ends) + 3) // 4


def initial_state(
    model: Model,
    system: System,
    physics: PhysicsParameters,
    debris_position: np.ndarray,
    debris_attitude: np.ndarray,
    debris_rate: np.ndarray,
) -> State:
    """The net folded flat in front of the chaser, everything at rest but the debris' rotation.

    Args:
        model: of the system.
        system: net and chaser.
        physics: how the net is folded, and where it lies.
        debris_position: centre of mass [m], shape (B, 3).
        debris_attitude: unit quaternions x y z w, body to launch, shape (B, 4).
        debris_rate: angular rate in the body frame [rad/s], shape (B, 3).
    """
    batch = len(debris_position)
    mus, pairs = len(model.arrays.mu_knot), len(model.arrays.pairs)
    flat = system.net.nodes - system.net.nodes[system.net.center_node]
    folded = np.ascontiguousarray((flat * physics.fold_factor).T)
    folded[2] -= physics.start_distance_m
    bodies = np.zeros((batch, 2, 13))
    bodies[:, DEBRIS, POSITION] = debris_position
    bodies[:, DEBRIS, ATTITUDE] = debris_attitude
    bodies[:, DEBRIS, MOMENTUM] = rotate(
        np.asarray(debris_attitude, float), body_momentum(model.debris, np.asarray(debris_rate, float))
    )
    bodies[:, CHASER, 2] = 0.5 * system.chaser.side_m
    bodies[:, CHASER, 9] = 1.0
    return State(
        knot_pos=np.repeat(folded[None], batch, axis=0),
        knot_vel=np.zeros((batch, 3, model.numbers.knots)),
        mu_pos=np.repeat(folded[:, model.arrays.mu_knot].T[None], batch, axis=0),
        mu_vel=np.zeros((batch, mus, 3)),
        bodies=bodies,
        bristle=np.zeros((batch, model.contact_count, 3)),
        crossed=np.zeros((batch, crossed_room(model), RECORD)),
        crossed_count=np.zeros(batch, np.int64),
        closing=np.zeros(batch, bool),
        tether_length=np.full(batch, physics.start_distance_m),
        pair_length=np.zeros((batch, pairs)),
        locked=np.zeros((batch, pairs), bool),
        winch_length=np.zeros((batch, model.winch_threads)),
        contacts=np.zeros(batch, np.int64),
    )
