"""Triangle meshes: read, refused, and as good as the body that they stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from tethernet_core.shapes import Box, Cylinder, Mesh, ShapeError, mesh_grid, shape_from
from tethernet_core.shapes.mesh_grid import closest_on_triangle


@pytest.fixture(autouse=True)
def _own_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_grid, "cache_folder", lambda: tmp_path / "grids")


@pytest.fixture(name="coarse")
def _coarse(monkeypatch):
    """Grids that take less than a second."""
    monkeypatch.setattr(mesh_grid, "MOST_NODES", 2**15)


def turned_box() -> Mesh:
    turn = trimesh.transformations.rotation_matrix(0.5, [1.0, 2.0, 3.0])
    box = trimesh.creation.box((1.0, 2.0, 3.0), transform=turn)
    return Mesh(box.vertices, box.faces)


def l_shape() -> tuple[np.ndarray, np.ndarray]:
    """A prism over an L, with a concave edge."""
    outline = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])
    floor = np.array([[0, 3, 1], [1, 3, 2], [0, 5, 4], [0, 4, 3]])  # seen from below
    vertices = np.concatenate([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 1.0)])
    sides = [f for i in range(6) for j in [(i + 1) % 6] for f in ((i, j, j + 6), (i, j + 6, i + 6))]
    return vertices, np.concatenate([floor[:, ::-1] * 0 + floor, floor[:, ::-1] + 6, sides])


def test_the_mesh_of_a_cylinder_is_close_to_the_cylinder():
    cylinder = Cylinder(1.95, 11.1)
    mesh = Mesh(*cylinder.triangles())
    assert mesh.volume_m3 == pytest.approx(cylinder.volume_m3, rel=2e-3)
    assert mesh.area_m2 == pytest.approx(cylinder.area_m2, rel=2e-3)
    np.testing.assert_allclose(mesh.inertia_per_mass, cylinder.inertia_per_mass, rtol=3e-3, atol=1e-9)
    np.testing.assert_allclose(mesh.centroid, 0.0, atol=1e-9)
    assert mesh.extent_m == pytest.approx(cylinder.extent_m, rel=1e-3)
    assert mesh.reach_m == pytest.approx(cylinder.reach_m, rel=1e-6)
    rays = np.random.default_rng(1).normal(size=(300, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    np.testing.assert_allclose(mesh.exit_distance(rays), cylinder.exit_distance(rays), rtol=3e-3)
    points = np.random.default_rng(2).uniform(-1.3, 1.3, (20_000, 3)) * [1.95, 1.95, 5.55]
    expected, normal = cylinder.distance(points)
    distance, got = mesh.distance(points)
    polygon = 1.95 * (1.0 - math.cos(math.pi / 64))  # how far the polygon is inside the circle
    inside_grid = (np.abs(points) < [2.1, 2.1, 5.7]).all(axis=1)
    assert (distance >= expected - 0.87 * mesh.spacing_m).all()
    assert (distance <= expected + 0.05 * np.abs(expected) + 0.87 * mesh.spacing_m).all()
    error = np.abs(distance - expected)[inside_grid]
    expected, points, normal, got = (part[inside_grid] for part in (expected, points, normal, got))
    assert error.max() < 0.87 * mesh.spacing_m + polygon, "the bound that the documentation gives"
    assert np.median(error) < 0.005
    near = (np.abs(expected) < 0.3) & (np.abs(points[:, 2]) < 5.0)  # the side, away from the rims
    assert error[near].max() < 0.01
    assert np.einsum("ij,ij->i", normal, got)[near].min() > math.cos(0.06)  # half a side of the polygon, and rounding


def test_flat_faces_are_exact_however_they_lie(coarse):
    mesh = turned_box()
    turn = trimesh.transformations.rotation_matrix(0.5, [1.0, 2.0, 3.0])[:3, :3]
    box = Box((1.0, 2.0, 3.0))
    points = np.random.default_rng(3).uniform(-2.0, 2.0, (20_000, 3))
    expected, normal = box.distance(points @ turn)
    distance, got = mesh.distance(points)
    assert np.abs(distance - expected)[np.abs(expected) < 0.1].max() < 0.87 * mesh.spacing_m
    # Well inside a face's area, and near it.
    local = np.sort(np.abs(points @ turn) / [0.5, 1.0, 1.5], axis=1)
    face = (np.abs(expected) < 0.05) & (local[:, 1] < 0.35)
    assert face.sum() > 30
    np.testing.assert_allclose(distance[face], expected[face], atol=1e-9)
    np.testing.assert_allclose(got[face], normal[face] @ turn.T, atol=1e-9)


def test_a_concave_edge_has_the_right_sides(coarse):
    mesh = Mesh(*l_shape())
    assert mesh.volume_m3 == pytest.approx(4.0)
    inside = np.array([[0.5, 1.5, 0.5], [2.0, 0.5, 0.5], [0.5, 0.5, 0.5], [0.95, 0.95, 0.5]])
    outside = np.array([[1.5, 1.5, 0.5], [1.2, 1.2, 0.5], [-0.5, 1.0, 0.5], [0.5, 0.5, 1.3], [9.0, 9.0, 9.0]])
    assert (mesh.distance(inside)[0] < 0.0).all()
    assert (mesh.distance(outside)[0] > 0.0).all()
    np.testing.assert_allclose(mesh.distance(np.array([1.5, 1.5, 0.5]))[0], 0.5, atol=0.87 * mesh.spacing_m)


def test_every_node_of_the_grid_has_the_distance_of_the_nearest_face(coarse):
    vertices, faces = l_shape()
    origin, spacing, values = mesh_grid.build_grid(vertices, faces)
    index = np.argwhere(np.ones(values.shape, bool))
    points = origin + spacing * index
    nearest = np.full(len(points), np.inf)
    for corners in vertices[faces]:
        foot, _ = closest_on_triangle(points, corners)
        nearest = np.minimum(nearest, np.linalg.norm(points - foot, axis=1))
    got = np.abs(values.ravel())
    close = nearest < mesh_grid.BAND * spacing
    np.testing.assert_allclose(got[close], nearest[close], atol=1e-12)
    assert (got >= nearest - 1e-12).all()
    assert (got <= nearest + spacing).all()
    x, y, z = points.T
    within = (z > 0) & (z < 1) & (x > 0) & (y > 0) & (((x < 3) & (y < 1)) | ((x < 1) & (y < 2)))
    np.testing.assert_array_equal(values.ravel() < 0.0, within & (nearest > 0.0))


def test_the_grid_is_built_once(coarse, monkeypatch):
    first = turned_box().numbers
    monkeypatch.setattr(mesh_grid, "build_grid", lambda *_: pytest.fail("it is in the cache"))
    np.testing.assert_array_equal(turned_box().numbers, first)


def test_a_damaged_grid_is_built_again(coarse):
    mesh = turned_box()
    first = mesh.numbers
    (path,) = mesh_grid.cache_folder().iterdir()
    path.write_bytes(path.read_bytes()[:1000])
    np.testing.assert_array_equal(turned_box().numbers, first)


@pytest.mark.parametrize("ending", [".stl", ".obj"])
def test_a_file_makes_the_mesh(tmp_path, ending):
    trimesh.creation.box((1000.0, 2000.0, 3000.0)).export(tmp_path / f"box{ending}")
    mesh = shape_from({"kind": "mesh", "file": f"box{ending}", "unit_m": 1e-3}, folder=tmp_path)
    assert mesh.volume_m3 == pytest.approx(6.0)
    np.testing.assert_allclose(mesh.inertia_per_mass, Box((1.0, 2.0, 3.0)).inertia_per_mass, atol=1e-9)
    again = shape_from(mesh.entries())
    assert again == mesh and again.digest == mesh.digest


def refused(vertices, faces) -> str:
    with pytest.raises(ShapeError) as caught:
        Mesh(vertices, faces)
    return str(caught.value)


def test_an_open_mesh_is_refused_with_its_hole():
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    message = refused(box.vertices, box.faces[1:])
    assert "is open: 3 edges belong to one face only, the first, of face" in message
    assert "from (" in message and "m to (" in message


def test_an_inverted_mesh_is_refused():
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    assert "inside out (volume -6 m^3)" in refused(box.vertices, box.faces[:, ::-1])


def test_one_face_turned_over_is_refused():
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    faces = np.array(box.faces)
    faces[5] = faces[5, ::-1]
    message = refused(box.vertices, faces)
    assert "are turned to opposite sides" in message and "5" in message


def test_a_mesh_that_crosses_itself_is_refused_with_the_place():
    one, other = trimesh.creation.box((1.0, 1.0, 1.0)), trimesh.creation.box((1.0, 1.0, 1.0))
    other.apply_transform(trimesh.transformations.rotation_matrix(0.4, [0.3, 1.0, 0.2]))
    other.apply_translation((0.4, 0.3, 0.2))
    both = trimesh.util.concatenate([one, other])
    message = refused(both.vertices, both.faces)
    assert (
        "crosses itself: face" in message
        and "goes through face" in message
        and "describe bodies that overlap" in message
    )


def test_bodies_apart_are_one_mesh(coarse):
    one, other = trimesh.creation.box((1.0, 1.0, 1.0)), trimesh.creation.box((1.0, 1.0, 1.0))
    other.apply_translation((2.0, 0.0, 0.0))
    both = trimesh.util.concatenate([one, other])
    mesh = Mesh(both.vertices, both.faces)
    assert mesh.volume_m3 == pytest.approx(2.0)
    np.testing.assert_allclose(mesh.distance(np.array([1.0, 0.0, 0.0]))[0], 0.5, atol=0.87 * mesh.spacing_m)


@pytest.mark.parametrize("outer", [trimesh.creation.box((3.0, 3.0, 3.0)), trimesh.creation.icosphere(2, 1.0)])
def test_a_shell_inside_a_shell_is_refused(outer):
    inner = trimesh.creation.box((0.5, 0.5, 0.5))
    for first, second in ((outer, inner), (inner, outer)):  # whichever comes first in the file
        both = trimesh.util.concatenate([first, second])
        message = refused(both.vertices, both.faces)
        assert f"the part of {len(inner.faces)} faces at" in message
        assert f"lies inside the part of {len(outer.faces)} faces" in message
        assert "leave the inner one out" in message


def test_the_wall_of_a_cavity_is_refused_and_told_what_to_do():
    outer, cavity = trimesh.creation.box((3.0, 3.0, 3.0)), trimesh.creation.box((1.0, 1.0, 1.0))
    cavity.invert()
    both = trimesh.util.concatenate([outer, cavity])
    assert "the wall of a cavity is left out, and mass and inertia are given" in refused(both.vertices, both.faces)


def test_a_body_in_the_hollow_of_another_is_outside_of_it(coarse):
    ring, plug = trimesh.creation.annulus(2.0, 3.0, 1.0), trimesh.creation.box((1.0, 1.0, 0.5))
    both = trimesh.util.concatenate([ring, plug])
    assert Mesh(both.vertices, both.faces).volume_m3 == pytest.approx(ring.volume + plug.volume)


def test_three_faces_at_an_edge_are_refused():
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    vertices = np.concatenate([box.vertices, [[3.0, 0.0, 0.0]]])
    a, b = box.faces[0][:2]
    faces = np.concatenate([box.faces, [[a, b, 8]]])
    assert "faces meet" in refused(vertices, faces) or "is open" in refused(vertices, faces)


def test_a_finely_tessellated_sphere_is_accepted_quickly():
    ball = trimesh.creation.icosphere(subdivisions=4)
    assert len(ball.faces) == 5120
    assert Mesh(ball.vertices, ball.faces).volume_m3 == pytest.approx(4.0 / 3.0 * math.pi, rel=5e-3)


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({}, "shape.file = None: no name of a file; allowed: the name of a file of triangles, .stl or .obj"),
        ({"file": "missing.stl"}, "shape.file = 'missing.stl': cannot be read"),
        ({"file": "broken.stl"}, "shape.file = 'broken.stl': "),
        ({"file": "scene.gltf"}, "shape.file = 'scene.gltf': of another format"),
        ({"file": "box.stl", "unit_m": 0}, "shape.unit_m = 0: out of range"),
        ({"file": "box.stl", "unit_m": 1000.0}, "shape.file is 3000 m large; allowed: 0.001 to 1000 m, see unit_m"),
        ({"file": "box.stl", "scale": 2}, "a mesh has no entry 'scale'; it has: file, unit_m"),
    ],
)
def test_an_error_names_the_entry(tmp_path, entries, message):
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / "box.stl")
    (tmp_path / "broken.stl").write_bytes(b"solid nothing\nfacet")
    with pytest.raises(ShapeError) as caught:
        shape_from({"kind": "mesh", **entries}, folder=tmp_path)
    assert message in str(caught.value)
