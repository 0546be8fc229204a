"""The constant part of a simulation: masses, springs, geometry, as arrays that the compiled kernels take.

The debris is compiled when a whole model is built, not before: what looks at the net alone needs no compiler.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tethernet_core.system import System
from tethernet_sim.crossing_threads import GRIP_SHARE, crossing_threads
from tethernet_sim.kernels.crossing_kinds import Crossings, no_crossings
from tethernet_sim.settings import THREADS, PhysicsParameters
from tethernet_sim.touching_threads import TouchingThreads, touching_threads

if TYPE_CHECKING:
    from tethernet_sim.kernels.debris_body import Body


class Numbers(NamedTuple):
    """The scalar constants. Apart from the arrays, because numba counts references of every array at every call."""

    knots: int  # nodes of the net, N
    center_node: int  # node that the main tether hangs on; -1 where there is no tether
    time_step: float  # [s]
    chaser_mass: float  # [kg]
    chaser_inertia: float  # of a homogeneous cube, about any axis [kg m^2]
    chaser_half_side: float  # of its cube [m]
    tether_anchor: float  # z of the launch point in the chaser's body frame [m]
    tether_stiffness: float  # [N/m]
    tether_damping: float  # [N s/m]
    contact_stiffness: float  # of a knot [N/m]
    mu_contact_share: float  # a MU's is so many times as stiff
    friction: float  # [-]
    knot_radius: float  # [m]
    mu_radius: float  # of the largest [m]
    contact_damping_ratio: float  # [-]
    open_segments: int  # threads that touch while the net is open: all but those of winches
    half_longest: float  # half the length of the longest thread that touches, stretched as far as any is [m]
    winch_speed: float  # at which the thread of one side is taken in, from both its ends [m/s]
    winch_tension: float  # [N]
    winch_stiffness: float  # [N/m]
    joint_stiffness: float  # [N/m]
    joint_draw_in: float  # [m/s]; 0 where knots are locked
    joint_pull: float  # largest force of the motor that draws a joint in [N]
    docking_distance: float  # [m]
    crossing_distance: float  # at which threads of the net touch each other [m]
    crossing_stiffness: float  # of their contact [N/m]
    crossing_viscosity: float  # its damping by its stiffness, and that of its friction [s]
    crossing_grip: float  # stiffness of its friction [N/m]


class Arrays(NamedTuple):
    """The constant arrays. Particles are the net's N nodes (knots), then the M MUs."""

    knot_mass: np.ndarray  # (N,) half of each thread that ends there, and what is fixed to it [kg]
    kick: np.ndarray  # (N,) velocity per force in one step: time step / mass [s/kg]
    threads: np.ndarray  # (T, 2) nodes at the ends of each thread
    rest: np.ndarray  # (T,) rest length of each thread [m]
    stiffness: np.ndarray  # (T,) of each thread [N/m]
    damping: np.ndarray  # (T,) of each thread [N s/m]
    mu_mass: np.ndarray  # (M,) [kg]
    mu_inverse_mass: np.ndarray  # (M,) [1/kg]
    mu_radius: np.ndarray  # (M,) of the sphere that it touches as [m]
    meeting: np.ndarray  # (P, 2) pairs of MUs that push each other where they touch: all but those that dock
    mu_knot: np.ndarray  # (M,) knot that MU m hangs on
    mu_thread: np.ndarray  # (M,) rest length of its thread [m]
    mu_stiffness: np.ndarray  # (M,) of its thread [N/m]
    mu_damping: np.ndarray  # (M,) of its thread [N s/m]
    coupling_stiffness: np.ndarray  # (M,) of an external MU's stand-in [N/m]
    coupling_damping: np.ndarray  # (M,) [N s/m]
    pairs: np.ndarray  # (R, 2) closing pairs: particles, in their order round the mouth
    pair_winch: np.ndarray  # (R,) winch's thread that each pair is part of, in order; -1, first, where it docks
    winch_begin: np.ndarray  # (S + 1,) first pair of each winch's thread, and the end of the last thread
    joint_damping: np.ndarray  # (R,) of each pair's joint [N s/m]
    contact_damping: np.ndarray  # (N + M,) of each particle's contact [N s/m]
    segments: np.ndarray  # (S, 2) ends of all threads that touch, those of winches last; none: only knots do
    segment_radius: np.ndarray  # (S,) [m]
    segment_stiffness: np.ndarray  # (S,) of its contact [N/m]
    inverse_mass: np.ndarray  # (N + M,) of each particle [1/kg]
    crossing_threads: Crossings  # threads of the net that touch each other


