"""Units, closing, launch and aiming of a description, built and checked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .addresses import node_number
from .entries import check_given, check_keys, finite, read_section
from .errors import Findings, Place
from .geometry import around, hull, windings
from .lattices import FlatNet
from .parts import Aiming, Capture, Closing, Launch, Net, Unit, frozen
from .sections import (
    MOST_UNITS,
    NODE_FORM,
    AimingSection,
    CaptureSection,
    DockingSection,
    EjectedSection,
    UnitSection,
    WinchSection,
)

CLOSING_KINDS = ("docking", "winch")


class Equipped(NamedTuple):
    """A net with its units: what closing, launch and aiming are built on."""

    net: Net
    flat: FlatNet
    units: tuple[Unit, ...]
    mouth_order: tuple[int, ...]
    """Units in their order round the mouth, from 1."""

    @property
    def center(self) -> np.ndarray:
        """Flat position of the central node [m], shape (2,)."""
        return self.net.nodes[self.net.center_node, :2]


def build_units(content: Any, common: Any, net: Net, flat: FlatNet, place: Place) -> tuple[Unit, ...]:
    """The units of a description.

    Args:
        content: the list ``units``.
        common: the section ``unit``.
        net: what they hang on.
        flat: its own nodes.
        place: of the description.

    Raises:
        DescriptionError: for too many, for two on one node, or for entries that are wrong.
    """
    here = place / "units"
    if not isinstance(content, list | tuple):
        raise here.error(content, "not a list", "a list of units, each {node, thread_length_m, ...}; [] for none")
    if len(content) > MOST_UNITS:
        raise here.problem(f"{len(content)} units", f"0 to {MOST_UNITS}")
    names = [name for name in UnitSection.__dataclass_fields__ if name != "node"]
    shared = check_keys({} if common is None else common, names, place / "unit")
    check_given(UnitSection, shared, place / "unit")
    found = Findings()
    units: list[Unit] = []
    for i, item in enumerate(content):
        with found.collected():
            units.append(_build_unit(item, shared, net, flat, units, here[i]))
    found.raise_them()
    return tuple(units)


def _build_unit(
    item: Any, shared: Mapping[str, Any], net: Net, flat: FlatNet, others: Sequence[Unit], place: Place
) -> Unit:  # fmt: skip
    if not isinstance(item, Mapping):
        raise place.error(item, "not a unit", "{node, thread_length_m, ...}")
    section = read_section(UnitSection, {**shared, **item}, place)
    node = node_number(section.node, flat, place / "node")
    other = next((k for k, unit in enumerate(others) if unit.node == node), None)
    if other is not None:
        raise (place / "node").error(
            section.node, f"node {node} already bears unit {other + 1}", "a node of its own for each unit"
        )
    if section.propellant_kg >= section.mass_kg:
        raise (place / "propellant_kg").error(
            section.propellant_kg, "not less than the unit's mass", f"below {section.mass_kg:g} kg"
        )
    length = section.thread_length_m if section.stiffness_length == "thread" else flat.mesh_m
    return Unit(
        node=node,
        thread_length_m=section.thread_length_m,
        thread_stiffness_n_m=net.material.stiffness_n_m(length),
        thread_damping_n_s_m=net.material.damping_n_s_m(length),
        mass_kg=section.mass_kg,
        box_m=section.box_m,
        radius_m=0.5 * max(section.box_m) if section.radius_m is None else section.radius_m,
        thrust_limit_n=section.thrust_limit_n,
        specific_impulse_s=section.specific_impulse_s,
        propellant_kg=section.propellant_kg,
    )


def order_round_mouth(net: Net, units: tuple[Unit, ...]) -> tuple[int, ...]:
    """The units, from 1, in their order round the mouth, counter-clockwise from unit 1."""
    if not units:
        return ()
    flat = net.nodes[[unit.node for unit in units], :2]
    return tuple(i + 1 for i in around(flat, net.nodes[net.center_node, :2]))


def build_closing(content: Any, equipped: Equipped, place: Place) -> Closing:
    """How the mouth closes.

    Raises:
        DescriptionError: for a ring that is none.
    """
    if content in ("none", None):
        return Closing("none")
    allowed = "none, {docking: ...} or {winch: ...}"
    if not isinstance(content, Mapping):
        raise place.error(content, "not a way to close", allowed)
    given = [kind for kind, entries in check_keys(content, CLOSING_KINDS, place, "way").items() if entries is not None]
    if len(given) != 1:
        raise place.problem(f"has {' and '.join(given) or 'no way to close'}", allowed)
    if given == ["docking"]:
        return _docking(content["docking"], equipped, place / "docking")
    return _winch(content["winch"], equipped, place / "winch")


def _docking(content: Any, equipped: Equipped, place: Place) -> Closing:
    section = read_section(DockingSection, content, place)
    count, here = len(equipped.units), place / "ring"
    ring = equipped.mouth_order if section.ring is None else section.ring
    allowed = f"at least 3 different units, numbered 1 to {count}, in their order round the mouth"
    if count < 3:
        raise place.problem(f"{count} units cannot close a mouth", "3 or more units, closing: {winch: ...} or none")
    if not isinstance(ring, list | tuple):
        raise here.error(ring, "not a list of units", allowed)
    for i, unit in enumerate(ring):
        if isinstance(unit, bool) or not isinstance(unit, int) or not 1 <= unit <= count:
            raise here[i].error(unit, "no such unit", f"1 to {count}")
    nodes = [equipped.units[unit - 1].node for unit in ring]
    _check_ring(list(ring), nodes, equipped, here, "unit", allowed)
    _check_distance(section.docking_distance_m, nodes, equipped, place / "docking_distance_m")
    return Closing(
        kind="docking",
        ring=tuple(equipped.net.node_count + unit - 1 for unit in ring),
        docking_distance_m=section.docking_distance_m,
        draw_in_m_s=section.draw_in_m_s,
        pull_n=section.pull_n,
    )


def _winch(content: Any, equipped: Equipped, place: Place) -> Closing:
    section = read_section(WinchSection, content, place)
    here = place / "ring"
    allowed = f"at least 3 different nodes in their order round the mouth, or {{perimeter: COUNT}}; each {NODE_FORM}"
    if isinstance(section.ring, Mapping):
        ring = _perimeter(section.ring, equipped, here)
    elif isinstance(section.ring, list | tuple):
        ring = [node_number(node, equipped.flat, here[i]) for i, node in enumerate(section.ring)]
    else:
        raise here.error(section.ring, "not a list of nodes", allowed)
    _check_ring(ring, ring, equipped, here, "node", allowed)
    _check_distance(section.docking_distance_m, ring, equipped, place / "docking_distance_m")
    winches = _winches(section, ring, equipped, place / "winches")
    start = ring.index(winches[0])
    ring = ring[start:] + ring[:start]
    flat = equipped.net.nodes[ring]
    around_mouth = float(np.sqrt(((np.roll(flat, -1, axis=0) - flat) ** 2).sum(axis=1)).sum())
    stiffness = section.stiffness_n_m
    if stiffness is None:
        stiffness = equipped.net.material.stiffness_n_m(around_mouth / len(winches))
    return Closing(
        kind="winch",
        ring=tuple(ring),
        docking_distance_m=section.docking_distance_m,
        winch_speed_m_s=section.speed_m_s,
        winch_tension_n=section.tension_n,
        winch_stiffness_n_m=stiffness,
        winches=tuple(node for node in ring if node in winches),
    )


def _perimeter(content: Mapping[str, Any], equipped: Equipped, place: Place) -> list[int]:
    """Nodes spread evenly over the net's border, beginning where the first unit or mass is."""
    check_keys(content, ["perimeter"], place)
    flat = equipped.flat.nodes[:, :2]
    border = hull(flat, 1e-9 * max(equipped.flat.mesh_m, 1e-9) * len(flat))
    bearers = [unit.node for unit in equipped.units] + [point.node for point in equipped.net.point_masses]
    first = next((border.index(node) for node in bearers if node in border), 0)
    border = border[first:] + border[:first]
    count = content.get("perimeter")
    allowed = f"3 to {len(border)}, the nodes of the border"
    if isinstance(count, bool) or not isinstance(count, int) or not 3 <= count <= len(border):
        raise (place / "perimeter").error(count, "no number of nodes on the border", allowed)
    return [border[round(i * len(border) / count)] for i in range(count)]


