"""A closed triangle mesh from a file, with a grid of signed distances."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from .arithmetic import larger, root, select, smaller, whole
from .mesh_check import check_surface
from .mesh_grid import distance_grid
from .shape import LARGEST_M, SMALLEST_M, Shape, ShapeError, checked_number, entry_error, unknown_entries

FORMATS = (".stl", ".obj")
MOST_BYTES = 64 * 1024 * 1024
MOST_FACES = 20_000
"""The grid of distances is no finer than what this many faces show, and takes seconds to build for them."""
_HEAD = 7
"""Numbers before the grid's values: origin, spacing, nodes along x, y and z."""


def surface(p: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any, Any]:
    """Signed distance of a point from the mesh [m], negative inside, and the outward unit normal there.

    Trilinear between the nodes of the grid; beyond it a little too large, by a few per cent.

    Args:
        p: origin of the grid and its spacing [m], its nodes along x, y and z, distances at the nodes, z fastest [m].
        x: of the point [m].
        y: of the point [m].
        z: of the point [m].
    """
    spacing = p[3]
    inverse = 1.0 / spacing
    last_x, last_y, last_z = p[4] - 1.0, p[5] - 1.0, p[6] - 1.0
    gx, gy, gz = (x - p[0]) * inverse, (y - p[1]) * inverse, (z - p[2]) * inverse
    cx, cy, cz = (
        smaller(larger(gx, 0.0), last_x),
        smaller(larger(gy, 0.0), last_y),
        smaller(larger(gz, 0.0), last_z),
    )
    i, j, k = (
        whole(smaller(cx, last_x - 0.5)),
        whole(smaller(cy, last_y - 0.5)),
        whole(smaller(cz, last_z - 0.5)),
    )
    u, v, w = cx - i, cy - j, cz - k
    along_y = whole(p[6] + 0.5)
    along_x = whole(p[5] * p[6] + 0.5)
    at = _HEAD + i * along_x + j * along_y + k
    a000, a001, a010, a011 = p[at], p[at + 1], p[at + along_y], p[at + along_y + 1]
    at = at + along_x
    a100, a101, a110, a111 = p[at], p[at + 1], p[at + along_y], p[at + along_y + 1]
    # Along z first, then y, then x; slopes on the way.
    b00, b01, b10, b11 = (
        a000 + w * (a001 - a000),
        a010 + w * (a011 - a010),
        a100 + w * (a101 - a100),
        (a110 + w * (a111 - a110)),
    )
    c0, c1 = b00 + v * (b01 - b00), b10 + v * (b11 - b10)
    distance = c0 + u * (c1 - c0)
    nx = c1 - c0
    ny = (b01 - b00) + u * ((b11 - b10) - (b01 - b00))
    d0 = (a001 - a000) + v * ((a011 - a010) - (a001 - a000))
    d1 = (a101 - a100) + v * ((a111 - a110) - (a101 - a100))
    nz = d0 + u * (d1 - d0)
    squared = nx * nx + ny * ny + nz * nz
    # Where all around is equally far there is no nearest point: z is as good as any direction.
    nz = select(squared < 1e-24, 1.0, nz)
    share = 1.0 / root(larger(nx * nx + ny * ny + nz * nz, 1e-30))
    nx, ny, nz = nx * share, ny * share, nz * share
    # Beyond the grid: the way from the surface point that is nearest to the grid's nearest point.
    ox, oy, oz = spacing * (gx - cx), spacing * (gy - cy), spacing * (gz - cz)
    beyond = ox * ox + oy * oy + oz * oz > 0.0
    wx, wy, wz = ox + distance * nx, oy + distance * ny, oz + distance * nz
    length = root(larger(wx * wx + wy * wy + wz * wz, 1e-30))
    share = 1.0 / length
    return (
        select(beyond, length, distance),
        select(beyond, wx * share, nx),
        select(beyond, wy * share, ny),
        select(beyond, wz * share, nz),
    )


