"""The reflections and rotations that map a system onto itself: net, units, closing, launch, and debris as it is met."""

from __future__ import annotations

import functools
import math

import numpy as np

from tethernet_core import sphere_directions
from tethernet_core.parameters import load
from tethernet_core.system import System
from tethernet_planner.inference.net_features import node_permutation
from tethernet_planner.inference.symmetry import TOLERANCE, NotMappedError, Symmetry, identity
from tethernet_sim.settings import ScenarioParameters

_SHAPE_SHARE = 1e-3
"""Surfaces that differ by less than this share of the body's size are the same: meshes are known no better."""

_DIRECTIONS = 200
_DEPTHS = (0.2, 0.4, 0.6)
"""Where surfaces are compared: distances from the centre of mass as shares of the body's size."""

Matrix = np.ndarray


@functools.lru_cache(maxsize=64)
def group(system: System) -> tuple[Symmetry, ...]:
    """All maps of the net's plane that leave a system as it is, the debris at the attitude and rate of the system's
    default scenario.

    Returns:
        The identity first, then rotations by their angle, then reflections by the angle of their line.
    """
    found = [(_order(matrix), made) for matrix in _candidates(system) if (made := _image(system, matrix)) is not None]
    return (identity(system.unit_count), *(made for order, made in sorted(found, key=lambda pair: pair[0]) if order[1]))


@functools.lru_cache(maxsize=64)
def seen_group(system: System) -> tuple[Symmetry, ...]:
    """Those of :func:`group` that map the nodes which a surrogate sees onto each other."""

    def maps_seen(symmetry: Symmetry) -> bool:
        try:
            node_permutation(symmetry, system)
        except NotMappedError:
            return False
        return True

    return tuple(symmetry for symmetry in group(system) if maps_seen(symmetry))


def _order(matrix: Matrix) -> tuple[bool, float]:
    """Reflections after rotations, both by their angle [rad]; 0.0 is the identity's."""
    reflects = bool(np.linalg.det(matrix) < 0.0)
    angle = math.atan2(matrix[1, 0], matrix[0, 0]) % (2.0 * math.pi)
    return reflects, round(angle / 2.0 if reflects else angle, 9) or (1e-12 if reflects else 0.0)


def _candidates(system: System) -> list[Matrix]:
    """Rotations and reflections that map the farthest node of the net onto another one as far away."""
    flat = _flat(system)
    distance = np.hypot(*flat.T)
    far = int(distance.argmax())
    begin = math.atan2(*flat[far][::-1])
    matrices = []
    for node in np.flatnonzero(distance > distance[far] * (1.0 - TOLERANCE)):
        end = math.atan2(*flat[node][::-1])
        turned, mirrored = end - begin, end + begin
        matrices.append(_clean([[math.cos(turned), -math.sin(turned)], [math.sin(turned), math.cos(turned)]]))
        matrices.append(_clean([[math.cos(mirrored), math.sin(mirrored)], [math.sin(mirrored), -math.cos(mirrored)]]))
    return matrices


def _clean(matrix: list[list[float]]) -> Matrix:
    """Whole numbers exactly."""
    array = np.array(matrix)
    whole = np.round(array)
    return np.where(np.abs(array - whole) < TOLERANCE, whole + 0.0, array)


def _flat(system: System) -> np.ndarray:
    nodes = system.net.nodes[:, :2]
    return nodes - nodes[system.net.center_node]


def _image(system: System, matrix: Matrix) -> Symmetry | None:
    """The map with what it does to the units; None where it does not leave the system as it is."""
    rows = ((float(matrix[0, 0]), float(matrix[0, 1])), (float(matrix[1, 0]), float(matrix[1, 1])))
    plain = Symmetry(rows, ())
    if not _keeps_debris(system, matrix):
        return None
    source = _nodes(system, plain)
    if source is None or not _keeps_net(system, source):
        return None
    units = _units(system, plain, source)
    if units is None:
        return None
    made = Symmetry(rows, units)
    particles = np.concatenate([source, system.net.node_count + np.array(units, np.int64)])
    return made if _keeps_rest(system, made, particles) else None


