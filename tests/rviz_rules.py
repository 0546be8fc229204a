"""What RViz warns of in markers, by their types, and what it needs of transforms; messages are taken as decoded."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any

ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TEXT, MESH, TRIANGLES = range(12)
ADD = 0

SCALES = {
    ARROW: "xyz", CUBE: "xyz", SPHERE: "xyz", CYLINDER: "xyz", LINE_STRIP: "x", LINE_LIST: "x", CUBE_LIST: "xyz",
    SPHERE_LIST: "xyz", POINTS: "xy", TEXT: "z", MESH: "xyz", TRIANGLES: "xyz",
}  # fmt: skip
"""Which components of its scale a type uses; the others have to be 0."""
POINT_COUNTS = {LINE_STRIP: 1, LINE_LIST: 2, CUBE_LIST: 1, SPHERE_LIST: 1, POINTS: 1, TRIANGLES: 3}
"""Types that are made of points, and of how many at a time."""


def marker_warnings(marker: Any) -> list[str]:
    """What RViz says of one marker that is added; empty where it is in order."""
    if marker.action != ADD:
        return []
    found = []
    if marker.type not in SCALES:
        return [f"type {marker.type} is unknown"]
    if not marker.header.frame_id:
        found.append("no frame")
    if not (marker.lifetime.sec > 0 or marker.lifetime.nanosec > 0):
        found.append("no lifetime")
    if not is_normalised(marker.pose.orientation):
        found.append("quaternion not normalised")
    if not all(map(math.isfinite, _xyz(marker.pose.position))):
        found.append("position not finite")
    for axis in "xyz":
        scale = getattr(marker.scale, axis)
        if axis in SCALES[marker.type] and not (scale > 0.0 and math.isfinite(scale)):
            found.append(f"scale.{axis} is {scale}")
        elif axis not in SCALES[marker.type] and scale != 0.0:
            found.append(f"scale.{axis} is set and not used")
    return found + _points(marker) + _colors(marker) + _texts(marker)


def _points(marker: Any) -> list[str]:
    points, group = marker.points, POINT_COUNTS.get(marker.type)
    found = []
    if group is None and len(points) and not (marker.type == ARROW and len(points) == 2):
        found.append(f"{len(points)} points that are ignored")
    if group is not None and (not len(points) or len(points) % group):
        found.append(f"{len(points)} points; needed: a multiple of {group}")
    if marker.type == LINE_STRIP and len(points) < 2:
        found.append("a strip of fewer than two points")
    if not all(math.isfinite(value) for point in points for value in _xyz(point)):
        found.append("a point is not finite")
    return found


def _colors(marker: Any) -> list[str]:
    if len(marker.colors):
        counts = {len(marker.points), len(marker.points) // (3 if marker.type == TRIANGLES else 1)}
        if marker.type not in POINT_COUNTS or len(marker.colors) not in counts:
            return ["colors do not match points"]
    every = marker.colors if len(marker.colors) else [marker.color]
    in_range = all(0.0 <= value <= 1.0 for color in every for value in (color.r, color.g, color.b, color.a))
    return [] if in_range and all(color.a > 0.0 for color in every) else ["transparent, or a color out of range"]


def _texts(marker: Any) -> list[str]:
    found = []
    if (marker.type == TEXT) != bool(marker.text.strip()):
        found.append("text")
    if (marker.type == MESH) != bool(marker.mesh_resource):
        found.append("mesh_resource")
    return found


def array_warnings(markers: Iterable[Any]) -> list[str]:
    """What RViz says of an array of markers, and of each of them by namespace and id."""
    markers = list(markers)
    names = Counter((marker.ns, marker.id) for marker in markers)
    found = [f"{name} is there {count} times" for name, count in names.items() if count > 1]
    kinds: dict[str, set[int]] = {}
    for marker in markers:
        kinds.setdefault(marker.ns, set()).add(marker.type)
        found += [f"{marker.ns}/{marker.id}: {warning}" for warning in marker_warnings(marker)]
    return found + [f"{name} is of several types" for name, types in kinds.items() if len(types) > 1 or not name]


def is_normalised(turn: Any) -> bool:
    """Whether a quaternion is of length 1, as far as RViz looks."""
    return abs(turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2 - 1.0) < 1e-6


def frames(value: Any) -> Iterator[str]:
    """All frames that a decoded message names anywhere."""
    if hasattr(value, "__dataclass_fields__"):
        for name in value.__dataclass_fields__:
            item = getattr(value, name)
            if name in {"frame_id", "child_frame_id"}:
                yield item
            elif name != "texture" or len(item.data):  # of a marker that has none
                yield from frames(item)
    elif isinstance(value, list):
        for item in value:
            yield from frames(item)


def tree(transforms: Iterable[tuple[str, str]]) -> dict[str, str]:
    """The parent of each frame.

    Args:
        transforms: parent and child of each.

    Raises:
        ValueError: a frame has two parents, or is its own ancestor.
    """
    parents: dict[str, str] = {}
    for parent, child in transforms:
        if parents.setdefault(child, parent) != parent:
            raise ValueError(f"frame {child} has the parents {parents[child]} and {parent}")
    for child in parents:
        root(parents, child)
    return parents


def root(parents: dict[str, str], frame: str) -> str:
    """The frame at the end of a frame's ancestors.

    Raises:
        ValueError: when there is none, because they go round in a circle.
    """
    seen = {frame}
    while frame in parents:
        frame = parents[frame]
        if frame in seen:
            raise ValueError(f"frame {frame} is its own ancestor")
        seen.add(frame)
    return frame


def _xyz(point: Any) -> tuple[float, float, float]:
    return point.x, point.y, point.z
