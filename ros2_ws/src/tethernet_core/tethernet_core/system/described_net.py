"""The net of a description, built and checked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..near_match import near_match
from .addresses import middle_node, node_number
from .entries import read_section
from .errors import Place
from .geometry import pieces
from .lattices import FlatNet, divided, lattice_net, node_total, square_net
from .materials import MATERIALS
from .net_file import net_from_file, net_from_graph
from .parts import Grid, Net, PointMass, Thread, frozen
from .sections import (
    MOST_NODES,
    FileSection,
    GraphSection,
    LatticeSection,
    MassSection,
    NetSection,
    SquareSection,
    ThreadSection,
)

NET_KINDS = ("square", "hexagonal", "triangular", "file", "graph")
_BYTES_PER_NODE = 1024
"""State, constants and work space of a simulation, per node and scenario: about this."""


def build_net(content: Any, folder: Path, place: Place) -> tuple[Net, FlatNet]:
    """Build the net of a description.

    Args:
        content: the section ``net``.
        folder: where files that it names are, if their names are relative.
        place: for errors.

    Returns:
        The net, and its own nodes, by which a description addresses them.

    Raises:
        DescriptionError: for a net that is too large, in pieces, or wrong in any other way.
    """
    section = read_section(NetSection, content, place)
    kind, flat = _flat_net(section, folder, place)
    thread = build_thread(section.thread, place / "thread")
    threads = len(flat.threads)
    total = len(flat.nodes) + threads * (section.springs_per_thread - 1)
    _check_size(total, place, f"{len(flat.nodes)} nodes and {threads} threads of {section.springs_per_thread} springs")
    _check_connected(flat, place / kind)
    whole = divided(flat, section.springs_per_thread)
    masses = _point_masses(section.masses, flat, place / "masses")
    center = middle_node(flat) if section.center is None else node_number(section.center, flat, place / "center")
    grid = None
    if flat.grid is not None and section.springs_per_thread == 1:
        grid = Grid(*flat.grid, flat.mesh_m)
    net = Net(
        kind=kind,
        nodes=frozen(whole.nodes),
        threads=frozen(whole.threads.astype(np.int64)),
        rest_lengths=frozen(whole.rest_lengths),
        grid=grid,
        center_node=center,
        material=thread,
        mesh_m=flat.mesh_m,
        own_node_count=len(flat.nodes),
        point_masses=masses,
    )
    return net, flat


def build_thread(content: Any, place: Place) -> Thread:
    """What threads are made of: a material by name, numbers, or both.

    Raises:
        DescriptionError: for an unknown material, or numbers that are missing.
    """
    section = read_section(ThreadSection, content, place)
    modulus, density, strength = section.modulus_pa, section.density_kg_m3, section.strength_pa
    name = section.material.lower()
    if name:
        if name not in MATERIALS:
            raise (place / "material").error(
                section.material, f"unknown material{near_match(name, MATERIALS)}",
                f"{', '.join(MATERIALS)}, or modulus_pa and density_kg_m3 instead",
            )  # fmt: skip
        known = MATERIALS[name]
        modulus = known.modulus_pa if modulus is None else modulus
        density = known.density_kg_m3 if density is None else density
        strength = known.strength_pa if strength is None else strength
    if modulus is None or density is None:
        missing = "modulus_pa" if modulus is None else "density_kg_m3"
        raise (place / missing).problem("is missing", f"a number, or material: {', '.join(MATERIALS)}")
    return Thread(name, section.radius_m, modulus, density, section.damping_ratio, strength)


def _flat_net(section: NetSection, folder: Path, place: Place) -> tuple[str, FlatNet]:
    given = [kind for kind in NET_KINDS if getattr(section, kind) is not None]
    if len(given) != 1:
        raise place.problem(f"has {' and '.join(given) or 'no kind of net'}", f"exactly one of {', '.join(NET_KINDS)}")
    kind = given[0]
    content, here = getattr(section, kind), place / kind
    if kind == "square":
        square = read_section(SquareSection, content, here)
        _check_size(square.rows * square.columns, here, f"{square.rows} rows of {square.columns} nodes")
        return kind, square_net(square)
    if kind in ("hexagonal", "triangular"):
        lattice, corners = read_section(LatticeSection, content, here), 6 if kind == "hexagonal" else 3
        _check_size(node_total(lattice, corners), here, f"{lattice.rings} rings")
        return kind, lattice_net(lattice, corners)
    if kind == "file":
        flat = net_from_file(read_section(FileSection, content, here), folder, here)
    else:
        flat = net_from_graph(read_section(GraphSection, content, here), here)
    _check_size(len(flat.nodes), here, "the tables")
    _check_threads(flat, here)
    return kind, flat


def _check_size(nodes: int, place: Place, of: str) -> None:
    if nodes > MOST_NODES:
        memory = nodes * _BYTES_PER_NODE / 1024**2
        raise place.problem(
            f"{of} make a net of {nodes} nodes, too large: {memory:.0f} MiB for each scenario that is simulated",
            f"at most {MOST_NODES} nodes",
        )


def _check_threads(net: FlatNet, place: Place) -> None:
    """Threads of a net that is not regular by construction."""
    if len(net.threads) == 0:
        raise place.problem("has no threads", "a net of at least one thread")
    same = np.flatnonzero(net.threads[:, 0] == net.threads[:, 1])
    if len(same):
        raise place.problem(
            f"thread {same[0]} leads from node {net.threads[same[0], 0]} to itself", "threads between two nodes"
        )
    short = np.flatnonzero(net.rest_lengths < 1e-3 * max(float(np.median(net.rest_lengths)), 1e-3))
    if len(short):
        a, b = net.threads[short[0]]
        raise place.problem(
            f"thread {short[0]}, from node {a} to node {b}, has the length {net.rest_lengths[short[0]]:g} m",
            "threads of a length above 0, none a thousand times shorter than the others",
        )
    ends = np.sort(net.threads, axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    twice = np.flatnonzero((np.diff(ends[order], axis=0) == 0).all(axis=1))
    if len(twice):
        first, second = order[twice[0]], order[twice[0] + 1]
        raise place.problem(
            f"threads {first} and {second} both join nodes {ends[first, 0]} and {ends[first, 1]}",
            "each thread once; a thicker one by another radius",
        )


def _check_connected(net: FlatNet, place: Place) -> None:
    used = np.bincount(net.threads.ravel(), minlength=len(net.nodes))
    loose = np.flatnonzero(used == 0)
    if len(loose):
        x, y = net.nodes[loose[0], :2]
        raise place.problem(
            f"node {loose[0]} at ({x:g}, {y:g}) m is loose: no thread ends there"
            + (f" (nor at {len(loose) - 1} more)" if len(loose) > 1 else ""),
            "nodes with at least one thread",
        )
    label = pieces(len(net.nodes), net.threads)
    apart = np.unique(label)
    if len(apart) > 1:
        sizes = ", ".join(str(int((label == piece).sum())) for piece in apart[:5])
        raise place.problem(
            f"falls into {len(apart)} pieces of {sizes} nodes; no thread joins node {apart[1]} to node {apart[0]}",
            "a net in one piece",
        )


def _point_masses(content: Any, flat: FlatNet, place: Place) -> tuple[PointMass, ...]:
    if not isinstance(content, list | tuple):
        raise place.error(content, "not a list", "a list of masses, each {node, mass_kg}")
    masses: list[PointMass] = []
    seen: dict[int, int] = {}
    for i, item in enumerate(content):
        if not isinstance(item, Mapping):
            raise place[i].error(item, "not a mass", "{node, mass_kg}")
        section = read_section(MassSection, item, place[i])
        node = node_number(section.node, flat, place[i] / "node")
        if node in seen:
            raise (place[i] / "node").error(
                section.node, f"node {node} already bears mass {seen[node]}", "one mass at a node"
            )
        seen[node] = i
        masses.append(PointMass(node, section.mass_kg))
    return tuple(masses)
