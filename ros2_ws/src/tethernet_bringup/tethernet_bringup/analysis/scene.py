"""Draws a snapshot in three dimensions, with whatever is in front hiding what is behind.

Every thread and every facet is projected, sorted by its distance from the eye and painted from back to front. The
projection is orthographic: lengths compare across the picture, and one scale bar is true for all of it.

matplotlib's own 3-D axes sort only the parts of one collection so. With all parts in one they make the same picture in
four times the time, and fit a box to the panel, not what is to be seen: frame, labels and scale bar would be as long.
Renderers such as VTK need OpenGL or a browser, which a bare machine has not, and give no lines for SVG and PDF.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from tethernet_bringup.analysis.snapshots import Snapshot
from tethernet_core.rotation import matrix
from tethernet_core.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Color: TypeAlias = "str | np.ndarray"
"""Name, or red, green, blue from 0 to 1, shape (3,)."""

# Okabe and Ito's colours: told apart by everybody, in print too.
MU_COLORS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7", "#8C6D00", "#444444")
_NET_NEAR, _NET_FAR = np.array([0.05, 0.15, 0.35]), np.array([0.62, 0.70, 0.82])
_DEBRIS, _CHASER, _TETHER = np.array([0.80, 0.76, 0.70]), np.array([0.93, 0.80, 0.45]), "#7a5c00"
_LIGHT = np.array([0.55, 0.80, -0.10])
_MASS = np.array([0.5, 0.25, 0.6])
_MARKER = 0.012  # drawn radius of a unit, in sizes of the picture: itself it would hardly be seen
_FACET, _LIFT = 0.02, 0.01
"""Longest side of a drawn facet, and what lifts a thread off the surface that it lies on, in sizes of the picture."""


def mu_color(mu: int) -> str:
    """The colour of an MU, the same in all pictures."""
    return MU_COLORS[(mu - 1) % len(MU_COLORS)]


@dataclass(frozen=True)
class Camera:
    """Looks from far away along one direction."""

    towards_eye: tuple[float, float, float] = (0.80, 0.50, -0.33)
    """From the scene to the eye; the flight along -z then goes from left to right, and y is up."""

    @functools.cached_property
    def axes(self) -> np.ndarray:
        """Rows: right and up on the screen, and towards the eye; shape (3, 3)."""
        eye = np.array(self.towards_eye) / np.linalg.norm(self.towards_eye)
        right = np.cross((0.0, 1.0, 0.0), eye)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(eye, right), eye])

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) [m] as right, up, nearness (..., 3) [m]."""
        return np.asarray(points, dtype=float) @ self.axes.T


@dataclass
class _Painting:
    camera: Camera
    depths: list[float] = field(default_factory=list)
    shapes: list[np.ndarray] = field(default_factory=list)
    faces: list[np.ndarray] = field(default_factory=list)
    edges: list[np.ndarray] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)
    """All of one length; colours are red, green, blue and opacity."""

    def line(self, a: np.ndarray, b: np.ndarray, color: Color, width: float, nearer: float = 0.0) -> None:
        """A thread. ``nearer`` [m] lifts it off the surface that it lies on."""
        ends = self.camera.project(np.stack([a, b]))
        self._add(float(ends[:, 2].mean()) + nearer, ends[:, :2], "none", color, width)

    def polygons(self, corners: np.ndarray, colors: np.ndarray) -> None:
        """Polygons of equally many corners, shape (P, C, 3) [m], and their colours, shape (P, 3)."""
        seen, count = self.camera.project(corners), len(corners)
        opaque = list(np.column_stack([colors, np.ones(count)]))
        self.depths += seen[:, :, 2].mean(axis=1).tolist()
        self.shapes += list(seen[:, :, :2])
        self.faces += opaque
        self.edges += opaque
        self.widths += [0.7] * count

    def disc(self, center: np.ndarray, radius: float, color: Color) -> None:
        x, y, depth = self.camera.project(center)
        angle = np.linspace(0.0, 2.0 * np.pi, 25)
        outline = np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)
        self._add(float(depth) + 2.0 * radius, outline, color, "black", 0.6)

    def finish(self, axes: Axes) -> None:
        from matplotlib.collections import PolyCollection

        order = np.argsort(self.depths, kind="stable")
        axes.add_collection(
            PolyCollection(
                [self.shapes[i] for i in order],
                facecolors=np.array(self.faces)[order],
                edgecolors=np.array(self.edges)[order],
                linewidths=np.array(self.widths)[order],
                closed=False,
                capstyle="round",
            )
        )

    def _add(self, depth: float, shape: np.ndarray, face: Color, edge: Color, width: float) -> None:
        self.depths.append(depth)
        self.shapes.append(shape)
        self.faces.append(_rgba(face))
        self.edges.append(_rgba(edge))
        self.widths.append(width)


