"""Flat nets of regular meshes: nodes, threads, and the corners by which people address nodes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .sections import LatticeSection, SquareSection


class FlatNet(NamedTuple):
    """Nodes and threads before threads are divided into springs."""

    nodes: np.ndarray
    """[m], shape (N, 3)."""
    threads: np.ndarray
    """Shape (T, 2), int."""
    rest_lengths: np.ndarray
    """[m], shape (T,)."""
    mesh_m: float
    """Length of a mesh [m]."""
    corners: tuple[int, ...] = ()
    """Nodes at the corners, counter-clockwise; empty where the net has none that are known."""
    sides: tuple[int, ...] = ()
    """Nodes in the middle of the sides, from corner k to the next one."""
    grid: tuple[int, int] | None = None
    """Rows and columns of a square net."""


def square_net(section: SquareSection) -> FlatNet:
    """Square meshes; threads along rows come first, then those along columns, each by their first node."""
    rows, columns, mesh = section.rows, section.columns, section.mesh_m
    x = (np.arange(columns) - 0.5 * (columns - 1)) * mesh
    y = (np.arange(rows) - 0.5 * (rows - 1)) * mesh
    gx, gy = np.meshgrid(x, y)
    nodes = np.stack([gx.ravel(), gy.ravel(), np.zeros(rows * columns)], axis=1)
    index = np.arange(rows * columns).reshape(rows, columns)
    threads = np.concatenate(
        [
            np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], axis=1),
            np.stack([index[:-1].ravel(), index[1:].ravel()], axis=1),
        ]
    )
    last_row, last_column = rows - 1, columns - 1
    corners = (index[0, 0], index[0, last_column], index[last_row, last_column], index[last_row, 0])
    sides = (
        index[0, columns // 2], index[rows // 2, last_column], index[last_row, columns // 2], index[rows // 2, 0],
    )  # fmt: skip
    return FlatNet(
        nodes, threads, np.full(len(threads), mesh), mesh, tuple(map(int, corners)), tuple(map(int, sides)),
        (rows, columns),
    )  # fmt: skip


_HALF_ROOT_3 = 0.5 * math.sqrt(3.0)


def lattice_net(section: LatticeSection, corner_count: int) -> FlatNet:
    """A triangular lattice with six or three sides: concentric rings round the central node.

    Args:
        section: rings, spacing, whether threads run along the inner rings.
        corner_count: 6, or 3: a triangle whose ring k has 3 k threads a side.
    """
    # Lattice coordinates (u, v): position u (1, 0) + v (1/2, sqrt 3 / 2), in spacings.
    if corner_count == 6:
        corners, per_side = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)], 1
    else:
        corners, per_side = [(1, 1), (-2, 1), (1, -2)], 3
    places, rings = [(0, 0)], [0]
    for ring in range(1, section.rings + 1):
        for k, (u, v) in enumerate(corners):
            next_u, next_v = corners[(k + 1) % corner_count]
            step_u, step_v = (next_u - u) // per_side, (next_v - v) // per_side
            for i in range(per_side * ring):
                places.append((ring * u + i * step_u, ring * v + i * step_v))
                rings.append(ring)
    number = {place: i for i, place in enumerate(places)}
    threads = []
    for i, (u, v) in enumerate(places):
        for du, dv in ((1, 0), (0, 1), (-1, 1)):
            j = number.get((u + du, v + dv))
            if j is not None and (section.inner_rings or rings[i] != rings[j] or rings[i] == section.rings):
                threads.append((min(i, j), max(i, j)))
    uv = np.array(places, float)
    flat = np.stack([uv[:, 0] + 0.5 * uv[:, 1], _HALF_ROOT_3 * uv[:, 1], np.zeros(len(uv))], axis=1)
    first = len(places) - corner_count * per_side * section.rings
    side = per_side * section.rings
    return FlatNet(
        section.spacing_m * flat,
        np.array(sorted(threads), np.int64),
        np.full(len(threads), section.spacing_m),
        section.spacing_m,
        tuple(first + k * side for k in range(corner_count)),
        tuple(first + k * side + side // 2 for k in range(corner_count)),
    )


def node_total(section: LatticeSection, corner_count: int) -> int:
    """Nodes that a lattice will have."""
    per_side = 1 if corner_count == 6 else 3
    return 1 + corner_count * per_side * section.rings * (section.rings + 1) // 2


def divided(net: FlatNet, springs: int) -> FlatNet:
    """The same net with each thread divided into springs; the nodes between them come after the net's own, thread by
    thread.
    """
    if springs == 1:
        return net
    own, count = len(net.nodes), len(net.threads)
    first, second = net.nodes[net.threads[:, 0]], net.nodes[net.threads[:, 1]]
    share = np.arange(1, springs) / springs
    between = first[:, None] + share[None, :, None] * (second - first)[:, None]
    inner = own + np.arange(count * (springs - 1)).reshape(count, springs - 1)
    chain = np.concatenate([net.threads[:, :1], inner, net.threads[:, 1:]], axis=1)
    threads = np.stack([chain[:, :-1].ravel(), chain[:, 1:].ravel()], axis=1)
    return net._replace(
        nodes=np.concatenate([net.nodes, between.reshape(-1, 3)]),
        threads=threads,
        rest_lengths=np.repeat(net.rest_lengths / springs, springs),
    )