def _winches(section: WinchSection, ring: list[int], equipped: Equipped, place: Place) -> list[int]:
    if section.winches is None:
        bearers = {unit.node for unit in equipped.units} | {point.node for point in equipped.net.point_masses}
        winches = [node for node in ring if node in bearers]
        if not winches:
            raise place.problem(
                "no node of the ring bears a unit or a mass that a winch could be in", "a list of nodes"
            )
        return winches
    if not isinstance(section.winches, list | tuple) or not section.winches:
        raise place.error(section.winches, "not a list of nodes", "at least one node of the ring")
    winches = [node_number(node, equipped.flat, place[i]) for i, node in enumerate(section.winches)]
    for i, node in enumerate(winches):
        if node not in ring:
            raise place[i].error(section.winches[i], f"node {node} is not in the ring", "nodes of the ring")
        if node in winches[:i]:
            raise place[i].error(section.winches[i], f"node {node} is there twice", "each node once")
    return [node for node in ring if node in winches]


def _check_ring(
    members: list[int], nodes: list[int], equipped: Equipped, place: Place, noun: str, allowed: str
) -> None:
    if len(members) < 3:
        raise place.problem(f"{len(members)} {noun}s are no ring", allowed)
    for i, member in enumerate(members):
        if member in members[:i]:
            raise place[i].problem(f"{noun} {member} is in the ring twice", allowed)
    times, steady = windings(equipped.net.nodes[nodes, :2], equipped.center)
    if abs(abs(times) - 1.0) > 1e-6 or not steady:
        raise place.problem(
            f"does not go round the mouth once: it goes {abs(times):.2g} times round the central node "
            f"{equipped.net.center_node}" + ("" if steady else ", and turns back on its way"),
            allowed,
        )


