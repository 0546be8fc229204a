"""What a page has to know of a system to draw it: how the net is tied, the shapes of debris and chaser."""

from __future__ import annotations

from typing import Any

import numpy as np

from tethernet_bringup.report.packing import rounded, whole_numbers
from tethernet_core.system import System

MOST_FACES = 20_000
"""A finer surface of the debris is shown as this many of its triangles at most would show it."""


def geometry(system: System, shown: np.ndarray | None = None) -> dict[str, Any]:
    """Ready for JSON.

    Args:
        system: what was flown.
        shown: numbers of the knots that flights hold, shape (N,), where these are not all: neighbours along a row or a
            column of the net are then tied to each other.
    """
    net, debris = system.net, system.debris
    vertices, faces = coarsened(*debris.shape.triangles())
    place = _place_of(system, shown)
    threads = net.threads if shown is None or net.grid is None else _coarse_threads(net.grid.columns, shown)
    return {
        "name": system.name,
        "nodes": net.node_count if shown is None else len(shown),
        "threads": whole_numbers(place[threads]),
        "unitNodes": [int(place[unit.node]) for unit in system.units],
        "unitSides": [rounded(unit.box_m) for unit in system.units],
        "thrustLimits": [unit.thrust_limit_n for unit in system.units],
        "pairs": whole_numbers(place[system.closing.pairs]) if system.closing.ring else [],
        "masses": [int(place[mass.node]) for mass in net.point_masses],
        "center": int(place[net.center_node]),
        "tether": system.tether.stiffness_n_m > 0.0,
        "vertices": rounded(vertices - debris.center_of_mass),
        "faces": whole_numbers(faces),
        "chaserSide": system.chaser.side_m,
        "anchor": system.chaser.anchor_m,
    }


def coarse_knots(system: System) -> np.ndarray | None:
    """Every other row and column of a net of square meshes with what is tied to it, as numbers of knots; None for
    other nets.
    """
    net = system.net
    if net.grid is None:
        return None
    rows, columns = net.grid.rows, net.grid.columns
    grid = np.arange(rows * columns).reshape(rows, columns)
    kept = grid[np.ix_(_every_other(rows), _every_other(columns))].ravel()
    return np.asarray(kept)


def coarsened(vertices: np.ndarray, faces: np.ndarray, most: int = MOST_FACES) -> tuple[np.ndarray, np.ndarray]:
    """A surface with fewer triangles: vertices in one cell of space become one.

    Args:
        vertices: [m], shape (V, 3).
        faces: shape (F, 3).
        most: how many triangles there may be; a surface with fewer stays what it is.
    """
    cells = 128
    low, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max())
    while len(faces) > most and cells > 4:
        key = np.floor((vertices - low) / size * cells).astype(np.int64)
        _, member = np.unique(key, axis=0, return_inverse=True)
        member = member.reshape(-1)
        number = np.bincount(member)
        vertices = np.stack([np.bincount(member, vertices[:, axis]) / number for axis in range(3)], axis=1)
        faces = member[faces]
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
        cells //= 2
    return vertices, faces


def _every_other(count: int) -> np.ndarray:
    """0, 2, 4 ... and the last."""
    return np.unique(np.append(np.arange(0, count, 2), count - 1))


def _place_of(system: System, shown: np.ndarray | None) -> np.ndarray:
    """Where each particle stands in a page's list of points: the shown knots, then the units."""
    net, units = system.net, system.unit_count
    if shown is None:
        return np.arange(net.node_count + units)
    place = np.empty(net.node_count + units, np.int64)
    place[: net.node_count] = np.argmin(
        np.linalg.norm(net.nodes[:, None, :] - net.nodes[None, shown, :], axis=2), axis=1
    )
    place[net.node_count :] = len(shown) + np.arange(units)
    return place


def _coarse_threads(columns: int, shown: np.ndarray) -> np.ndarray:
    """Neighbours among the shown knots along rows and columns, as numbers of knots, shape (T, 2)."""
    row, column = np.divmod(shown, columns)
    grid = shown.reshape(len(np.unique(row)), len(np.unique(column)))
    along = np.stack([grid[:, :-1].ravel(), grid[:, 1:].ravel()], axis=1)
    across = np.stack([grid[:-1].ravel(), grid[1:].ravel()], axis=1)
    return np.concatenate([along, across])