def draw(
    axes: Axes, shot: Snapshot, system: System | None, *, wide: bool = False, camera: Camera | None = None
) -> None:
    """Paint a snapshot.

    Args:
        axes: matplotlib axes; their frame is taken away.
        shot: the moment.
        system: what was flown: how the net is tied, the debris' shape; without it, knots and places only.
        wide: show the chaser and all that is between, instead of the surroundings of net and debris.
        camera: where from.
    """
    camera = camera or Camera()
    picture = _frame(axes, camera, _corners(shot, system, wide=wide))
    size = _MARKER * picture
    painting = _Painting(camera)
    place = shot.debris_place if shot.debris is None else shot.debris[:3]
    if shot.debris is not None and system is not None:
        _debris(painting, shot.debris, system, picture)
    elif place is not None:
        _ghost(axes, camera, place, _ghost_radius(system))
    if system is not None and shot.knots is not None and len(shot.knots) == system.net.node_count:
        _net(painting, shot.knots, system.net.threads, picture)
        _hung(painting, shot, system, shot.knots, size)
    elif shot.knots is not None:  # how they are tied is not known
        for knot in shot.knots:
            painting.disc(knot, 0.2 * size, _NET_NEAR)
    _mus(painting, shot, size)
    if shot.chaser is not None and system is not None:
        _chaser(painting, shot, shot.chaser, system)
    painting.finish(axes)
    _labels(axes, camera, shot, size)
    axes.set_title(f"{shot.title}, {shot.time_s:.1f} s", fontsize=10, loc="left")


def _rgba(color: Color) -> np.ndarray:
    """Red, green, blue, opacity; shape (4,)."""
    from matplotlib.colors import to_rgba

    return np.array(list(to_rgba(color))) if isinstance(color, str) else np.append(color, 1.0)


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrix of x y z w, body to launch; the identity for a quaternion that is none."""
    norm = np.linalg.norm(quaternion)
    if not np.isfinite(norm) or norm < 1e-9:
        return np.eye(3)
    return matrix(np.asarray(quaternion) / norm)


def _shade(color: np.ndarray, normal: np.ndarray) -> np.ndarray:
    light = _LIGHT / np.linalg.norm(_LIGHT)
    return np.clip(color * (0.70 + 0.30 * max(float(normal @ light), 0.0)), 0.0, 1.0)


def _debris(painting: _Painting, body: np.ndarray, system: System, picture: float) -> None:
    """The triangles of its surface that face the eye, cut so small that each hides what is behind it."""
    debris = system.debris
    vertices, faces = debris.shape.triangles()
    turn = rotation(body[3:])
    corners = (body[:3] + (vertices - debris.center_of_mass) @ turn.T)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    seen = (normals @ painting.camera.axes[2] > 0.0) & (lengths > 0.0)
    colors = [_shade(_DEBRIS, normal / length) for normal, length in zip(normals[seen], lengths[seen], strict=True)]
    pieces, triangle = _cut(corners[seen], _FACET * picture)
    painting.polygons(pieces, np.array(colors).reshape(-1, 3)[triangle])


def _cut(triangles: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (T, 3, 3) as triangles whose sides are no longer than ``longest`` [m], shape (P, 3, 3), and of which
    one each is a piece, shape (P,). The longest side is halved until it is short enough.
    """
    pieces, owners = [], []
    waiting, owner = triangles, np.arange(len(triangles))
    while len(waiting):
        sides = np.linalg.norm(waiting - np.roll(waiting, -1, axis=1), axis=2)
        side = np.argmax(sides, axis=1)
        small = sides.max(axis=1) <= longest
        pieces.append(waiting[small])
        owners.append(owner[small])
        turned = (side[~small, None] + np.arange(3)) % 3
        a, b, c = (waiting[~small][np.arange(len(turned)), turned[:, corner]] for corner in range(3))
        middle = 0.5 * (a + b)
        waiting = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        owner = np.concatenate([owner[~small]] * 2)
    return np.concatenate([np.zeros((0, 3, 3)), *pieces]), np.concatenate([np.zeros(0, int), *owners])


