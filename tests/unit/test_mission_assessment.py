"""When the capture is assessed, and what the verdict says."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

from tethernet_core.capture_quality import hull_quality
from tethernet_core.mission import Mission, abort, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_planner import predictors as prediction
from tethernet_planner.assessment import CaptureAssessor, Stage
from tethernet_planner.inference.net_sample import FROM_MUS, NetSample
from tethernet_planner.inference.prediction import Prediction
from tethernet_planner.mission_rules import advance

CONTROL, RULES = load(ControlParameters), load(MissionParameters)
SYSTEM = {mus: load_system(f"zenit_{mus}mu") for mus in (4, 8)}
PERIOD = CONTROL.period_ns
DEBRIS, FAR = (0.0, 0.0, -50.0), (0.0, 0.0, -10.0)


def cube(side, center=DEBRIS):
    return np.array(
        [np.add(center, corner) for corner in itertools.product((-side / 2, side / 2), repeat=3)], np.float32
    )


def sample(tick, side=5.0, center=DEBRIS, locked=8, mus=8):
    knots = cube(side, center)
    return NetSample(tick * PERIOD, center, DEBRIS, locked, knots[:mus], knots, np.zeros_like(knots), knots[:mus] * 0)


def from_mus(tick, locked, mus=8):
    return NetSample(tick * PERIOD, DEBRIS, DEBRIS, locked, np.zeros((mus, 3), np.float32))


def launched(mus=8):
    return launch(arm(Mission(mus), DEBRIS, "nominal"), 0)


def closed(tick=480, mus=8):
    return advance(launched(mus), SYSTEM[mus], tick * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)


def assessor(mission=None, mus=8, every=10, **options):
    made = CaptureAssessor(SYSTEM[mus], CONTROL, every, **options)
    if mission is not None:
        assert made.take_mission(mission) == []
    return made


def stages(assessments):
    return [a.stage for a in assessments]


def test_nothing_before_launch():
    made = assessor()
    assert made.take_sample(sample(0)) == []


def test_progress_every_few_ticks():
    made = assessor(launched())
    seen = [tick for tick in range(41) if made.take_sample(sample(tick))]
    assert seen == [0, 10, 20, 30, 40]


def test_trigger_and_end_are_assessed_at_their_own_ticks():
    made = assessor(launched(), every=100000)
    made.take_sample(sample(0))
    made.take_mission(closed())
    found = {tick: made.take_sample(sample(tick)) for tick in range(480, 790)}
    found = {tick: stages(a) for tick, a in found.items() if a}
    assert found == {481: [Stage.TRIGGER], 781: [Stage.FINAL]}


def test_a_state_that_comes_late_finds_the_samples_it_speaks_of():
    made = assessor(launched(), every=100000)
    for tick in range(476, 484):
        made.take_sample(sample(tick, side=tick / 100))
    [trigger] = made.take_mission(closed())
    assert (trigger.stage, trigger.stamp_ns) == (Stage.TRIGGER, 481 * PERIOD)
    assert trigger.hull_volume == pytest.approx(4.81**3, rel=1e-5)


def test_numbers_are_those_of_the_hull():
    made = assessor(launched(), every=1)
    [progress] = made.take_sample(sample(3, side=5.0, center=(0.0, 0.0, -48.0)))
    assert progress.hull_volume == pytest.approx(125.0)
    assert progress.hull_area == pytest.approx(150.0)
    assert progress.net_debris_distance == 2.0
    expected = 0.1 * (159.9 - 125.0) / 159.9 + 0.1 * (150.0 - 59.9) / 59.9 + 0.8 * 2.0 / 1.95
    assert progress.cqi == pytest.approx(expected)
    knots = cube(5.0, (0.0, 0.0, -48.0))
    assert progress.cqi == hull_quality(knots, knots, (0.0, 0.0, -48.0), DEBRIS, SYSTEM[8]).cqi


@pytest.mark.parametrize(
    ("side", "center", "locked", "mus", "captured", "words"),
    [
        (5.0, DEBRIS, 8, 8, True, "captured: CQI 0.17 (below 2.5), 8 of 8 pairs locked (at least 6 needed)"),
        (5.0, DEBRIS, 6, 8, True, "6 of 8 pairs"),
        (5.0, DEBRIS, 5, 8, False, "not captured: CQI 0.17 (below 2.5), 5 of 8"),
        (5.0, (0.0, 0.0, -42.0), 8, 8, False, "not captured: CQI 3.45 (not below 2.5)"),
        (5.0, DEBRIS, 8, 4, True, "8 of 12 pairs locked (at least 8 needed)"),
        (5.0, DEBRIS, 7, 4, False, "not captured"),
    ],
)
def test_verdict(side, center, locked, mus, captured, words):
    made = assessor(closed(mus=mus), mus=mus, every=100000)
    made.take_sample(sample(481, mus=mus))
    [final] = made.take_sample(sample(781, side, center, locked, mus))
    assert final.stage == Stage.FINAL
    assert final.captured is captured
    assert words in final.verdict


def test_the_centre_of_mass_of_knots_or_of_all_decides_as_the_parameter_says():
    found = {}
    for word in ("knots", "all"):
        system = load_system("zenit_8mu", {"capture.center_of_mass": word})
        made = CaptureAssessor(system, CONTROL, 100000)
        assert made.take_mission(closed()) == []
        made.take_sample(sample(481))
        beside = dataclasses.replace(sample(781), center_all=(0.0, 0.0, -42.0))
        [found[word]] = made.take_sample(beside)
    knots, counted = found["knots"], found["all"]
    assert (knots.cqi, knots.cqi_all) == (counted.cqi, counted.cqi_all)
    assert knots.cqi_all - knots.cqi == pytest.approx(0.8 * 8.0 / 1.95)
    assert knots.captured is True
    assert knots.verdict.startswith("captured: CQI 0.17 (below 2.5)")
    assert counted.captured is False
    assert counted.verdict.startswith("not captured: CQI with the MUs counted 3.45 (not below 2.5)")


def test_missed():
    made = assessor(launched(), every=100000)
    made.take_sample(sample(800, center=FAR, locked=0))
    [final] = made.take_mission(advance(launched(), SYSTEM[8], 800 * PERIOD, FAR, DEBRIS, RULES, CONTROL))
    assert (final.stage, final.stamp_ns, final.captured) == (Stage.FINAL, 800 * PERIOD, False)
    assert final.verdict.startswith("missed: the net did not come within 2.5 m")


def test_an_aborted_mission_gets_no_verdict():
    made = assessor(launched())
    assert made.take_mission(abort(launched(), "asked for")) == []
    assert made.take_sample(sample(900)) == []


def test_from_the_mus_alone_cqi_is_not_available_and_that_is_said():
    made = assessor(closed(), every=100000)
    made.take_sample(from_mus(481, 0))
    [final] = made.take_sample(from_mus(781, 8))
    assert final.source == FROM_MUS
    assert math.isnan(final.cqi)
    assert final.locked_pairs == 8
    assert "8 of 8 pairs" in final.verdict
    assert "CQI not available" in final.verdict


def test_from_four_mus_alone_locked_pairs_cannot_be_seen_either():
    made = assessor(closed(mus=4), mus=4, every=100000)
    made.take_sample(from_mus(481, 0, mus=4))
    [final] = made.take_sample(from_mus(781, 0, mus=4))
    assert "cannot be seen from the MUs" in final.verdict


def test_a_verdict_comes_although_the_last_sample_was_lost():
    now = [0.0]
    made = assessor(closed(), every=100000, clock=lambda: now[0])
    made.take_sample(sample(481))
    made.take_sample(sample(779, locked=7))
    over = advance(made.mission, SYSTEM[8], 781 * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)
    assert made.take_mission(over) == []
    assert made.overdue() == []
    now[0] = 2.0
    [final] = made.overdue()
    assert (final.stage, final.locked_pairs, final.stamp_ns) == (Stage.FINAL, 7, 779 * PERIOD)
    assert made.overdue() == []
    assert made.take_sample(sample(781)) == []


def test_a_verdict_comes_although_no_sample_ever_came():
    now = [0.0]
    made = assessor(closed(), clock=lambda: now[0])
    made.take_mission(advance(made.mission, SYSTEM[8], 781 * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL))
    now[0] = 2.0
    [final] = made.overdue()
    assert not final.captured
    assert "not available" in final.verdict


def test_a_surrogate_is_asked_at_the_trigger_and_judged_at_the_end(monkeypatch):
    class Surrogate:
        def __init__(self, mus):
            self.mus = mus

        def predict(self, sample):
            return Prediction(1.5, 7.2, 0.9)

    monkeypatch.setattr(prediction, "_FACTORIES", {})
    prediction.register("mine", Surrogate)
    made = assessor(launched(), every=1, predictor=prediction.make("mine", 8))
    assert made.take_sample(sample(480))[0].prediction is None
    made.take_mission(closed())
    [trigger] = made.take_sample(sample(481))
    assert trigger.prediction == Prediction(1.5, 7.2, 0.9)
    assert math.isnan(trigger.cqi_error)
    assert made.take_sample(sample(482))[0].prediction is None
    [final] = made.take_sample(sample(781, locked=7))
    assert final.prediction == trigger.prediction
    assert final.cqi_error == final.cqi - 1.5
    assert final.locked_pairs_error == pytest.approx(-0.2)
    with pytest.raises(prediction.PredictorError, match="allowed: none, mine"):
        prediction.make("other", 8)
    assert prediction.make("none", 8) is None


def test_a_surrogate_that_fails_costs_the_prediction_not_the_verdict():
    class Broken:
        def predict(self, sample):
            raise ValueError("a net of 3 knots")

    made = assessor(closed(), predictor=Broken())
    [trigger] = made.take_sample(sample(481))
    assert trigger.prediction is None
    assert trigger.prediction_failure == "ValueError: a net of 3 knots"
    [final] = made.take_sample(sample(781))
    assert final.verdict
    assert math.isnan(final.cqi_error)