@dataclass(frozen=True, eq=False)
class Mesh(Shape):
    """A closed triangle mesh.

    Mass properties, reach, rays and triangles are the mesh's own. The distance is interpolated in a grid of about a
    million nodes that is built once and kept. Its error is at most 0.87 of the grid's spacing (that is next to a sharp
    edge or corner, which the grid rounds off), at most a quarter of the spacing squared over the radius of curvature on
    a curved face, and none on a flat one that no edge is near.
    """

    kind: ClassVar[str] = "mesh"
    convex: ClassVar[bool] = False

    vertices: np.ndarray
    """[m], shape (V, 3)."""
    faces: np.ndarray
    """Counter-clockwise from outside, shape (F, 3)."""
    file: str = ""
    """Where it was read."""
    unit_m: float = 1.0
    """The file's unit of length [m]."""

    def __post_init__(self) -> None:
        """Check that the surface is closed.

        Raises:
            ShapeError: for an open, self-crossing or inverted surface, with what is wrong and where.
        """
        vertices, faces = np.array(self.vertices, float), np.array(self.faces, np.int64)
        name = "file" if self.file else "mesh"
        if vertices.ndim != 2 or vertices.shape[1:] != (3,) or faces.ndim != 2 or faces.shape[1:] != (3,):
            raise ShapeError(f"{name}: not vertices of shape (V, 3) and faces of shape (F, 3)")
        if not 4 <= len(faces) <= MOST_FACES:
            raise ShapeError(f"{name} has {len(faces)} faces; allowed: 4 to {MOST_FACES}, simplify it")
        if not np.isfinite(vertices).all():
            raise ShapeError(f"{name}: a vertex is not finite")
        size = np.ptp(vertices, axis=0).max()
        if not SMALLEST_M <= size <= LARGEST_M:
            raise ShapeError(f"{name} is {size:g} m large; allowed: {SMALLEST_M:g} to {LARGEST_M:g} m, see unit_m")
        check_surface(name, vertices, faces)
        for field, value in (("vertices", vertices), ("faces", faces)):
            value.setflags(write=False)
            object.__setattr__(self, field, value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mesh) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    @classmethod
    def from_entries(cls, entries: Mapping[str, Any], folder: Path | None) -> Mesh:
        unknown_entries(entries, ("file", "unit_m"), cls.kind)
        allowed = f"the name of a file of triangles, {' or '.join(FORMATS)}, of at most {MOST_BYTES // 2**20} MiB"
        name = entries.get("file")
        if not isinstance(name, str) or not name:
            raise entry_error("file", name, "no name of a file", allowed)
        unit = checked_number("unit_m", entries.get("unit_m", 1.0), 1e-6, 1e3, "m")
        path = Path(name) if folder is None else folder / name
        if path.suffix.lower() not in FORMATS:
            raise entry_error("file", name, "of another format", allowed)
        vertices, faces = _read(path, name, allowed)
        return cls(vertices * unit, faces, str(path), unit)

    def entries(self) -> dict[str, Any]:
        return {"kind": self.kind, "file": self.file, "unit_m": self.unit_m}

    @functools.cached_property
    def digest(self) -> str:
        corners = np.ascontiguousarray(self.vertices[self.faces], "<f8")
        return hashlib.sha256(self.kind.encode() + corners.tobytes()).hexdigest()[:16]

    @functools.cached_property
    def numbers(self) -> np.ndarray:
        origin, spacing, values = distance_grid(self.vertices, self.faces, self.digest)
        numbers = np.concatenate([origin, [spacing], np.array(values.shape, float), values.ravel()])
        numbers.setflags(write=False)
        return numbers

    @property
    def spacing_m(self) -> float:
        """Of the grid of distances [m]."""
        return float(self.numbers[3])

    @functools.cached_property
    def _trimesh(self) -> Any:
        import trimesh

        return trimesh.Trimesh(self.vertices, self.faces, process=False)

    @property
    def volume_m3(self) -> float:
        return float(self._trimesh.volume)

    @property
    def area_m2(self) -> float:
        return float(self._trimesh.area)

    @functools.cached_property
    def centroid(self) -> np.ndarray:
        return np.array(self._trimesh.center_mass, float)

    @functools.cached_property
    def inertia_per_mass(self) -> np.ndarray:
        tensor = np.array(self._trimesh.moment_inertia, float) / self.volume_m3
        return 0.5 * (tensor + tensor.T)

    @functools.cached_property
    def extent_m(self) -> float:
        from scipy.spatial import ConvexHull

        corners = self.vertices[ConvexHull(self.vertices).vertices]
        blocks = np.array_split(corners, max(1, len(corners) ** 2 // 1_000_000))
        return max(float(np.linalg.norm(block[:, None] - corners[None], axis=-1).max()) for block in blocks)

    def reach_from(self, point: np.ndarray) -> float:
        return float(np.linalg.norm(self.vertices - np.asarray(point, float), axis=1).max())

    def ray_exit(self, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        # Moeller and Trumbore, Journal of Graphics Tools 2 (1997); edges belong to both faces.
        directions = np.asarray(directions, float)
        a, b, c = (self.vertices[self.faces[:, corner]] for corner in range(3))
        first, second, arm = b - a, c - a, np.asarray(origin, float) - a
        across = np.cross(arm, first)
        rays = directions.reshape(-1, 3)
        exits = np.zeros(len(rays))
        for index, ray in enumerate(rays):
            normal = np.cross(ray, second)
            with np.errstate(divide="ignore", invalid="ignore"):
                inverse = 1.0 / np.einsum("ij,ij->i", first, normal)
                u = np.einsum("ij,ij->i", arm, normal) * inverse
                v = across @ ray * inverse
                t = np.einsum("ij,ij->i", second, across) * inverse
                met = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9) & (t > 0.0)
            exits[index] = t[met].max(initial=0.0)
        return exits.reshape(directions.shape[:-1])

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        return self.vertices, self.faces


def _read(path: Path, name: str, allowed: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices, equal ones merged, and faces of a file.

    Raises:
        ShapeError: when it cannot be read or holds no triangles.
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise entry_error("file", name, f"cannot be read ({error.strerror})", allowed) from error
    if size > MOST_BYTES:
        raise entry_error("file", name, f"holds {size / 2**20:.0f} MiB", allowed)
    import trimesh

    try:
        loaded = trimesh.load_mesh(path, process=False, skip_materials=True)
        vertices, faces = np.array(loaded.vertices, float), np.array(loaded.faces, np.int64)
    except Exception as error:  # whatever a parser stumbles over in a broken file
        problem = f"is no mesh ({' '.join(str(error).split())[:100] or type(error).__name__})"
        raise entry_error("file", name, problem, allowed) from error
    if len(faces) == 0:
        raise entry_error("file", name, "holds no triangles", allowed)
    # A file of this format repeats a vertex in each of its faces.
    scale = max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    _, first, number = np.unique(np.round(vertices / scale, 9), axis=0, return_index=True, return_inverse=True)
    faces = number.reshape(-1)[faces]
    collapsed = (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    return vertices[first], faces[~collapsed]
