"""Friction of threads decides how far a towed net slips over the debris."""

from __future__ import annotations

from benchmarks.friction import HOLD, Slip, attitude
from tethernet_sim.fly import Settings, fly
from tethernet_sim.scenario import Scenario


def test_a_towed_net_slips_without_friction_and_sticks_with_it():
    way_m = {}
    for friction in (0.0, 0.6):
        physics = {"contact": "threads", "friction_coefficient": friction}
        slip = Slip()
        scenario = Scenario("zenit_4mu", debris_attitude=attitude(0), seed=0)
        outcome = fly(scenario, Settings.load("zenit_4mu", physics=physics, mission=HOLD), slip)
        assert outcome.captured, outcome.verdict
        way_m[friction] = slip.way_m
    assert way_m[0.6] < 1.2
    assert way_m[0.0] > 2.0 * way_m[0.6]
