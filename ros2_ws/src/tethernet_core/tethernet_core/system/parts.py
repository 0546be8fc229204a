"""The parts of a described system: frozen, complete, derived numbers included.

Particles are numbered nodes first, then units: unit m (from 1) is particle ``node_count + m - 1``.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .entries import entry

if TYPE_CHECKING:
    from ..shapes import Shape


class Grid(NamedTuple):
    """A net of square meshes whose nodes are numbered row by row."""

    rows: int
    columns: int
    mesh_m: float


@dataclass(frozen=True)
class Thread:
    """What the net's threads are made of."""

    material: str
    """Name, or empty where it is given by numbers."""
    radius_m: float
    """Radius [m]."""
    modulus_pa: float
    """Young's modulus [Pa]."""
    density_kg_m3: float
    """Density [kg/m^3]."""
    damping_ratio: float
    """zeta in c = 2 zeta sqrt(k m) of each spring [-]."""
    strength_pa: float | None
    """Tensile strength [Pa], where it is known."""

    @property
    def area_m2(self) -> float:
        """Cross-section [m^2]."""
        return math.pi * self.radius_m**2

    @property
    def strength_n(self) -> float | None:
        """Tension at which it breaks [N], where the strength is known."""
        return None if self.strength_pa is None else self.strength_pa * self.area_m2

    @property
    def linear_density_kg_m(self) -> float:
        """Mass per length [kg/m]."""
        return self.density_kg_m3 * self.area_m2

    def stiffness_n_m(self, length: float) -> float:
        """k = E A / l of a spring of this length [N/m]."""
        return self.modulus_pa * self.area_m2 / length

    def damping_n_s_m(self, length: float) -> float:
        """c = 2 zeta sqrt(k m) of a spring of this length [N s/m]."""
        mass = self.density_kg_m3 * self.area_m2 * length
        return 2.0 * self.damping_ratio * math.sqrt(self.stiffness_n_m(length) * mass)


class PointMass(NamedTuple):
    """A mass at a node."""

    node: int
    mass_kg: float


@dataclass(frozen=True, eq=False)
class Net:
    """Nodes and threads. A thread here is one spring between two nodes."""

    kind: str
    """square, hexagonal, triangular, file or graph."""
    nodes: np.ndarray
    """Positions in the flat net [m], shape (N, 3): x along columns, y along rows, z 0 for nets that lie flat."""
    threads: np.ndarray
    """Nodes of each thread, shape (T, 2), int."""
    rest_lengths: np.ndarray
    """[m], shape (T,)."""
    grid: Grid | None
    """For square meshes with one spring a thread; None for any other net."""
    center_node: int
    """Node that the main tether is tied to."""
    material: Thread
    mesh_m: float
    """Length of a mesh: the given one, or the median of the threads' lengths [m]."""
    own_node_count: int
    """Nodes of the net itself; those that divide threads into springs come after them."""
    point_masses: tuple[PointMass, ...] = ()
    """Masses at nodes, besides their threads'."""

    @property
    def node_count(self) -> int:
        """N."""
        return len(self.nodes)

    @property
    def thread_count(self) -> int:
        """T."""
        return len(self.threads)

    @functools.cached_property
    def node_masses(self) -> np.ndarray:
        """Mass of each node [kg], shape (N,): half of each thread that ends there, and the masses put there."""
        half = np.repeat(0.5 * self.rest_lengths, 2)
        masses = np.bincount(self.threads.ravel(), half, self.node_count) * self.material.linear_density_kg_m
        for point in self.point_masses:
            masses[point.node] += point.mass_kg
        return frozen(masses)

    @functools.cached_property
    def thread_stiffness(self) -> np.ndarray:
        """k = E A / l of each thread [N/m], shape (T,)."""
        return frozen(self.material.modulus_pa * self.material.area_m2 / self.rest_lengths)

    @functools.cached_property
    def thread_damping(self) -> np.ndarray:
        """c = 2 zeta sqrt(k m) of each thread [N s/m], shape (T,)."""
        thread = self.material
        mass = thread.density_kg_m3 * thread.area_m2 * self.rest_lengths
        return frozen(2.0 * thread.damping_ratio * np.sqrt(self.thread_stiffness * mass))

    @property
    def mass_kg(self) -> float:
        """Mass of the net without units [kg]."""
        return float(self.node_masses.sum())


@dataclass(frozen=True)
class Unit:
    """A maneuverable unit."""

    node: int
    """Node that it hangs on."""
    thread_length_m: float
    """Length of the thread between node and unit [m]."""
    thread_stiffness_n_m: float
    """[N/m]."""
    thread_damping_n_s_m: float
    """[N s/m]."""
    mass_kg: float
    """With full tanks [kg]."""
    box_m: tuple[float, ...]
    """Sides of its box [m], shape (3,)."""
    radius_m: float
    """Contact radius of the unit taken as a ball [m]."""
    thrust_limit_n: float
    """Largest thrust along each axis [N]."""
    specific_impulse_s: float
    """[s]."""
    propellant_kg: float
    """[kg]."""

    @property
    def inertia_kg_m2(self) -> tuple[float, float, float]:
        """Principal moments of a homogeneous box of its mass [kg m^2]."""
        a, b, c = (side * side for side in self.box_m)
        twelfth = self.mass_kg / 12.0
        return twelfth * (b + c), twelfth * (a + c), twelfth * (a + b)


