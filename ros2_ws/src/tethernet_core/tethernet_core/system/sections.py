"""The sections of a description: every entry with its type, unit, range and meaning.

The README's table of entries is made from these classes (``describe_entries``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .entries import entry

MOST_UNITS = 24
MOST_NODES = 10_000

NODE_FORM = (
    "a node number, {row, column} or {corner} or {side} of the net, {near: [x, y]} in the flat net [m], or center"
)
"""How a node may be addressed."""


@dataclass(frozen=True)
class DescriptionSection:
    """The file as a whole."""

    net: Any = entry("Nodes and threads", form="a mapping: net")
    closing: Any = entry("How the mouth closes", form="none, {docking: ...} or {winch: ...}")
    debris: Any = entry("What is captured", form="a mapping: debris")
    chaser: Any = entry("What launches the net", form="a mapping: chaser")
    tether: Any = entry("The main tether between chaser and net", form="a mapping: tether")
    name: str = entry("Name of the system", default="", default_text="the file's name")
    description: str = entry("What it is, in a sentence or two", default="")
    based_on: str = entry("Shipped name or file of the description that this one changes", default="")
    unit: Any = entry(
        "What all units have in common: entries of units[i], which may differ", form="a mapping: unit", default=None
    )
    units: Any = entry(
        f"Maneuverable units, numbered from 1 in this order, at most {MOST_UNITS}", form="a list", default=()
    )
    launch: Any = entry("How the net gets out", form="flown or {ejected: ...}", default="flown")
    capture: Any = entry("What counts as captured", form="a mapping: capture", default=None)
    aiming: Any = entry("Nominal aiming points", form="a mapping: aiming", default=None)
    parameters: Any = entry(
        "Parameters that this system is flown with unless others are given, by subsystem; not part of the digest",
        form="{control, mission, physics, scenario: {NAME: VALUE}}",
        default=None,
    )


@dataclass(frozen=True)
class NetSection:
    """Entries of ``net``; exactly one of square, hexagonal, triangular, file and graph."""

    thread: Any = entry("What its threads are made of", form="a mapping: net.thread")
    square: Any = entry("Square meshes, rows x columns", form="a mapping: net.square", default=None)
    hexagonal: Any = entry("Six-sided net of a triangular lattice", form="a mapping: net.hexagonal", default=None)
    triangular: Any = entry("Three-sided net of a triangular lattice", form="a mapping: net.triangular", default=None)
    file: Any = entry("Nodes and threads from files", form="a mapping: net.file", default=None)
    graph: Any = entry("Nodes and threads written here as CSV", form="a mapping: net.graph", default=None)
    springs_per_thread: int = entry(
        "Springs in a row that each thread is modelled by; the nodes between them come after the net's own",
        low=1,
        high=50,
        default=1,
    )
    center: Any = entry(
        "Node that the main tether is tied to", form=NODE_FORM, default=None, default_text="nearest to the net's middle"
    )
    masses: Any = entry(
        "Masses at nodes, besides their threads': those of a net that is ejected, for instance", form="a list",
        default=(),
    )  # fmt: skip


@dataclass(frozen=True)
class SquareSection:
    """Entries of ``net.square``. Nodes are numbered row by row; rows run along y, columns along x."""

    rows: int = entry("Rows of nodes", low=2, high=MOST_NODES)
    columns: int = entry("Columns of nodes", low=2, high=MOST_NODES)
    mesh_m: float = entry("Length of a thread between two nodes", unit="m", low=0.005, high=10.0)


@dataclass(frozen=True)
class LatticeSection:
    """Entries of ``net.hexagonal`` and ``net.triangular``. Nodes are numbered from the centre, ring by ring,
    counter-clockwise from corner 0.
    """

    rings: int = entry("Rings of nodes round the central one", low=1, high=1000)
    spacing_m: float = entry("Length of a thread between two nodes", unit="m", low=0.005, high=10.0)
    inner_rings: bool = entry(
        "Whether threads run along the inner rings too, or only between rings and along the rim", default=True
    )


@dataclass(frozen=True)
class FileSection:
    """Entries of ``net.file``: either ``path`` of an npz with arrays nodes (N, 3) or (N, 2) [m], threads (T, 2) and, if
    wanted, rest_lengths (T,) [m], or two CSV files. Paths are relative to the description.
    """

    path: str = entry("npz file", default="")
    nodes: str = entry("CSV file: x, y and, if wanted, z of each node, flat net [m]", default="")
    threads: str = entry("CSV file: both nodes of each thread and, if wanted, its rest length [m]", default="")


@dataclass(frozen=True)
class GraphSection:
    """Entries of ``net.graph``: the two CSV tables of ``net.file``, as text."""

    nodes: str = entry("CSV: x, y and, if wanted, z of each node, flat net [m]")
    threads: str = entry("CSV: both nodes of each thread and, if wanted, its rest length [m]")


@dataclass(frozen=True)
class ThreadSection:
    """Entries of ``net.thread``; numbers that are given replace those of the material."""

    radius_m: float = entry("Radius of a thread", unit="m", low=1e-5, high=0.05)
    material: str = entry(
        "Material by name", form="technora, kevlar or dyneema", default="", default_text="given by numbers"
    )
    modulus_pa: float | None = entry(
        "Young's modulus", unit="Pa", low=1e4, high=1e12, default=None, default_text="of the material"
    )
    density_kg_m3: float | None = entry(
        "Density", unit="kg/m^3", low=1.0, high=2e4, default=None, default_text="of the material"
    )
    strength_pa: float | None = entry(
        "Tensile strength", unit="Pa", low=1e3, high=1e11, default=None, default_text="of the material"
    )
    damping_ratio: float = entry(
        "zeta in c = 2 zeta sqrt(k m) of each spring [A: usual in this literature]", low=0.0, high=1.0, default=0.106
    )


@dataclass(frozen=True)
class MassSection:
    """Entries of ``net.masses[i]``."""

    node: Any = entry("Node that it is at", form=NODE_FORM)
    mass_kg: float = entry("Mass, besides that of the node's threads", unit="kg", low=1e-6, high=1e4)


@dataclass(frozen=True)
class UnitSection:
    """Entries of ``units[i]``, and of ``unit`` for all of them."""

    node: Any = entry("Node that it hangs on", form=NODE_FORM)
    thread_length_m: float = entry("Length of the thread between node and unit", unit="m", low=0.01, high=100.0)
    mass_kg: float = entry("Mass with full tanks", unit="kg", low=0.01, high=1e4)
    box_m: tuple[float, ...] = entry("Sides of its box", unit="m", low=0.001, high=10.0, size=3)
    thrust_limit_n: float = entry("Largest thrust along each axis", unit="N", low=0.0, high=1e4)
    specific_impulse_s: float = entry("Specific impulse", unit="s", low=1.0, high=1e4)
    propellant_kg: float = entry("Propellant", unit="kg", low=0.0, high=1e4)
    radius_m: float | None = entry(
        "Contact radius of the unit taken as a ball", unit="m", low=0.0, high=10.0, default=None,
        default_text="half the longest side of the box",
    )  # fmt: skip
    stiffness_length: str = entry(
        "Length that its thread's stiffness E A / length is of: of the thread itself or of a mesh of the net",
        choices=("thread", "mesh"),
        default="thread",
    )


@dataclass(frozen=True)
class DockingSection:
    """Entries of ``closing.docking``: neighbours among the units dock."""

    docking_distance_m: float = entry("Neighbours nearer than this dock", unit="m", low=0.01, high=5.0)
    draw_in_m_s: float = entry(
        "A docked pair is drawn together so fast, to length 0; 0: it stays", unit="m/s", low=0.0, high=10.0
    )
    pull_n: float = entry(
        "The motor that draws a docked pair together pulls no harder; where that is not enough, it holds",
        unit="N", low=0.0, high=500.0,
    )  # fmt: skip
    ring: Any = entry(
        "Units in their order round the mouth", form="a list of unit numbers, from 1", default=None,
        default_text="as they hang round the net",
    )  # fmt: skip


@dataclass(frozen=True)
class WinchSection:
    """Entries of ``closing.winch``: winches draw threads round the mouth in, and neighbouring nodes lock."""

    docking_distance_m: float = entry("Neighbours nearer than this lock", unit="m", low=0.005, high=5.0)
    ring: Any = entry(
        "Nodes of the closing thread in their order round the mouth", form="a list of nodes, or {perimeter: COUNT}"
    )
    speed_m_s: float = entry(
        "Each winch takes its threads in so fast, as long as they pull less than it can; 0: it holds them",
        unit="m/s", low=0.0, high=10.0,
    )  # fmt: skip
    tension_n: float = entry(
        "Largest tension of a closing thread; at more the winch slips", unit="N", low=0.0, high=500.0
    )
    stiffness_n_m: float | None = entry(
        "Stiffness of the closing thread between two winches", unit="N/m", low=1.0, high=2e4, default=None,
        default_text="E A / length of the net's thread",
    )  # fmt: skip
    winches: Any = entry(
        "Nodes of the ring that have a winch", form="a list of nodes", default=None,
        default_text="those of the ring that bear a unit or a mass",
    )  # fmt: skip


@dataclass(frozen=True)
class EjectedSection:
    """Entries of ``launch.ejected``: speed_m_s and opening_angle_deg for all bodies, or a velocity for each."""

    bodies: Any = entry(
        "Nodes that are ejected",
        form="a list of nodes",
        default=None,
        default_text="those of net.masses; else all units",
    )
    speed_m_s: float | None = entry("Speed of each", unit="m/s", low=1e-3, high=200.0, default=None)
    opening_angle_deg: float | None = entry(
        "Between the direction of flight and each velocity, outwards", unit="deg", low=0.0, high=89.0, default=None
    )
    velocities_m_s: Any = entry(
        "Velocity of each, frame launch: the net flies along -z", form="a list of [x, y, z] in m/s, one for each body",
        default=None,
    )  # fmt: skip


@dataclass(frozen=True)
class DebrisSection:
    """Entries of ``debris``."""

    shape: Any = entry("Its shape", form="{kind: ..., and the dimensions of that kind}")
    mass_kg: float = entry("Mass", unit="kg", low=1e-3, high=1e7)
    center_of_mass_m: tuple[float, ...] | None = entry(
        "Centre of mass in the shape's frame", unit="m", low=-1e3, high=1e3, size=3, default=None,
        default_text="the shape's centroid",
    )  # fmt: skip
    inertia_kg_m2: Any = entry(
        "Inertia about its centre of mass, body axes",
        form="three principal moments or a symmetric 3 x 3 matrix, in kg m^2",
        default=None,
        default_text="of a homogeneous body (with center_of_mass_m: must be given)",
    )
    cqi: Any = entry(
        "What the Capture Quality Index takes for it", form="a mapping: debris.cqi", default=None,
        default_text="the shape's own numbers",
    )  # fmt: skip


@dataclass(frozen=True)
class QualitySection:
    """Entries of ``debris.cqi``."""

    volume_m3: float | None = entry(
        "V_D", unit="m^3", low=1e-6, high=1e6, default=None, default_text="the shape's volume"
    )
    area_m2: float | None = entry("S_D", unit="m^2", low=1e-6, high=1e6, default=None, default_text="the shape's area")
    length_m: float | None = entry(
        "L_c",
        unit="m",
        low=1e-3,
        high=1e3,
        default=None,
        default_text="from its centroid to the nearest surface; where it lies outside, radius of a ball of its volume",
    )


@dataclass(frozen=True)
class CaptureSection:
    """Entries of ``capture``."""

    required_locked_pairs: int | None = entry(
        "N_D: locked pairs that count as captured", low=0, high=1000, default=None,
        default_text="docking: all but 2; winch: two thirds of all; none: 0",
    )  # fmt: skip
    cqi_threshold: float = entry("Captured when the settled CQI is below", low=0.0, high=100.0, default=2.5)
    center_of_mass: str = entry(
        "Whose centre of mass the CQI that decides is computed with: the knots alone, or all, units counted",
        choices=("knots", "all"),
        default="knots",
    )


@dataclass(frozen=True)
class AimingSection:
    """Entries of ``aiming``."""

    offsets_m: Any = entry(
        "Nominal aiming point of each unit relative to the debris' centre of mass, x and y", unit="m",
        form="a list of [x, y] in m, one for each unit", default=None,
        default_text="where each unit is beside the flat net",
    )  # fmt: skip