def _nodes(system: System, symmetry: Symmetry) -> np.ndarray | None:
    """Which node comes to lie on each node's place."""
    from scipy.spatial import KDTree

    flat, height = _flat(system), system.net.nodes[:, 2]
    limit = TOLERANCE * float(np.abs(flat).max()) * 10.0
    images = np.column_stack([symmetry.vectors(flat), height])
    distance, source = KDTree(images).query(np.column_stack([flat, height]))
    fits = bool((distance < limit).all()) and len(np.unique(source)) == len(flat)
    return np.asarray(source, np.int64) if fits else None


def _keeps_net(system: System, source: np.ndarray) -> bool:
    net = system.net
    target = np.argsort(source)  # where each node goes

    def table(threads: np.ndarray) -> np.ndarray:
        ends = np.sort(threads, axis=1)
        order = np.lexsort((ends[:, 1], ends[:, 0]))
        return np.column_stack([ends[order], net.rest_lengths[order]])

    masses = np.zeros(net.node_count)
    for point in net.point_masses:
        masses[point.node] += point.mass_kg
    same_threads = np.allclose(table(net.threads), table(target[net.threads]), rtol=1e-9, atol=0.0)
    return same_threads and source[net.center_node] == net.center_node and np.allclose(masses, masses[source])


def _units(system: System, symmetry: Symmetry, source: np.ndarray) -> tuple[int, ...] | None:
    """Which unit comes to lie on each unit's place; None where units are not mapped onto units like them."""
    at = {unit.node: m for m, unit in enumerate(system.units)}
    units = []
    for unit in system.units:
        other = at.get(int(source[unit.node]))
        if other is None:
            return None
        there = system.units[other]
        if {**vars(there), "node": 0} != {**vars(unit), "node": 0}:
            return None
        units.append(other)
    offsets = system.aiming.offsets.reshape(-1, 2)
    if units and not np.allclose(symmetry.vectors(offsets)[units], offsets, rtol=0.0, atol=1e-9):
        return None
    return tuple(units)


def _keeps_rest(system: System, symmetry: Symmetry, source: np.ndarray) -> bool:
    """Whether closing and launch are mapped onto themselves."""
    target = np.argsort(source)
    closing, launch = system.closing, system.launch
    pairs = {frozenset(pair) for pair in closing.pairs.tolist()} if closing.ring else set()
    if {frozenset(target[list(pair)].tolist()) for pair in pairs} != pairs:
        return False
    if set(target[list(closing.winches)].tolist()) != set(closing.winches):
        return False
    velocities = dict(zip(launch.particles, launch.velocities, strict=True))
    moved = {int(target[p]): symmetry.vectors(np.asarray(v)) for p, v in velocities.items()}
    return moved.keys() == velocities.keys() and all(
        np.allclose(moved[p], velocities[p], rtol=0.0, atol=1e-9) for p in moved
    )


def _keeps_debris(system: System, matrix: Matrix) -> bool:
    """Whether the debris, at the attitude and rate of the default scenario, is mapped onto itself."""
    from scipy.spatial.transform import Rotation

    scenario = load(ScenarioParameters, system.parameters.get("scenario"))
    turned = Rotation.from_quat(scenario.debris_attitude).as_matrix()
    in_launch = np.eye(3)
    in_launch[:2, :2] = matrix
    body = turned.T @ in_launch @ turned
    rate = np.array(scenario.debris_rate, float)  # an axial vector
    if not np.allclose(np.linalg.det(body) * body @ rate, rate, atol=1e-9):
        return False
    debris = system.debris
    inertia = debris.inertia
    if not np.allclose(body @ inertia @ body.T, inertia, rtol=0.0, atol=_SHAPE_SHARE * float(np.abs(inertia).max())):
        return False
    size = debris.shape.extent_m
    directions = sphere_directions.directions(_DIRECTIONS)
    places = np.concatenate([share * size * directions for share in _DEPTHS])
    center = np.asarray(debris.center_of_mass)
    here, _ = debris.shape.distance(center + places)
    there, _ = debris.shape.distance(center + places @ body.T)
    return bool((np.abs(here - there) < _SHAPE_SHARE * size).all())
