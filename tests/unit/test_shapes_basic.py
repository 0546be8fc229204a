"""Distance, rays, mass properties and triangles of every shape against brute force."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tethernet_core.shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    Cylinder,
    Part,
    Shape,
    Sphere,
    shape_kinds,
    surface_functions,
)

TURN = (0.5, -0.5, 0.1, math.sqrt(0.49))
SHAPES = {
    "cylinder": Cylinder(1.3, 4.0),
    "flat cylinder": Cylinder(2.0, 0.5),
    "box": Box((1.0, 2.5, 4.0)),
    "sphere": Sphere(1.7),
    "capsule": Capsule(0.8, 4.0),
    "round capsule": Capsule(0.8, 1.6),
    "cone": Cone(1.5, 3.0),
    "truncated cone": Cone(1.5, 2.0, 0.4),
    "funnel": Cone(0.5, 2.0, 1.6),
    "compound of one": Compound((Part(Box((1.0, 2.5, 4.0)), (0.4, -0.2, 1.0), TURN),)),
    "compound": Compound(
        (
            Part(Cylinder(1.0, 3.0)),
            Part(Box((0.4, 6.0, 0.2)), (0.3, 2.0, 1.0), TURN),
            Part(Cone(0.5, 1.0, 1.0), (0.0, 0.0, -1.9)),
        )
    ),
}
OVERLAPPING = {"compound"}


@pytest.fixture(params=SHAPES, name="shape")
def _shape(request) -> Shape:
    return SHAPES[request.param]


def directions(count: int) -> np.ndarray:
    rays = np.random.default_rng(3).normal(size=(count, 3))
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def places(shape: Shape, count: int, stretch: float = 1.5) -> np.ndarray:
    size = stretch * shape.reach_m
    return shape.centroid + np.random.default_rng(4).uniform(-size, size, (count, 3))


def surface_points(shape: Shape, count: int) -> np.ndarray:
    corners, faces = shape.triangles()
    a, b, c = (corners[faces[:, k]] for k in range(3))
    weight = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    random = np.random.default_rng(5)
    chosen = random.choice(len(faces), count, p=weight / weight.sum())
    u, v = random.uniform(size=(2, count))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    points = a[chosen] + u[:, None] * (b - a)[chosen] + v[:, None] * (c - a)[chosen]
    distance, normal = shape.distance(points)
    points = points - distance[:, None] * normal
    return points[np.abs(shape.distance(points)[0]) < 1e-9]


def test_the_nearest_surface_point_is_as_far_as_the_distance_says(shape):
    points, sampled = places(shape, 200), surface_points(shape, 60_000)
    distance, normal = shape.distance(points)
    nearest = np.array([np.linalg.norm(sampled - p, axis=1).min() for p in points])
    outside = distance > 0.0
    # Sampling finds no nearer point than there is, and one that is hardly farther.
    assert (nearest[outside] >= distance[outside] - 1e-9).all()
    assert (nearest[outside] <= distance[outside] + 0.08).all()
    assert (nearest >= np.abs(distance) - 1e-9).all()
    foot = points - distance[:, None] * normal
    np.testing.assert_allclose(shape.distance(foot)[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=1e-12)


def test_the_normal_is_the_gradient_of_the_distance(shape):
    points = places(shape, 500)
    _, normal = shape.distance(points)
    step, slopes = 1e-6, []
    for axis in range(3):
        ahead, behind = points.copy(), points.copy()
        ahead[:, axis] += step
        behind[:, axis] -= step
        slopes.append((shape.distance(ahead)[0] - shape.distance(behind)[0]) / (2.0 * step))
    gradient = np.stack(slopes, axis=1)
    smooth = np.linalg.norm(gradient, axis=1) > 1.0 - 1e-6  # where two nearest points change places it is not
    assert smooth.mean() > 0.98
    np.testing.assert_allclose(gradient[smooth], normal[smooth], atol=2e-6)


def test_a_single_point_is_as_good_as_many_and_no_point_is_degenerate(shape):
    points = np.concatenate([places(shape, 5), np.zeros((1, 3)), shape.centroid[None]])
    distance, normal = shape.distance(points)
    assert np.isfinite(distance).all() and np.isfinite(normal).all()
    for i, point in enumerate(points):
        one, its = shape.distance(point)
        assert one == distance[i]
        np.testing.assert_array_equal(its, normal[i])


def test_volume_centroid_and_inertia_are_those_of_points_inside(shape):
    points = places(shape, 2_000_000, stretch=1.0)
    inside = points[shape.distance(points)[0] < 0.0]
    volume = len(inside) / len(points) * (2.0 * shape.reach_m) ** 3
    assert volume == pytest.approx(shape.volume_m3, rel=0.01)
    if shape in [SHAPES[name] for name in OVERLAPPING]:
        return  # its mass counts twice where parts overlap: see the compound's own tests
    np.testing.assert_allclose(inside.mean(axis=0), shape.centroid, atol=0.01)
    arms = inside - shape.centroid
    inertia = (arms**2).sum(axis=1).mean() * np.eye(3) - arms.T @ arms / len(arms)
    np.testing.assert_allclose(inertia, shape.inertia_per_mass, atol=0.01 * np.trace(inertia))


def test_triangles_are_closed_face_outward_and_have_nearly_the_area(shape):
    corners, faces = shape.triangles()
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}
    assert len({tuple(e) for e in edges}) == len(edges)
    a, b, c = (corners[faces[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    if shape in [SHAPES[name] for name in OVERLAPPING]:
        assert area > shape.area_m2
        return
    assert area == pytest.approx(shape.area_m2, rel=0.005)
    assert volume == pytest.approx(shape.volume_m3, rel=0.005)
    np.testing.assert_allclose(shape.distance(corners)[0], 0.0, atol=1e-12)


def test_reach_and_extent_are_those_of_the_surface(shape):
    sampled = np.concatenate([surface_points(shape, 20_000), shape.triangles()[0]])
    for point in (shape.centroid, np.array([0.3, -2.0, 1.0])):
        farthest = np.linalg.norm(sampled - point, axis=1).max()
        assert farthest <= shape.reach_from(point) + 1e-9
        assert farthest == pytest.approx(shape.reach_from(point), rel=0.01)
    widest = max(np.ptp(sampled @ d) for d in directions(4000))
    assert widest <= shape.extent_m * 1.003
    assert widest == pytest.approx(shape.extent_m, rel=0.01)


def test_rays_leave_at_the_surface_and_meet_nothing_beyond(shape):
    for origin in (shape.centroid, *(shape.centroid + np.array(o) for o in ((0.1, 0.05, -0.2), (4.0, 1.0, 2.0)))):
        rays = directions(2000)
        if np.linalg.norm(origin - shape.centroid) > 1.0:
            rays = shape.centroid + 0.7 * shape.reach_m * rays - origin
            rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        exits = shape.ray_exit(origin, rays)
        met = exits > 0.0
        assert met.mean() > 0.1
        np.testing.assert_allclose(shape.distance(origin + exits[met, None] * rays[met])[0], 0.0, atol=1e-9)
        for share in np.linspace(0.001, 1.0, 60):
            beyond = exits + share * 2.0 * shape.reach_m
            assert (shape.distance(origin + beyond[:, None] * rays)[0] > -1e-6).all()
    np.testing.assert_array_equal(shape.exit_distance(rays), shape.ray_exit(shape.centroid, rays))


def test_every_axis_of_a_ray_may_be_zero(shape):
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    exits = shape.exit_distance(axes)
    assert np.isfinite(exits).all()
    np.testing.assert_allclose(shape.distance(shape.centroid + exits[:, None] * axes)[0], 0.0, atol=1e-9)


def test_every_shape_file_is_found_by_itself():
    assert {"box", "capsule", "compound", "cone", "cylinder", "sphere"} <= set(shape_kinds())
    assert list(shape_kinds()) == sorted(shape_kinds())
    assert set(surface_functions()) == set(shape_kinds()) - {"compound"}


def test_equal_shapes_have_equal_digests():
    assert Box((1.0, 2.0, 3.0)).digest == Box((1, 2, 3)).digest
    digests = [shape.digest for shape in SHAPES.values()]
    assert len(set(digests)) == len(digests)
