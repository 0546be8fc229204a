"""The loops of net that a closing leaves open, and the debris' girth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tethernet_core import sphere_directions
from tethernet_core.rotation import matrix
from tethernet_core.shapes import Box, Cylinder, Sphere
from tethernet_core.system import load_system
from tethernet_core.system.mouth_left_open import least_girth_m, widest_loop_m, widest_loop_of_capture_m
from tethernet_learning import sphere
from tethernet_planner.debris_section import DebrisPose
from tethernet_planner.meeting_places import sideways_directions

ALONG_THE_EDGE_M = 11.0 + math.sqrt(2.0) + 0.71


def test_each_pair_that_does_not_dock_adds_its_strand_to_the_loop():
    system = load_system("zenit_8mu")
    assert widest_loop_m(system, [True] * 8) == pytest.approx(ALONG_THE_EDGE_M)
    assert widest_loop_m(system, [False] + [True] * 7) == pytest.approx(ALONG_THE_EDGE_M), "one strand, its ends docked"
    assert widest_loop_m(system, [False, True, True, True] * 2) == pytest.approx(2.0 * ALONG_THE_EDGE_M)
    assert widest_loop_m(system, [False] * 8) == pytest.approx(8.0 * ALONG_THE_EDGE_M), "the whole mouth"
    assert widest_loop_of_capture_m(system) == pytest.approx(2.0 * ALONG_THE_EDGE_M)


def test_units_that_do_not_dock_leave_no_such_loops():
    assert math.isnan(widest_loop_m(load_system("zenit_4mu"), []))
    assert math.isnan(widest_loop_of_capture_m(load_system("passive_5m")))
    with pytest.raises(ValueError, match="docked has 3 entries; allowed: 8"):
        widest_loop_m(load_system("zenit_8mu"), [True] * 3)


@pytest.mark.parametrize(
    ("shape", "girth_m"),
    [
        (Cylinder(radius_m=1.95, length_m=11.1), 2.0 * math.pi * 1.95),
        (Cylinder(radius_m=2.0, length_m=0.5), 2.0 * (4.0 + 0.5)),
        (Box(size_m=(3.0, 2.0, 8.0)), 10.0),
        (Sphere(radius_m=1.5), 3.0 * math.pi),
    ],
)
def test_the_least_girth_of_a_body_is_that_of_its_slimmest_outline(shape, girth_m):
    assert least_girth_m(shape) == pytest.approx(girth_m, rel=0.012)


def test_the_8_unit_net_is_too_short_to_meet_behind_debris_in_most_attitudes():
    """Opposite mid-side units can go round 23.4 m of debris; lengthwise its girth is 30 m. The figures in README."""
    system = load_system("zenit_8mu")
    sideways = sideways_directions(system)
    steps = np.arange(-5.0, 5.1, 0.5)
    places = np.stack(np.meshgrid(steps, steps, np.arange(-9.0, 0.1, 0.5), indexing="ij"), axis=-1).reshape(-1, 3)
    along = np.arange(0.0, 14.0, 0.5)[:, None] * np.array([0.0, 0.0, 1.0])
    spare = []
    for direction in sphere_directions.directions(60, hemisphere=True):
        pose = DebrisPose(system.debris, matrix(sphere.attitude_along(direction)))
        behind = (pose.distance(places) > 0.4) & (pose.distance(places[:, None] + along) < 0.0).any(axis=1)
        left = [
            reach - pose.outline(side).path_length(places[behind])
            for reach, side in zip(system.unit_reach_m, sideways, strict=True)
        ]
        spare.append(np.min(left, axis=0).max())
    assert np.mean(np.array(spare) >= 0.0) == pytest.approx(0.32, abs=0.05)
    assert min(spare) == pytest.approx(-3.5, abs=0.15), "so much longer would the mid-side threads have to be"