class NetModel(NamedTuple):
    """The model without its debris, by the same names."""

    numbers: Numbers
    arrays: Arrays


class Model(NamedTuple):
    """Everything that does not change while a scenario is flown; in parts, because compiled code takes them apart."""

    numbers: Numbers
    arrays: Arrays
    debris: Body
    """The debris, see :func:`~tethernet_sim.debris.debris_body`."""
    grid: tuple[int, int] | None
    """Rows and columns of a rectangular net whose nodes are numbered row by row; None for any other."""

    @property
    def contact_count(self) -> int:
        """Contacts that there may be: of particles, and of two points of each thread on each part of the debris."""
        from tethernet_sim.kernels.general_body import GeneralBody

        parts = len(self.debris.span_of) if isinstance(self.debris, GeneralBody) else 1
        return len(self.arrays.inverse_mass) + 2 * parts * len(self.arrays.segments)

    @property
    def winch_threads(self) -> int:
        """Closing threads between winches, S; 0 where MUs dock."""
        return len(self.arrays.winch_begin) - 1


def grid_threads(rows: int, columns: int) -> np.ndarray:
    """Ends of the threads of a rectangular net, those along rows first, shape (T, 2)."""
    index = np.arange(rows * columns).reshape(rows, columns)
    along_rows = np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], axis=1)
    along_columns = np.stack([index[:-1].ravel(), index[1:].ravel()], axis=1)
    return np.concatenate([along_rows, along_columns])


def build_model(system: System, physics: PhysicsParameters) -> Model:
    """Derive the model of a described system.

    Args:
        system: the hardware.
        physics: time step, contact, joints and the coupling of external MUs.
    """
    from tethernet_sim.debris import debris_body

    grid, debris = system.net.grid, system.debris
    body = debris_body(debris.shape, debris.mass_kg, debris.inertia, debris.center_of_mass)
    return Model(*build_net_model(system, physics), body, None if grid is None else (grid.rows, grid.columns))