def _ghost(axes: Axes, camera: Camera, place: np.ndarray, radius: float) -> None:
    """The debris where only its place is known: a circle, since nobody told how it lies."""
    from matplotlib.patches import Circle

    x, y, _ = camera.project(place)
    axes.add_patch(Circle((x, y), radius, facecolor="none", edgecolor="gray", linestyle="--"))
    axes.text(x, y - 1.15 * radius, "debris\n(attitude unknown)", ha="center", va="top", fontsize=7, color="gray")


def _net(painting: _Painting, knots: np.ndarray, threads: np.ndarray, picture: float) -> None:
    depth = painting.camera.project(knots)[..., 2]
    near, far = float(depth.max()), float(depth.min())
    shares = (near - 0.5 * (depth[threads[:, 0]] + depth[threads[:, 1]])) / max(near - far, 1e-6)
    for (a, b), share in zip(threads.tolist(), shares.tolist(), strict=True):
        color = (1.0 - share) * _NET_NEAR + share * _NET_FAR
        painting.line(knots[a], knots[b], color, 0.75 - 0.25 * share, nearer=_LIFT * picture)


def _mus(painting: _Painting, shot: Snapshot, size: float) -> None:
    for mu, trail in shot.trails.items():
        thinned = trail[:: max(1, len(trail) // 80)]
        pale = 0.45 * np.array(_rgb(mu_color(mu))) + 0.55
        for a, b in itertools.pairwise(thinned):
            painting.line(a, b, pale, 0.8)
    for mu, place in shot.mus.items():
        painting.disc(place, size, mu_color(mu))


def _hung(painting: _Painting, shot: Snapshot, system: System, knots: np.ndarray, size: float) -> None:
    """Threads of the units, and masses at nodes."""
    for mu, place in shot.mus.items():
        if mu <= system.unit_count:
            painting.line(place, knots[system.units[mu - 1].node], mu_color(mu), 1.2, nearer=0.8 * size)
    for mass in system.net.point_masses:
        painting.disc(knots[mass.node], 0.7 * size, _MASS)


def _chaser(painting: _Painting, shot: Snapshot, body: np.ndarray, system: System) -> None:
    turn, center, half = rotation(body[3:]), body[:3], system.chaser.side_m / 2.0
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = np.zeros(3)
            normal[axis] = sign
            if (turn @ normal) @ painting.camera.axes[2] <= 0.0:
                continue
            u, v = np.roll(np.eye(3), -axis - 1, axis=0)[:2]
            square = np.array([normal + a * u + b * v for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]) * half
            painting.polygons((center + square @ turn.T)[None], _shade(_CHASER, turn @ normal)[None])
    tied = system.tether.stiffness_n_m > 0.0 and shot.knots is not None and len(shot.knots) == system.net.node_count
    if tied and shot.knots is not None:
        anchor = center + turn @ np.array([0.0, 0.0, system.chaser.anchor_m])
        for a, b in _pieces(anchor, shot.knots[system.net.center_node], 60):
            painting.line(a, b, _TETHER, 0.9)


def _pieces(a: np.ndarray, b: np.ndarray, count: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    points = a + np.linspace(0.0, 1.0, count + 1)[:, None] * (b - a)
    return itertools.pairwise(points)


def _labels(axes: Axes, camera: Camera, shot: Snapshot, size: float) -> None:
    """Numbers of the MUs beside them; those that lie together share one label."""
    from matplotlib.patheffects import withStroke

    groups: list[tuple[np.ndarray, list[int]]] = []
    for mu in sorted(shot.mus):
        place = camera.project(shot.mus[mu])[:2]
        for there, members in groups:
            if np.linalg.norm(there - place) < 3.0 * size:
                members.append(mu)
                break
        else:
            groups.append((place, [mu]))
    middle = np.mean([place for place, _ in groups], axis=0) if groups else np.zeros(2)
    for place, members in groups:
        away = place - middle
        distance = float(np.linalg.norm(away))
        direction = away / distance if distance > size else np.array([0.6, 0.8])
        x, y = place + 2.6 * size * direction
        axes.text(
            x, y, _named(members), fontsize=8, fontweight="bold",
            color=mu_color(members[0]) if len(members) == 1 else "black", va="center",
            ha="center" if len(members) == 1 else "left", path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )  # fmt: skip


def _named(members: list[int]) -> str:
    if len(members) == 1:
        return str(members[0])
    if members == list(range(members[0], members[-1] + 1)):
        return f"MU {members[0]} to {members[-1]}"
    return "MU " + " ".join(map(str, members))


def _ghost_radius(system: System | None) -> float:
    return 1.0 if system is None else 0.5 * float(np.cbrt(system.debris.shape.volume_m3))


def _corners(shot: Snapshot, system: System | None, *, wide: bool) -> np.ndarray:
    """Points that the picture has to show [m]."""
    parts = [place[None] for place in shot.mus.values()]
    if shot.knots is not None:
        parts.append(shot.knots)
    if shot.debris is not None and system is not None and (wide or not parts or shot.title != "early deployment"):
        vertices, _ = system.debris.shape.triangles()
        parts.append(shot.debris[:3] + (vertices - system.debris.center_of_mass) @ rotation(shot.debris[3:]).T)
    elif (place := shot.debris_place if shot.debris is None else shot.debris[:3]) is not None:
        parts.append(place + 1.5 * _ghost_radius(system) * np.vstack([np.eye(3), -np.eye(3)]))
    if wide:
        parts.append(np.zeros((1, 3)) if shot.chaser is None else shot.chaser[None, :3])
    return np.concatenate(parts) if parts else np.zeros((1, 3))


def _frame(axes: Axes, camera: Camera, points: np.ndarray) -> float:
    """Fit the picture to the points, with equal scales, a scale bar and the directions of the axes.

    Returns:
        The picture's size, of its shorter side roughly [m].
    """
    seen = camera.project(points)[:, :2]
    margin = 0.05 * float(np.ptp(seen, axis=0).max()) + 1e-3
    low, high = seen.min(axis=0) - margin, seen.max(axis=0) + margin
    box = axes.get_window_extent()
    aspect = box.width / box.height if box.height > 0 else 1.0
    size, middle = high - low, 0.5 * (low + high)
    width = max(size[0], size[1] * aspect)
    height = width / aspect
    axes.set_xlim(middle[0] - width / 2, middle[0] + width / 2)
    axes.set_ylim(middle[1] - height / 2, middle[1] + height / 2)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    left, bottom = middle[0] - width / 2, middle[1] - height / 2
    bar = _round_length(0.25 * width)
    x0, y0 = left + 0.03 * width, bottom + 0.05 * height
    axes.plot([x0, x0 + bar], [y0, y0], color="black", linewidth=2.0, solid_capstyle="butt")
    axes.text(x0 + bar / 2, y0 + 0.012 * width, f"{bar:g} m", ha="center", va="bottom", fontsize=8)
    arm = 0.06 * min(width, 1.3 * height)
    root = np.array([x0 + 1.4 * arm, y0 + 2.4 * arm])
    for axis, name in enumerate("xyz"):
        direction = camera.project(np.eye(3)[axis])[:2] * arm
        tip, arrow = tuple(root + direction), {"arrowstyle": "-|>", "color": "gray", "lw": 0.8}
        axes.annotate("", tip, tuple(root), arrowprops=arrow)
        x, y = root + 1.35 * direction
        axes.text(x, y, name, color="gray", fontsize=7, ha="center", va="center")
    return min(width, 1.4 * height)


def _round_length(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is no longer [m]."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= length))


def _rgb(color: str) -> tuple[float, float, float]:
    red, green, blue = (int(color[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return (red, green, blue)
