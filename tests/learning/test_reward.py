"""The reward by hand, term by term."""

import math

import numpy as np
import pytest

from tests.physics import diverging
from tethernet_core.capture_quality import captured
from tethernet_core.system import load_system
from tethernet_learning.flown import Flown, from_outcomes
from tethernet_learning.policies.reward import TERMS, VARIANTS, Reward
from tethernet_sim.fly import Settings, fly
from tethernet_sim.scenario import Scenario

SYSTEM = {mus: load_system(f"zenit_{mus}mu") for mus in (4, 8)}


def flown(cqi, pairs, fuel=0.1, mouth=500.0, mus=8):
    return Flown(mus, np.array([cqi]), np.array([pairs]), np.array([fuel]), np.array([mouth]), SYSTEM[mus])


def test_a_good_capture_earns_mouth_and_fuel():
    terms = Reward(SYSTEM[8], fuel_max_kg=0.4, mouth_max_m2=540.0).terms(flown(1.2, 8))
    assert terms["mouth"] == pytest.approx(500 / 540)
    assert terms["fuel"] == pytest.approx(1.5 * 0.75)
    assert terms["cqi"] == terms["locked_pairs"] == 0.0
    assert tuple(terms) == TERMS


def test_the_variants_differ_between_the_threshold_and_all_pairs():
    threshold, printed = (
        Reward(SYSTEM[8], 0.4, 540.0, variant).terms(flown(1.2, 7)) for variant in ("threshold", "printed")
    )
    assert threshold["locked_pairs"] == 0.0
    assert threshold["fuel"] > 0.0
    assert printed["locked_pairs"] == pytest.approx(-math.log(2.0))
    assert printed["fuel"] == 0.0


def test_lean_pays_for_fuel_but_not_for_the_mouth():
    narrow, wide = (Reward(SYSTEM[8], 0.4, 540.0, "lean")(flown(1.2, 6, mouth=mouth)) for mouth in (400.0, 500.0))
    assert narrow == wide == pytest.approx(1.5 * 0.75)


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_miss_pays_for_cqi_and_pairs(variant):
    terms = Reward(SYSTEM[4], 0.1, 560.0, variant).terms(flown(5.5, 6, mus=4))
    assert terms["cqi"] == pytest.approx(-math.log(10.0))
    assert terms["locked_pairs"] == pytest.approx(-math.log(5.0))
    assert terms["fuel"] == 0.0


def test_an_unknown_variant_is_an_error():
    with pytest.raises(ValueError, match="allowed: threshold, printed, lean"):
        Reward(SYSTEM[8], 0.4, 540.0, "other")


def test_a_simulation_in_error_counts_as_missed_by_far(monkeypatch):
    outcome = fly(Scenario("zenit_4mu"), diverging(monkeypatch))
    assert outcome.error
    result = from_outcomes([outcome], SYSTEM[4])
    assert result.cqi[0] == 20.0
    assert not result.captured[0]
    assert np.isfinite(Reward.load(SYSTEM[4])(result)).all()


@pytest.mark.parametrize("threshold", [2.5, 1.0])
def test_learning_judges_a_capture_as_every_mission_is_judged(threshold):
    system = load_system("zenit_8mu", {"capture.cqi_threshold": threshold})
    cqi = np.array([0.5, 1.0, 1.5, 2.5, 3.0])
    some = Flown(8, cqi, np.full(5, 8), np.full(5, 0.1), np.full(5, 500.0), system)
    assert some.captured.tolist() == [captured(value, 8, system) for value in cqi]
    assert some.captured.tolist() == (cqi < threshold).tolist()
    terms = Reward(SYSTEM[8], 0.4, 540.0).terms(some)
    assert ((terms["fuel"] > 0.0) == some.captured).all()


def test_the_cqi_that_decides_is_the_one_that_learning_sees():
    outcome = fly(Scenario("zenit_8mu"), Settings.load(mission={"capture_duration_s": 1.0, "trigger_distance_m": 45.0}))
    knots, everything = (load_system("zenit_8mu", {"capture.center_of_mass": word}) for word in ("knots", "all"))
    assert outcome.cqi != outcome.cqi_all
    assert from_outcomes([outcome], knots).cqi[0] == min(outcome.cqi, 20.0)
    assert from_outcomes([outcome], everything).cqi[0] == min(outcome.cqi_all, 20.0)


def test_constants_are_those_of_the_system_as_it_is_described(tmp_path):
    heavier = load_system("zenit_4mu", {"debris.mass_kg": 9001.0})
    for system, words in ((heavier, "another system of that name"), (load_system("hexagonal_6mu"), "are not there")):
        with pytest.raises(ValueError, match=f"{system.name} .*{words}.*tethernet train references --system"):
            Reward.load(system)
    assert (Reward.load(SYSTEM[4]).fuel_weight, Reward.load(SYSTEM[8]).fuel_weight) == (1.0, 1.5)
    (tmp_path / "own.json").write_text("[]")
    with pytest.raises(ValueError, match=r"own\.json holds no constants"):
        Reward.load(heavier, file=tmp_path / "own.json")
