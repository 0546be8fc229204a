"""What a surrogate sees of the net at the start of closing (paper, section II.E).

Nodes in this order: those of up to three loops, each counter-clockwise from the direction of the net's first corner;
the central node; the units, unit 1 first. The loops are the nodes that are a number of threads away from the net's
border: 0, and the share of the way to the middle that makes 0, 4 and 9 of the paper's 11 [A; three loops are P]. For
its net of 23 x 23 knots these are 88 + 56 + 16 knots, 165 nodes with 4 units and 169 with 8, and with six numbers each
990 or 1014 inputs [P].
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tethernet_core.system import System
from tethernet_planner.inference.symmetry import Symmetry

LOOP_SHARES = (0.0, 4.0 / 11.0, 9.0 / 11.0)
"""Loops, 0 the border, 1 the middle."""

NUMBERS = 6
"""Per node: x y z [m] and their rates [m/s], relative to the debris' centre of mass, axes of frame launch."""

SECTORS = 8
"""Steps of the recurrent network's sequence."""

_LARGEST_LOOP = 400
"""Of longer loops every second, third, ... node is seen."""

_ANGLE = 1e-9  # [rad]


@dataclass(frozen=True)
class Seen:
    """The nodes that a surrogate sees of one system."""

    loops: tuple[tuple[int, ...], ...]
    """Nodes of the net, loop by loop."""
    center: int
    """The central node."""
    unit_count: int

    @functools.cached_property
    def nodes(self) -> np.ndarray:
        """Nodes of the net, loops first, then the central one, shape (K,)."""
        return np.array([*(node for loop in self.loops for node in loop), self.center])

    @property
    def count(self) -> int:
        """Nodes and units."""
        return len(self.nodes) + self.unit_count

    @property
    def feature_count(self) -> int:
        """Numbers."""
        return NUMBERS * self.count


