"""Unions of shapes: against their parts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tethernet_core.shapes import Box, Compound, Cylinder, Part, Sphere

QUARTER = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
"""A quarter turn about z."""


def points() -> np.ndarray:
    return np.random.default_rng(1).uniform(-4.0, 4.0, (1000, 3))


def test_a_compound_of_one_is_its_part():
    part, compound = Cylinder(1.0, 3.0), Compound((Part(Cylinder(1.0, 3.0)),))
    np.testing.assert_array_equal(compound.distance(points())[0], part.distance(points())[0])
    np.testing.assert_allclose(compound.distance(points())[1], part.distance(points())[1], atol=1e-15)
    assert compound.volume_m3 == part.volume_m3 and compound.area_m2 == part.area_m2
    np.testing.assert_allclose(compound.inertia_per_mass, part.inertia_per_mass, rtol=1e-14, atol=1e-15)
    assert compound.extent_m == part.extent_m and compound.reach_m == pytest.approx(part.reach_m)


def test_two_halves_side_by_side_are_the_whole():
    halves = Compound((Part(Box((1.0, 2.0, 3.0)), (-0.5, 0.0, 0.0)), Part(Box((1.0, 2.0, 3.0)), (0.5, 0.0, 0.0))))
    whole = Box((2.0, 2.0, 3.0))
    assert halves.volume_m3 == pytest.approx(whole.volume_m3, rel=1e-12)
    assert halves.area_m2 == pytest.approx(whole.area_m2, rel=2e-3)  # the surface between them is none
    np.testing.assert_allclose(halves.inertia_per_mass, whole.inertia_per_mass, rtol=1e-12, atol=1e-14)
    assert halves.extent_m == pytest.approx(whole.extent_m)
    outside = points()[whole.distance(points())[0] > 0.0]
    np.testing.assert_allclose(halves.distance(outside)[0], whole.distance(outside)[0], rtol=1e-12)


def test_overlaps_count_once_in_volume_and_area_and_twice_in_mass():
    same = Compound((Part(Sphere(1.0)), Part(Sphere(1.0))))
    assert same.volume_m3 == pytest.approx(Sphere(1.0).volume_m3, rel=1e-12)
    assert same.area_m2 == pytest.approx(Sphere(1.0).area_m2, rel=1e-12)
    # Two spheres whose centres are 1 m apart: each hides a cap of height 1/2 of the other, 5/24 pi of volume.
    near = Compound((Part(Sphere(1.0)), Part(Sphere(1.0), (1.0, 0.0, 0.0))))
    assert near.volume_m3 == pytest.approx(2.0 * math.pi * (4.0 / 3.0 - 5.0 / 24.0), rel=2e-3)
    assert near.area_m2 == pytest.approx(2.0 * (4.0 - 1.0) * math.pi, rel=2e-3)
    np.testing.assert_allclose(near.centroid, [0.5, 0.0, 0.0])
    np.testing.assert_allclose(np.diag(near.inertia_per_mass), [0.4, 0.65, 0.65])


def test_shares_of_mass_override_volumes():
    bus_and_panel = Compound(
        (
            Part(Box((2.0, 2.0, 2.0)), mass_share=0.9),
            Part(Box((0.1, 10.0, 2.0)), (0.0, 6.0, 0.0), QUARTER, mass_share=0.1),
        )
    )
    np.testing.assert_allclose(bus_and_panel.centroid, [0.0, 0.6, 0.0], atol=1e-15)
    # The panel's long side lies along x after its quarter turn.
    panel = np.diag([(0.1**2 + 2.0**2) / 12.0, (10.0**2 + 2.0**2) / 12.0, (0.1**2 + 10.0**2) / 12.0])
    bus = 2.0 * 2.0**2 / 12.0 * np.eye(3)
    steiner = 0.9 * 0.6**2 + 0.1 * 5.4**2
    np.testing.assert_allclose(
        bus_and_panel.inertia_per_mass, 0.9 * bus + 0.1 * panel + np.diag([steiner, 0.0, steiner]), atol=1e-12
    )


def test_compounds_nest():
    pair = Compound((Part(Sphere(0.5), (1.0, 0.0, 0.0)), Part(Sphere(0.5), (-1.0, 0.0, 0.0))))
    nested = Compound((Part(pair, (0.0, 2.0, 0.0), QUARTER), Part(Box((1.0, 1.0, 1.0)))))
    assert [p.shape.kind for p in nested.primitives()] == ["sphere", "sphere", "box"]
    np.testing.assert_allclose(nested.primitives()[0].position, [0.0, 3.0, 0.0], atol=1e-15)
    assert nested.distance(np.array([0.0, 3.0, 0.0]))[0] == pytest.approx(-0.5)
    by_hand = np.min([p.shape.distance((points() - p.position) @ p.matrix)[0] for p in nested.primitives()], axis=0)
    np.testing.assert_allclose(nested.distance(points())[0], by_hand, atol=1e-14)