def _check_distance(distance: float, nodes: list[int], equipped: Equipped, place: Place) -> None:
    """Neighbours that lock while the mouth is wide open would say nothing of a capture."""
    flat = equipped.net.nodes[nodes]
    nearest = float(np.sqrt(((np.roll(flat, -1, axis=0) - flat) ** 2).sum(axis=1)).min())
    if distance >= nearest:
        raise place.error(
            distance, f"neighbours in the ring are {nearest:.4g} m apart in the open net", f"less than {nearest:.4g} m"
        )


def build_launch(content: Any, equipped: Equipped, place: Place) -> Launch:
    """How the net gets out.

    Raises:
        DescriptionError: where nothing pulls it out.
    """
    allowed = "flown (by units) or {ejected: {speed_m_s, opening_angle_deg}}"
    if content == "flown":
        if not equipped.units:
            raise place.error(content, "there is no unit that could pull the net out", "units, or {ejected: ...}")
        return Launch("flown", (), frozen(np.zeros((0, 3))))
    if not isinstance(content, Mapping) or set(content) != {"ejected"}:
        raise place.error(content, "no way to launch", allowed)
    return _ejected(content["ejected"], equipped, place / "ejected")


def _ejected(content: Any, equipped: Equipped, place: Place) -> Launch:
    section = read_section(EjectedSection, content, place)
    net = equipped.net
    if section.bodies is not None:
        if not isinstance(section.bodies, list | tuple):
            raise (place / "bodies").error(section.bodies, "not a list of nodes", f"a list of nodes, each {NODE_FORM}")
        here = place / "bodies"
        particles = [node_number(node, equipped.flat, here[i]) for i, node in enumerate(section.bodies)]
        nodes = list(particles)
    elif net.point_masses:
        particles = [point.node for point in net.point_masses]
        nodes = list(particles)
    else:
        particles = [net.node_count + i for i in range(len(equipped.units))]
        nodes = [unit.node for unit in equipped.units]
    if not particles:
        raise place.problem("there is nothing to eject", "net.masses, units, or bodies: a list of nodes")
    if section.velocities_m_s is not None:
        if section.speed_m_s is not None or section.opening_angle_deg is not None:
            raise place.problem("has velocities_m_s and a speed or an angle", "one or the other")
        velocities = _velocities(section.velocities_m_s, len(particles), place / "velocities_m_s")
    else:
        if section.speed_m_s is None or section.opening_angle_deg is None:
            raise place.problem(
                "lacks speed_m_s or opening_angle_deg", "both, or velocities_m_s with [x, y, z] for each body"
            )
        outward = _outward(net.nodes[nodes, :2] - equipped.center)
        angle = math.radians(section.opening_angle_deg)
        velocities = section.speed_m_s * np.column_stack(
            [math.sin(angle) * outward, np.full(len(particles), -math.cos(angle))]
        )
    return Launch("ejected", tuple(particles), frozen(velocities))