@functools.lru_cache(maxsize=64)
def seen(system: System) -> Seen:
    """What a surrogate sees of a system."""
    depth = _depths(system)
    deepest = int(depth.max())
    chosen = dict.fromkeys(round(share * deepest) for share in LOOP_SHARES)
    loops = [_around(system, np.flatnonzero(depth == level)) for level in chosen]
    return Seen(
        tuple(tuple(loop[:: 1 + (len(loop) - 1) // _LARGEST_LOOP]) for loop in loops if len(loop) > 1),
        system.net.center_node,
        system.unit_count,
    )


def feature_count(system: System) -> int:
    """Numbers that a surrogate sees of a system."""
    return seen(system).feature_count


def features(
    system: System,
    knot_positions: np.ndarray,
    knot_velocities: np.ndarray,
    mu_positions: np.ndarray,
    mu_velocities: np.ndarray,
    debris_position: Sequence[float] | np.ndarray,
    debris_velocity: Sequence[float] | np.ndarray,
) -> np.ndarray:
    """The inputs of a surrogate.

    Args:
        system: gives the nodes that are seen.
        knot_positions: of all nodes of the net [m], shape (N, 3).
        knot_velocities: [m/s], shape (N, 3).
        mu_positions: of the units [m], shape (M, 3).
        mu_velocities: [m/s], shape (M, 3).
        debris_position: centre of mass [m].
        debris_velocity: of the centre of mass [m/s].

    Returns:
        float32, shape (:func:`feature_count`,): x y z vx vy vz of each node.
    """
    return features_of(
        seen(system).nodes, knot_positions, knot_velocities, mu_positions, mu_velocities, debris_position,
        debris_velocity,
    )  # fmt: skip


def features_of(
    nodes: np.ndarray,
    knot_positions: np.ndarray,
    knot_velocities: np.ndarray,
    mu_positions: np.ndarray,
    mu_velocities: np.ndarray,
    debris_position: Sequence[float] | np.ndarray,
    debris_velocity: Sequence[float] | np.ndarray,
) -> np.ndarray:
    """:func:`features` with the nodes that are seen, shape (K,), in the place of the system."""
    position = np.concatenate([knot_positions[nodes], mu_positions]) - np.asarray(debris_position, float)
    velocity = np.concatenate([knot_velocities[nodes], mu_velocities]) - np.asarray(debris_velocity, float)
    return np.hstack([position, velocity]).astype(np.float32).ravel()


def places(system: System) -> np.ndarray:
    """Where the nodes that are seen lie in the flat net, and the nominal aiming points of the units, from the central
    node [m], shape (nodes, 2).
    """
    flat = system.net.nodes[:, :2]
    return np.vstack([flat[seen(system).nodes] - flat[system.net.center_node], system.aiming.offsets.reshape(-1, 2)])


@functools.lru_cache(maxsize=1024)
def node_permutation(symmetry: Symmetry, system: System) -> np.ndarray:
    """Which node comes to lie on each node's place, shape (nodes,).

    Raises:
        NotMappedError: when the nodes that are seen are not mapped onto each other.
    """
    knots = len(seen(system).nodes)
    flat = symmetry.permutation(places(system)[:knots])
    return np.concatenate([flat, knots + np.array(symmetry.units, np.int64)])


def image_of_features(symmetry: Symmetry, rows: np.ndarray, system: System) -> np.ndarray:
    """Features of the mirrored missions, shape (n, feature_count) like ``rows``."""
    nodes = rows.reshape(len(rows), seen(system).count, 2, 3)[:, node_permutation(symmetry, system)]
    return symmetry.vectors(nodes).reshape(rows.shape)


def sector_nodes(system: System) -> np.ndarray:
    """The sequence of the recurrent network: once round the mouth in eight sectors of 45 degrees.

    The paper's network is recurrent and has 990 or 1014 inputs, but what its sequence is it does not say [A]. Here each
    step sees one sector: its part of each loop (11 + 7 + 2 knots in the paper's net), the central node, and the unit
    that hangs there.

    Returns:
        Indices into the nodes that are seen, shape (SECTORS, width); their number stands for "nothing here".
    """
    look = seen(system)
    begins = np.cumsum([0, *(len(loop) for loop in look.loops)])
    center, missing = int(begins[-1]), look.count
    units: list[list[int]] = [[] for _ in range(SECTORS)]
    turn = _turns(system, np.array([unit.node for unit in system.units], int))
    for m, angle in enumerate(turn.tolist()):
        units[int(SECTORS * angle / (2.0 * np.pi) + _ANGLE)].append(center + 1 + m)
    steps = []
    for sector in range(SECTORS):
        parts = []
        for begin, loop in zip(begins.tolist(), look.loops, strict=False):
            nodes = [begin + i for i in range(len(loop)) if i * SECTORS // len(loop) == sector]
            parts += _padded(nodes, -(-len(loop) // SECTORS), missing)
        steps.append([*parts, center, *_padded(units[sector], max(map(len, units)), missing)])
    return np.array(steps)


def _padded(nodes: list[int], width: int, missing: int) -> list[int]:
    return nodes + [missing] * (width - len(nodes))


def _depths(system: System) -> np.ndarray:
    """Threads between each node and the border of the flat net, shape (nodes of the net before its threads are
    divided into springs,).
    """
    net = system.flat_net
    count = len(net.nodes)
    # A thread of the border has meshes on one side alone; nets whose nodes lie on one line are all border.
    depth = np.full(count, -1)
    depth[_border(net.nodes[:, :2], net.threads)] = 0
    level = 0
    a, b = net.threads[:, 0], net.threads[:, 1]
    while (depth < 0).any():
        reached = np.concatenate([b[(depth[a] == level) & (depth[b] < 0)], a[(depth[b] == level) & (depth[a] < 0)]])
        if not len(reached):
            break
        level += 1
        depth[reached] = level
    return np.where(depth < 0, 0, depth)


def _border(nodes: np.ndarray, threads: np.ndarray) -> list[int]:
    """Nodes on the way round the flat net from outside: at each node the next thread to the right is taken."""
    neighbours: list[list[int]] = [[] for _ in range(len(nodes))]
    for first, second in threads.tolist():
        neighbours[first].append(second)
        neighbours[second].append(first)
    start = int(np.lexsort((nodes[:, 0], nodes[:, 1]))[0])  # the lowest, of these the leftmost
    found, here, back = [start], start, np.pi  # where the last step came from, seen from here
    first_step: tuple[int, int] | None = None
    while True:
        to = np.array(neighbours[here])
        step = nodes[to] - nodes[here]
        turn = np.mod(np.arctan2(step[:, 1], step[:, 0]) - back, 2.0 * np.pi)
        turn[turn < _ANGLE] = 2.0 * np.pi  # back where it came from, only where nothing else is left
        following = int(to[np.argmin(turn)])
        if first_step == (here, following):
            return sorted(set(found))
        first_step = first_step or (here, following)
        found.append(following)
        back = float(np.arctan2(*(nodes[here] - nodes[following])[::-1]))
        here = following


def _turns(system: System, nodes: np.ndarray) -> np.ndarray:
    """Directions of nodes from the middle, counter-clockwise from that of the first corner, or of unit 1 where a net
    has no corners [rad], 0 to 2 pi, shape as ``nodes``.
    """
    flat = system.net.nodes[:, :2] - system.net.nodes[system.net.center_node, :2]
    corners = system.flat_net.corners or tuple(unit.node for unit in system.units) or (0,)
    begin = np.arctan2(*flat[corners[0]][::-1])
    turn = np.mod(np.arctan2(flat[nodes, 1], flat[nodes, 0]) - begin, 2.0 * np.pi)
    return np.where(turn > 2.0 * np.pi - _ANGLE, 0.0, turn)


def _around(system: System, nodes: np.ndarray) -> list[int]:
    """Nodes counter-clockwise; at equal directions the nearer one comes first."""
    flat = system.net.nodes[:, :2] - system.net.nodes[system.net.center_node, :2]
    distance = np.hypot(*flat[nodes].T)
    order = np.lexsort((np.round(distance, 9), np.round(_turns(system, nodes), 9)))
    return [int(node) for node in nodes[order]]
