"""Which centre of mass the Capture Quality Index is computed with, and who decides."""

import math

import numpy as np
import pytest

from tests.physics import make_world
from tethernet_core.capture_quality import captured, deciding, hull_quality, verdict
from tethernet_core.system import DescriptionError, load_system
from tethernet_sim.audit import particle_masses, particles

SYSTEM = load_system("zenit_8mu")
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
    hull = hull_quality(points, points[:8], (0.0, 1.0, -50.0), DEBRIS, SYSTEM, (0.0, 0.0, -46.0))
    assert hull.distance == 1.0
    assert hull.cqi_all - hull.cqi == pytest.approx(0.8 * (4.0 - 1.0) / SYSTEM.debris.cqi_length_m)
    assert math.isnan(hull_quality(points, points[:8], DEBRIS, DEBRIS, SYSTEM).cqi_all)


def test_the_parameter_chooses_which_of_them_decides():
    knots, everything = (load_system("zenit_8mu", {"capture.center_of_mass": word}) for word in ("knots", "all"))
    assert SYSTEM.capture.center_of_mass == "knots"
    assert (deciding(1.0, 3.0, knots), deciding(1.0, 3.0, everything)) == (1.0, 3.0)
    assert not captured(deciding(1.0, math.nan, everything), 8, everything), "what is not known captures nothing"
    assert "CQI not available" in verdict(math.nan, 8, everything)
    with pytest.raises(DescriptionError, match="knots, all"):
        load_system("zenit_8mu", {"capture.center_of_mass": "net"})


@pytest.mark.parametrize(("cqi", "below"), [(2.4999, True), (2.5, False), (2.5001, False)])
def test_at_the_threshold_itself_nothing_is_captured_whoever_asks(cqi, below):
    assert captured(cqi, 6, SYSTEM) is below
    assert captured(np.array([cqi]), np.array([6]), SYSTEM).tolist() == [below]
    assert verdict(cqi, 6, SYSTEM).startswith("captured" if below else "not captured")
    assert not captured(cqi, 5, SYSTEM)