def _velocities(content: Any, count: int, place: Place) -> np.ndarray:
    allowed = f"{count} velocities [x, y, z] in m/s, each component -200 to 200"
    if not isinstance(content, list | tuple) or len(content) != count:
        raise place.error(content, "not a velocity for each body", allowed)
    for i, item in enumerate(content):
        if not isinstance(item, list | tuple) or len(item) != 3:
            raise place[i].error(item, "not three numbers", allowed)
        for j, value in enumerate(item):
            if abs(finite(value, place[i][j], allowed)) > 200.0:
                raise place[i][j].error(value, "out of range", allowed)
    return np.array(content, float)


def _outward(flat: np.ndarray) -> np.ndarray:
    """Unit vectors of flat vectors, 0 where they have no length."""
    length = np.sqrt((flat * flat).sum(axis=1, keepdims=True))
    return np.asarray(np.divide(flat, length, out=np.zeros_like(flat), where=length > 1e-9))


def build_capture(content: Any, closing: Closing, place: Place) -> Capture:
    """What counts as captured.

    Raises:
        DescriptionError: where more pairs are needed than can lock.
    """
    section = read_section(CaptureSection, {} if content is None else content, place)
    most = closing.max_locked_pairs
    needed = section.required_locked_pairs
    if needed is None:
        needed = {"docking": max(most - 2, 1), "winch": math.ceil(2 * most / 3)}.get(closing.kind, 0)
    if needed > most:
        raise (place / "required_locked_pairs").error(needed, f"only {most} pairs can lock", f"0 to {most}")
    return Capture(needed, section.cqi_threshold, section.center_of_mass)


def build_aiming(content: Any, equipped: Equipped, place: Place) -> Aiming:
    """Nominal aiming points: as given, or where each unit is beside the flat net, its thread taut.

    Raises:
        DescriptionError: where there is not one for each unit.
    """
    section = read_section(AimingSection, {} if content is None else content, place)
    units = equipped.units
    if section.offsets_m is None:
        flat = equipped.net.nodes[[unit.node for unit in units], :2].reshape(-1, 2) - equipped.center
        lengths = np.array([unit.thread_length_m for unit in units]).reshape(-1, 1)
        return Aiming(frozen(flat + lengths * _outward(flat)))
    here = place / "offsets_m"
    allowed = f"{len(units)} offsets [x, y] in m, one for each unit"
    if not isinstance(section.offsets_m, list | tuple) or len(section.offsets_m) != len(units):
        raise here.error(section.offsets_m, "not one for each unit", allowed)
    offsets = []
    for i, item in enumerate(section.offsets_m):
        if not isinstance(item, list | tuple) or len(item) != 2:
            raise here[i].error(item, "not two numbers", allowed)
        offsets.append([finite(value, here[i][j], allowed) for j, value in enumerate(item)])
    return Aiming(frozen(np.array(offsets, float).reshape(-1, 2)))
