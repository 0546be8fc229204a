"""How people address a node: by number, by row and column, by corner or side, or by where it lies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..near_match import near_match
from .entries import finite
from .errors import Place
from .lattices import FlatNet
from .sections import NODE_FORM

_WORDS = {"first": 0, "last": -1}


def node_number(address: Any, net: FlatNet, place: Place) -> int:
    """The node that an address means.

    Args:
        address: as in a description.
        net: its nodes, corners, rows and columns.
        place: for errors.

    Raises:
        DescriptionError: for an address of no form, or of no node of this net.
    """
    if address == "center":
        return middle_node(net)
    if isinstance(address, int) and not isinstance(address, bool):
        if not 0 <= address < len(net.nodes):
            raise place.error(address, "no such node", f"0 to {len(net.nodes) - 1}, or {NODE_FORM}")
        return address
    if not isinstance(address, Mapping):
        raise place.error(address, "not a node", NODE_FORM)
    keys = set(address)
    if keys == {"row", "column"}:
        return _by_row_and_column(address, net, place)
    if keys == {"corner"}:
        return _by_corner(address["corner"], net.corners, net, place / "corner")
    if keys == {"side"}:
        return _by_corner(address["side"], net.sides, net, place / "side")
    if keys == {"near"}:
        return _nearest(address["near"], net, place / "near")
    unknown = sorted(str(key) for key in keys - {"row", "column", "corner", "side", "near"})
    hint = near_match(unknown[0], ["row", "column", "corner", "side", "near"]) if unknown else ""
    raise place.error(dict(address), f"not an address of a node{hint}", NODE_FORM)


def middle_node(net: FlatNet) -> int:
    """The node nearest to the middle of the net, the first one of several."""
    flat = net.nodes[:, :2]
    middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0)) if net.grid else flat.mean(axis=0)
    squared = ((flat - middle) ** 2).sum(axis=1)
    return int(np.flatnonzero(squared <= squared.min() + 1e-9 * net.mesh_m**2)[0])


def _by_row_and_column(address: Mapping[str, Any], net: FlatNet, place: Place) -> int:
    if net.grid is None:
        raise place.error(dict(address), "this net has no rows and columns", "a node number, {near: [x, y]}, or center")
    rows, columns = net.grid
    row = _index(address["row"], rows, place / "row")
    return row * columns + _index(address["column"], columns, place / "column")


def _index(value: Any, count: int, place: Place) -> int:
    allowed = f"0 to {count - 1}, -1 to {-count} from the end, or first, middle, last"
    if value == "middle":
        return count // 2
    number = _WORDS.get(value, value) if isinstance(value, str) else value
    if isinstance(number, bool) or not isinstance(number, int) or not -count <= number < count:
        raise place.error(value, "no such line of nodes", allowed)
    return number % count


def _by_corner(value: Any, nodes: tuple[int, ...], net: FlatNet, place: Place) -> int:
    if not nodes:
        raise place.error(value, "this net has no corners of its own", "a node number, {near: [x, y]}, or center")
    if net.grid and isinstance(value, list) and place.path.endswith("corner"):
        if len(value) == 2 and all(word in _WORDS for word in value if isinstance(word, str)):
            rows, columns = net.grid
            row, column = (_WORDS.get(word, 1) if isinstance(word, str) else word for word in value)
            if row in (0, -1) and column in (0, -1):
                return int(row % rows * columns + column % columns)
        raise place.error(value, "no corner", "[first or last row, first or last column]")
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < len(nodes):
        raise place.error(value, "no such one", f"0 to {len(nodes) - 1}, counter-clockwise")
    return nodes[value]


def _nearest(value: Any, net: FlatNet, place: Place) -> int:
    allowed = "[x, y] in the flat net [m], the net's middle at 0, 0"
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise place.error(value, "no flat position", allowed)
    position = np.array([finite(item, place[i], allowed) for i, item in enumerate(value)])
    return int(((net.nodes[:, :2] - position) ** 2).sum(axis=1).argmin())
