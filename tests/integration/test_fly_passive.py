"""Whole missions of nets without units, and round bodies that are no cylinders, in process."""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
import pytest

from tethernet_core.system import load_system
from tethernet_sim.fly import Settings, fly, fly_many
from tethernet_sim.scenario import Scenario

SHORT = {"capture_duration_s": 1.0}


@pytest.fixture(scope="module")
def passive():
    """Missions of the shipped passive net."""
    return fly_many([Scenario("passive_5m", seed=seed, debris_position=(0.05 * seed, 0.0, -7.0)) for seed in range(3)])


def test_an_ejected_net_flies_by_itself_to_a_verdict(passive):
    for outcome in passive:
        assert outcome.captured, outcome.verdict
        assert "30 of 30 pairs locked" in outcome.verdict
        assert (outcome.fuel_kg, outcome.fuel_at_trigger_kg, outcome.mus) == ((), (), 0)
        assert math.isnan(outcome.max_tracking_error_m)  # nothing tracks anything
        # The masses share their momentum with the net; 0.4 m are left of the 6.7 m to the target. Its front, 0.5 m
        # before its middle, holds the net up a little, and the trigger takes effect a tick later.
        speed = 2.5 * math.cos(math.radians(25.0)) * 6.0 * 0.3 / load_system("passive_5m").net.mass_kg
        assert outcome.trigger_time_s == pytest.approx(6.3 / speed, abs=0.2)
        assert 3.0 < outcome.mouth_area_m2 < 16.3


def test_it_needs_no_seed_and_gives_the_same_bits_again(passive):
    again = fly(Scenario("passive_5m", seed=0, debris_position=(0.0, 0.0, -7.0)))
    np.testing.assert_equal(astuple(again), astuple(passive[0]))  # for which NaN is NaN


def test_its_bodies_leave_as_described_and_opening():
    system, seen = load_system("passive_5m"), []

    def observe(stamp_ns, world, _):
        if stamp_ns == 0:
            seen.append(world.state.knot_vel[0][:, list(system.launch.particles)].T.copy())
            seen.append(np.delete(world.state.knot_vel[0], system.launch.particles, axis=1))

    fly(Scenario(system), Settings.load(system, mission={"give_up_s": 1.0}), observe)
    masses, others = seen
    assert np.array_equal(masses, system.launch.velocities)
    assert np.allclose(np.linalg.norm(masses, axis=1), 2.5)
    assert (masses[:, 2] < 0.0).all()
    assert not others.any()


def test_without_a_winch_the_cqi_alone_decides():
    loose = load_system("passive_5m", {"closing": "none"})
    outcome = fly(Scenario(loose), Settings.load(loose, mission=SHORT))
    assert outcome.locked_pairs == 0
    assert "nothing closes the net: the CQI alone decides" in outcome.verdict


def test_a_net_that_flies_past_is_missed():
    outcome = fly(
        Scenario("passive_5m", debris_position=(0.9, 0.9, -7.0)),
        Settings.load("passive_5m", mission={"trigger_distance_m": 0.1}),
    )
    assert outcome.verdict.startswith("missed")
    assert outcome.trigger_time_s is None


def test_parameters_are_the_systems_own_over_the_defaults():
    assert Settings.load("passive_5m").mission.trigger_distance_m == 0.4
    assert Settings.load("passive_5m", mission={"trigger_distance_m": 0.5}).mission.trigger_distance_m == 0.5
    assert Settings.load("passive_5m").control == Settings.load().control


def test_a_box_is_captured_by_the_papers_units():
    box = load_system("zenit_8mu", {"debris.shape": {"kind": "box", "size_m": [3.5, 3.5, 10.0]}, "debris.cqi": None})
    outcome = fly(Scenario(box, debris_rate=(0.02, 0.01, 0.03)))
    assert outcome.captured, outcome.verdict