def build_net_model(system: System, physics: PhysicsParameters) -> NetModel:
    """Derive the model of all but the debris; as :func:`build_model`."""
    net, closing = system.net, system.closing
    units, time_step = system.units, physics.time_step_s
    mu = np.array([unit.mass_kg for unit in units])
    masses = np.concatenate([net.node_masses, mu])
    docks = closing.kind == "docking"
    pairs = np.array(closing.pairs, np.int64).reshape(-1, 2) if closing.kind != "none" else np.zeros((0, 2), np.int64)
    first, second = masses[pairs[:, 0]], masses[pairs[:, 1]]
    winches = closing.winch_thread_count
    pair_winch = np.array(closing.winch_thread_of_pair) if winches else np.full(len(pairs), -1)
    segments = touching_threads(system) if physics.contact == THREADS else TouchingThreads.none()
    of_knot = (
        physics.contact_stiffness_n_m * segments.knot_share,
        physics.contact_damping_ratio * segments.damping_share,
    )
    numbers = Numbers(
        knots=net.node_count,
        center_node=net.center_node if system.tether.stiffness_n_m > 0.0 else -1,
        time_step=time_step,
        chaser_mass=system.chaser.mass_kg,
        chaser_inertia=system.chaser.inertia_kg_m2,
        chaser_half_side=0.5 * system.chaser.side_m,
        tether_anchor=system.chaser.anchor_m,
        tether_stiffness=system.tether.stiffness_n_m,
        tether_damping=system.tether.damping_n_s_m,
        contact_stiffness=of_knot[0],
        mu_contact_share=1.0 / segments.knot_share,
        friction=physics.friction_coefficient,
        knot_radius=physics.knot_radius_m,
        mu_radius=max((unit.radius_m for unit in units), default=0.0),
        contact_damping_ratio=of_knot[1],
        open_segments=segments.open_count,
        half_longest=0.5 * segments.longest_m,
        winch_speed=2.0 * closing.winch_speed_m_s,
        winch_tension=closing.winch_tension_n,
        winch_stiffness=closing.winch_stiffness_n_m if winches else 1.0,
        joint_stiffness=physics.joint_stiffness_n_m,
        joint_draw_in=closing.draw_in_m_s if docks else 0.0,
        joint_pull=closing.pull_n if docks else 0.0,
        docking_distance=closing.docking_distance_m,
        crossing_distance=physics.net_contact_distance_m,
        crossing_stiffness=physics.net_contact_stiffness_n_m,
        crossing_viscosity=float((net.thread_damping / net.thread_stiffness).min(initial=np.inf)),
        crossing_grip=GRIP_SHARE * physics.net_contact_stiffness_n_m if physics.friction_coefficient else 0.0,
    )
    # Copies, because a description's arrays cannot be written to, for which the kernels would be compiled once more.
    arrays = Arrays(
        knot_mass=net.node_masses.copy(),
        kick=time_step / net.node_masses,
        threads=np.array(net.threads, np.int64),
        rest=net.rest_lengths.copy(),
        stiffness=net.thread_stiffness.copy(),
        damping=net.thread_damping.copy(),
        mu_mass=mu,
        mu_inverse_mass=1.0 / mu,
        mu_radius=np.array([unit.radius_m for unit in units]),
        meeting=_meeting_units(len(units), pairs - net.node_count if docks else pairs[:0]),
        mu_knot=np.array([unit.node for unit in units], np.int64),
        mu_thread=np.array([unit.thread_length_m for unit in units]),
        mu_stiffness=np.array([unit.thread_stiffness_n_m for unit in units]),
        mu_damping=np.array([unit.thread_damping_n_s_m for unit in units]),
        coupling_stiffness=mu * physics.external_coupling_rad_s**2,
        coupling_damping=2.0 * mu * physics.external_coupling_rad_s,
        pairs=pairs,
        pair_winch=pair_winch,
        winch_begin=np.searchsorted(pair_winch, np.arange(winches + 1)) if winches else np.zeros(1, np.int64),
        joint_damping=physics.joint_damping_ratio
        * _critical(physics.joint_stiffness_n_m, first * second / (first + second)),
        contact_damping=np.concatenate(
            [
                of_knot[1] * _critical(of_knot[0], net.node_masses),
                physics.contact_damping_ratio * _critical(physics.contact_stiffness_n_m, mu),
            ]
        ),
        segments=segments.ends,
        segment_radius=np.full(len(segments.ends), net.material.radius_m),
        segment_stiffness=physics.contact_stiffness_n_m * segments.share,
        inverse_mass=1.0 / masses,
        crossing_threads=crossing_threads(system) if physics.net_contact == THREADS else no_crossings(),
    )
    return NetModel(numbers, arrays)


def _meeting_units(count: int, docking: np.ndarray) -> np.ndarray:
    """Pairs of ``count`` units (P, 2), but those that dock with each other (R, 2)."""
    apart = np.ones((count, count), bool)
    apart[docking[:, 0], docking[:, 1]] = apart[docking[:, 1], docking[:, 0]] = False
    return np.argwhere(np.triu(apart, 1))


def _critical(stiffness: float, mass: np.ndarray) -> np.ndarray:
    """Critical damping of a mass on a spring [N s/m]; of each, for an array of masses [kg]."""
    return 2.0 * np.sqrt(stiffness * mass)
