"""The constant part of a simulation: masses, springs, geometry, as arrays that the compiled kernels take."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tethernet_control.layout import KNOT_ROWS, design
from tethernet_control.settings import MissionParameters

from .settings import PhysicsParameters

KNOTS = KNOT_ROWS * KNOT_ROWS
CENTRAL_KNOT = KNOTS // 2
CLOSING_NODES_PER_SIDE = (0, 7, 15)
"""Closing nodes of the 4-MU design on each side, counted from one corner; the next corner starts the next side [A; 12
is P].
"""


class Numbers(NamedTuple):
    """The scalar constants. Apart from the arrays, because numba counts references of every array at every call."""

    time_step: float  # [s]
    mesh: float  # rest length of a thread between knots [m]
    stiffness: float  # of every thread, MU threads included [N/m]
    damping: float  # of every thread [N s/m]
    mu_mass: float  # [kg]
    debris_mass: float  # [kg]
    debris_across: float  # moment of inertia across the cylinder's axis [kg m^2]
    debris_along: float  # along it [kg m^2]
    debris_radius: float  # [m]
    debris_half_length: float  # [m]
    chaser_mass: float  # [kg]
    chaser_inertia: float  # of a homogeneous cube, about any axis [kg m^2]
    tether_anchor: float  # z of the launch point in the chaser's body frame [m]
    tether_stiffness: float  # [N/m]
    tether_damping: float  # [N s/m]
    contact_stiffness: float  # [N/m]
    knot_contact_damping: float  # [N s/m]
    mu_contact_damping: float  # [N s/m]
    friction: float  # [-]
    knot_radius: float  # [m]
    mu_radius: float  # [m]
    winch_speed: float  # [m/s]; 0 where the MUs dock
    winch_tension: float  # [N]
    winch_stiffness: float  # [N/m]
    winch_damping: float  # [N s/m]
    joint_stiffness: float  # [N/m]
    joint_damping: float  # [N s/m]
    joint_draw_in: float  # [m/s]
    docking_distance: float  # [m]
    coupling_stiffness: float  # of an external MU's stand-in [N/m]
    coupling_damping: float  # [N s/m]


class Arrays(NamedTuple):
    """The constant arrays. Particles are knots, row by row, then MUs."""

    knot_mass: np.ndarray  # (529,) half of each thread that ends there [kg]
    kick: np.ndarray  # (529,) velocity per force in one step: time step / mass [s/kg]
    mu_knot: np.ndarray  # (M,) knot that MU m hangs on
    mu_thread: np.ndarray  # (M,) rest length of its thread [m]
    pairs: np.ndarray  # (R, 2) closing pairs: particles


class Model(NamedTuple):
    """Everything that does not change while a scenario is flown; two parts, because compiled code takes them apart."""

    numbers: Numbers
    arrays: Arrays


def closing_nodes() -> list[int]:
    """The 12 closing nodes of the 4-MU design in their order round the mouth, as knot numbers."""
    last = KNOT_ROWS - 1
    nodes = []
    nodes += CLOSING_NODES_PER_SIDE
    nodes += [row * KNOT_ROWS + last for row in CLOSING_NODES_PER_SIDE]
    nodes += [last * KNOT_ROWS + (last - column) for column in CLOSING_NODES_PER_SIDE]
    nodes += [(last - row) * KNOT_ROWS for row in CLOSING_NODES_PER_SIDE]
    return nodes


def knot_masses(physics: PhysicsParameters) -> np.ndarray:
    """Mass of each knot [kg], shape (529,): half of each thread that ends there."""
    ends = np.zeros((KNOT_ROWS, KNOT_ROWS))
    ends[:, :-1] += 0.5
    ends[:, 1:] += 0.5
    ends[:-1] += 0.5
    ends[1:] += 0.5
    return (ends * physics.thread_mass_kg).ravel()


def build_model(mu_count: int, physics: PhysicsParameters, mission: MissionParameters) -> Model:
    """Derive the model of one design.

    Args:
        mu_count: 4 or 8.
        physics: numbers of the bodies.
        mission: gives the docking distance.

    Raises:
        ValueError: for an unknown design.
    """
    layout = design(mu_count)
    mass = knot_masses(physics)
    knot, mu = float(mass.max()), physics.mu_mass_kg
    if layout.closes_by_docking:
        ring = [KNOTS + mu_number - 1 for mu_number in layout.closing_ring]
    else:
        ring = closing_nodes()
    joined = 0.5 * (mu if layout.closes_by_docking else knot)  # reduced mass of a pair
    numbers = Numbers(
        time_step=physics.time_step_s,
        mesh=physics.mesh_m,
        stiffness=physics.thread_stiffness_n_m,
        damping=physics.thread_damping_n_s_m,
        mu_mass=mu,
        debris_mass=physics.debris_mass_kg,
        debris_across=physics.debris_mass_kg * (3.0 * physics.debris_radius_m**2 + physics.debris_length_m**2) / 12.0,
        debris_along=0.5 * physics.debris_mass_kg * physics.debris_radius_m**2,
        debris_radius=physics.debris_radius_m,
        debris_half_length=0.5 * physics.debris_length_m,
        chaser_mass=physics.chaser_mass_kg,
        chaser_inertia=physics.chaser_mass_kg * physics.chaser_side_m**2 / 6.0,
        tether_anchor=-0.5 * physics.chaser_side_m,
        tether_stiffness=physics.tether_stiffness_n_m,
        tether_damping=physics.tether_damping_n_s_m,
        contact_stiffness=physics.contact_stiffness_n_m,
        knot_contact_damping=physics.contact_damping_ratio * _critical(physics.contact_stiffness_n_m, knot),
        mu_contact_damping=physics.contact_damping_ratio * _critical(physics.contact_stiffness_n_m, mu),
        friction=physics.friction_coefficient,
        knot_radius=physics.knot_radius_m,
        mu_radius=physics.mu_radius_m,
        winch_speed=0.0 if layout.closes_by_docking else physics.winch_speed_m_s,
        winch_tension=physics.winch_tension_n,
        winch_stiffness=physics.winch_stiffness_n_m,
        winch_damping=_critical(physics.winch_stiffness_n_m, 0.5 * knot),
        joint_stiffness=physics.joint_stiffness_n_m,
        joint_damping=_critical(physics.joint_stiffness_n_m, joined),
        joint_draw_in=physics.joint_draw_in_m_s,
        docking_distance=mission.docking_distance_m,
        coupling_stiffness=mu * physics.external_coupling_rad_s**2,
        coupling_damping=2.0 * mu * physics.external_coupling_rad_s,
    )
    arrays = Arrays(
        knot_mass=mass,
        kick=physics.time_step_s / mass,
        mu_knot=np.array([row * KNOT_ROWS + column for row, column in layout.knots]),
        mu_thread=np.array(layout.thread_lengths),
        pairs=np.array(list(zip(ring, ring[1:] + ring[:1], strict=True))),
    )
    return Model(numbers, arrays)


def _critical(stiffness: float, mass: float) -> float:
    """Critical damping of a mass on a spring [N s/m]."""
    return 2.0 * float(np.sqrt(stiffness * mass))
