"""Pictures of a system: the flat net from the front, from the side and from above, the debris behind it to scale."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import DescriptionError

if TYPE_CHECKING:
    from .system import System

_DPI = 150
_THREAD, _RING, _UNIT, _MASS, _AIM, _DEBRIS = "0.6", "tab:orange", "tab:blue", "tab:purple", "tab:green", "tab:red"
_VIEWS = (("x", 0, "y", 1, "front"), ("z", 2, "y", 1, "side"), ("x", 0, "z", 2, "above"))
"""Horizontal and vertical axis of each view, with their names."""
_GAP_M = 0.15
"""Between net and debris, in units of the picture's size."""


def draw(system: System, path: str | Path) -> Path:
    """Draw a system in three views, frame launch: flat net, units, masses, closing ring, nominal aiming points, and the
    debris with its long axis across, as far behind the net as it takes to see both.

    Args:
        system: any.
        path: of the picture; its ending says the format (png, svg, pdf).

    Returns:
        The path.

    Raises:
        DescriptionError: when the picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    target = Path(path)
    figure = Figure(figsize=(13.0, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(f"{system.name}: {system.description}" if system.description else system.name, fontsize=11)
    positions = _particles(system)
    vertices, faces, center_z = _debris(system, positions)
    for axes, (across, i, up, j, name) in zip(figure.subplots(1, 3), _VIEWS, strict=True):
        _draw_view(axes, system, positions, vertices, faces, center_z, (i, j))
        axes.set(xlabel=f"{across} [m]", ylabel=f"{up} [m]", title=name, aspect="equal", adjustable="datalim")
        axes.margins(0.06)
        axes.grid(alpha=0.25, linewidth=0.5)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=9, frameon=False)
    try:
        figure.savefig(target, dpi=_DPI)
    except (OSError, ValueError) as error:
        raise DescriptionError(f"cannot draw system {system.name} to {target}: {error}") from error
    return target


def _particles(system: System) -> np.ndarray:
    """Nodes and units in the flat net, threads of the units taut outwards [m], shape (N + M, 3)."""
    nodes = system.net.nodes
    center = nodes[system.net.center_node]
    units = []
    for unit in system.units:
        outward = nodes[unit.node] - center
        length = float(np.linalg.norm(outward))
        units.append(nodes[unit.node] + (unit.thread_length_m / length if length else 0.0) * outward)
    return np.concatenate([nodes, np.array(units).reshape(-1, 3)])


def _debris(system: System, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """The debris' surface behind the net [m], its z axis across the picture: vertices (V, 3), faces (F, 3), and z of
    its centre of mass.
    """
    vertices, faces = system.debris.shape.triangles()
    # Body z along x, body x along y: a turn without mirroring.
    turned = (vertices - system.debris.center_of_mass)[:, [2, 0, 1]]
    gap = _GAP_M * float(np.ptp(positions[:, :2], axis=0).max())
    center_z = -gap - float(turned[:, 2].max())
    turned[:, 2] += center_z
    return turned, faces, center_z


def _draw_view(
    axes: Any,
    system: System,
    positions: np.ndarray,
    vertices: np.ndarray,
    faces: np.ndarray,
    center_z: float,
    view: tuple[int, int],
) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    net, flat, behind = system.net, positions[:, list(view)], vertices[:, list(view)]
    axes.add_collection(PolyCollection(behind[faces], facecolor=_DEBRIS, edgecolor="none", alpha=0.12))
    edges = _outline(vertices, faces, 3 - sum(view))
    axes.add_collection(LineCollection(behind[edges], colors=_DEBRIS, linewidths=0.7, alpha=0.8, label="debris"))
    axes.add_collection(LineCollection(flat[net.threads], colors=_THREAD, linewidths=0.4, label="net"))
    if system.units:
        hang = np.array([[unit.node, net.node_count + i] for i, unit in enumerate(system.units)])
        axes.add_collection(LineCollection(flat[hang], colors=_UNIT, linewidths=0.8))
    if len(system.closing.ring):
        pairs = flat[system.closing.pairs]
        axes.add_collection(LineCollection(pairs, colors=_RING, linewidths=1.2, linestyles="--", label="closing ring"))
        if system.closing.kind == "winch":
            ring = flat[list(system.closing.ring)]
            axes.plot(ring[:, 0], ring[:, 1], ".", color=_RING, markersize=4)
    if net.point_masses:
        masses = flat[[point.node for point in net.point_masses]]
        axes.plot(masses[:, 0], masses[:, 1], "D", color=_MASS, markersize=5, label="masses")
    if system.units:
        units = flat[net.node_count :]
        aims = np.column_stack([system.aiming.offsets, np.full(system.unit_count, center_z)])
        axes.plot(*aims[:, list(view)].T, "+", color=_AIM, markersize=9, label="nominal aiming points, at the debris")
        axes.plot(units[:, 0], units[:, 1], "s", color=_UNIT, markersize=5, label="units")
        if view == (0, 1):
            for number, place in enumerate(units, 1):
                axes.annotate(str(number), place, xytext=(5, 5), textcoords="offset points", color=_UNIT, fontsize=9)
    middle = flat[net.center_node]
    axes.plot(middle[0], middle[1], "o", color="black", markersize=3.5, label="central node")
    axes.autoscale_view()


def _outline(vertices: np.ndarray, faces: np.ndarray, along: int) -> np.ndarray:
    """Edges seen along an axis: those between faces that meet at more than 20 degrees, and the silhouette, (E, 2)."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    sharp: dict[tuple[int, int], list[int]] = {}
    for face, (a, b, c) in enumerate(faces.tolist()):
        for first, second in ((a, b), (b, c), (c, a)):
            sharp.setdefault((min(first, second), max(first, second)), []).append(face)
    bend = np.cos(np.radians(20.0))
    faces_viewer = normals[:, along] > 1e-9
    kept = [
        edge
        for edge, of in sharp.items()
        if len(of) != 2
        or normals[of[0]] @ normals[of[1]] < bend
        or bool(faces_viewer[of[0]]) != bool(faces_viewer[of[1]])
    ]
    return np.array(kept, np.int64).reshape(-1, 2)
