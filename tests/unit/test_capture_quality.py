"""Which centre of mass the Capture Quality Index is computed with, and who decides."""

import math

import numpy as np
import pytest

from tests.physics import make_world
from tethernet_core.capture_quality import QualityParameters, captured, hull_quality, verdict
from tethernet_core.parameters import ParameterError, load
from tethernet_sim.audit import particle_masses, particles

QUALITY = load(QualityParameters)
DEBRIS = (0.0, 0.0, -50.0)


@pytest.mark.parametrize(("mus", "share"), [(4, 0.1), (8, 0.06)])
def test_the_centre_of_all_weighs_every_particle_by_its_mass(mus, share):
    world = make_world(mus)
    random = np.random.default_rng(mus)
    world.state.knot_pos[:] += random.normal(0.0, 3.0, world.state.knot_pos.shape)
    world.state.mu_pos[:] += random.normal(0.0, 3.0, world.state.mu_pos.shape)
    mass = particle_masses(world.model)
    position, _ = particles(world.state)
    assert world.net_center_all(0) == pytest.approx(mass @ position[0] / mass.sum(), abs=1e-12)
    knots = len(world.model.arrays.knot_mass)
    assert world.net_center(0) == pytest.approx(mass[:knots] @ position[0, :knots] / mass[:knots].sum(), abs=1e-12)
    assert mass[:knots].sum() / mass.sum() < share, "the knots are the smaller part of the net's mass by far"


def test_both_indices_differ_by_their_distances_alone():
    points = np.random.default_rng(0).normal(0.0, 2.0, (50, 3)) + DEBRIS
    hull = hull_quality(points, points[:8], (0.0, 1.0, -50.0), DEBRIS, QUALITY, (0.0, 0.0, -46.0))
    assert hull.distance == 1.0
    assert hull.cqi_all - hull.cqi == pytest.approx(0.8 * (4.0 - 1.0) / QUALITY.characteristic_length_m)
    assert math.isnan(hull_quality(points, points[:8], DEBRIS, DEBRIS, QUALITY).cqi_all)


def test_the_parameter_chooses_which_of_them_decides():
    knots, everything = (load(QualityParameters, {"center_of_mass": word}) for word in ("knots", "all"))
    assert QUALITY.center_of_mass == "knots"
    assert (knots.deciding(1.0, 3.0), everything.deciding(1.0, 3.0)) == (1.0, 3.0)
    assert not captured(everything.deciding(1.0, math.nan), 8, 8, everything), "what is not known captures nothing"
    assert "CQI not available" in verdict(math.nan, 8, 8, everything)
    with pytest.raises(ParameterError, match="allowed: one of knots, all"):
        load(QualityParameters, {"center_of_mass": "net"})


@pytest.mark.parametrize(("cqi", "below"), [(2.4999, True), (2.5, False), (2.5001, False)])
def test_at_the_threshold_itself_nothing_is_captured_whoever_asks(cqi, below):
    assert captured(cqi, 6, 8, QUALITY) is below
    assert captured(np.array([cqi]), np.array([6]), 8, QUALITY).tolist() == [below]
    assert verdict(cqi, 6, 8, QUALITY).startswith("captured" if below else "not captured")
    assert not captured(cqi, 5, 8, QUALITY)