@dataclass(frozen=True, eq=False)
class Closing:
    """How the mouth is closed."""

    kind: str
    """docking, winch or none."""
    ring: tuple[int, ...] = ()
    """Particles in their order round the mouth; neighbours lock."""
    docking_distance_m: float = 0.0
    """Neighbours nearer than this lock [m]."""
    draw_in_m_s: float = 0.0
    """docking: a docked pair is drawn together so fast [m/s]."""
    pull_n: float = 0.0
    """docking: largest force of the motor that draws a pair together [N]."""
    winch_speed_m_s: float = 0.0
    """winch: each winch takes its threads in so fast [m/s]."""
    winch_tension_n: float = 0.0
    """winch: largest tension of a closing thread [N]."""
    winch_stiffness_n_m: float = 0.0
    """winch: stiffness of a closing thread [N/m]."""
    winches: tuple[int, ...] = ()
    """winch: nodes of the ring with a winch, in the ring's order, the first one where the ring begins."""

    @property
    def max_locked_pairs(self) -> int:
        """N_L,max: neighbours that can lock."""
        return len(self.ring)

    @functools.cached_property
    def pairs(self) -> np.ndarray:
        """Neighbours in the ring, shape (R, 2), particle numbers, in their order round the mouth."""
        ring = np.array(self.ring, np.int64)
        return frozen(np.stack([ring, np.roll(ring, -1)], axis=1))

    @functools.cached_property
    def winch_thread_of_pair(self) -> np.ndarray:
        """Which closing thread each pair is part of, shape (R,), int: one thread from each winch to the next."""
        starts = np.isin(self.ring, self.winches)
        return frozen(np.cumsum(starts, dtype=np.int64) - 1)

    @property
    def winch_thread_count(self) -> int:
        """Closing threads, one from each winch to the next; 0 where units dock."""
        return len(self.winches)


@dataclass(frozen=True, eq=False)
class Launch:
    """How the net gets out."""

    kind: str
    """flown (the units pull it out) or ejected."""
    particles: tuple[int, ...]
    """Particles that are ejected, K of them."""
    velocities: np.ndarray
    """Their velocities at launch [m/s], shape (K, 3), frame launch: the net flies along -z."""


@dataclass(frozen=True, eq=False)
class Debris:
    """What is captured: a rigid body."""

    shape: Shape
    """Its shape, in a frame with the body's axes; the body's frame has its origin at the centre of mass instead."""
    center_of_mass: np.ndarray
    """In the shape's frame [m], shape (3,)."""
    mass_kg: float
    """[kg]."""
    inertia: np.ndarray
    """About the centre of mass, axes of the shape [kg m^2], shape (3, 3)."""
    given_volume_m3: float | None = None
    """V_D where the description gives it [m^3]."""
    given_area_m2: float | None = None
    """S_D where the description gives it [m^2]."""
    given_length_m: float | None = None
    """L_c where the description gives it [m]."""

    # Compounds and meshes integrate theirs or build a grid, which takes longer than all the rest of a description: only
    # processes that need these numbers wait for them.
    @functools.cached_property
    def cqi_volume_m3(self) -> float:
        """V_D of the Capture Quality Index [m^3]: as given, or the shape's volume."""
        return float(self.shape.volume_m3) if self.given_volume_m3 is None else self.given_volume_m3

    @functools.cached_property
    def cqi_area_m2(self) -> float:
        """S_D of the Capture Quality Index [m^2]: as given, or the area of the shape's surface."""
        return float(self.shape.area_m2) if self.given_area_m2 is None else self.given_area_m2

    @functools.cached_property
    def cqi_length_m(self) -> float:
        """L_c of the Capture Quality Index [m]: as given, or from the shape's centroid to the nearest surface, which is
        the radius of a cylinder, as in the paper; where the centroid lies outside, the radius of a ball of its volume.
        """
        if self.given_length_m is not None:
            return self.given_length_m
        depth = -float(self.shape.distance(self.shape.centroid)[0])
        return depth if depth > 0.0 else float((0.75 * self.shape.volume_m3 / math.pi) ** (1.0 / 3.0))


@dataclass(frozen=True)
class Chaser:
    """What launches the net: a homogeneous cube."""

    mass_kg: float = entry("Mass", unit="kg", low=0.1, high=1e7)
    side_m: float = entry("Side of its cube", unit="m", low=0.01, high=100.0)

    @property
    def inertia_kg_m2(self) -> float:
        """About any axis through its centre [kg m^2]."""
        return self.mass_kg * self.side_m**2 / 6.0

    @property
    def anchor_m(self) -> float:
        """z of the launch point in the chaser's body frame [m]."""
        return -0.5 * self.side_m


@dataclass(frozen=True)
class Tether:
    """The main tether between chaser and net; it runs out freely and is locked when closing begins."""

    stiffness_n_m: float = entry("Stiffness, locked", unit="N/m", low=0.0, high=1e5)
    damping_n_s_m: float = entry("Damping, locked", unit="N s/m", low=0.0, high=100.0)
    strength_n: float | None = entry(
        "Tension at which it breaks", unit="N", low=1e-3, high=1e7, default=None,
        default_text="that of a thread of the net [A: the weaker part decides]",
    )  # fmt: skip


@dataclass(frozen=True)
class Capture:
    """What counts as captured."""

    required_locked_pairs: int
    """N_D: locked pairs that are needed."""
    cqi_threshold: float
    """The settled CQI that decides must be below."""
    center_of_mass: str
    """Whose centre of mass the deciding CQI is computed with: knots or all."""


@dataclass(frozen=True, eq=False)
class Aiming:
    """Nominal aiming points."""

    offsets: np.ndarray
    """Relative to the debris' centre of mass, x and y [m], shape (M, 2)."""


def frozen(array: np.ndarray) -> np.ndarray:
    """The same array, not to be written to any more: descriptions are shared."""
    array.flags.writeable = False
    return array
