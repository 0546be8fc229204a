"""The assessor through a hold test: when it says what, on real nets of a flight, and what it cannot know."""

import dataclasses
import functools
import math

import numpy as np
import pytest

from tests.unit.test_enclosure import wrapped
from tethernet_core.enclosure import enclosed
from tethernet_core.mission import Mission, Phase, arm, launch
from tethernet_core.modified_quality import modified_quality
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_planner.assessment import CaptureAssessor, Stage
from tethernet_planner.inference.net_sample import NetSample
from tethernet_planner.mission_rules import advance

CONTROL, RULES = load(ControlParameters), load(MissionParameters)
SYSTEM = load_system("zenit_4mu")
PERIOD = CONTROL.period_ns
PAIRS = SYSTEM.closing.max_locked_pairs
DEBRIS, FAR, LEVEL = (0.0, 0.0, -50.0), (0.0, 0.0, -10.0), (0.0, 0.0, 0.0, 1.0)
HOLD_TICKS = 40
TRIGGER, END = 480, 481 + round(RULES.capture_duration_s / CONTROL.control_period_s)
HOLD_END = END + 1 + HOLD_TICKS


@functools.cache
def net():
    """A ball of a net round the debris, its mouth drawn together: shapes (N, 3) and (M, 3), float32."""
    knots, mus = wrapped(SYSTEM, 8.0)
    return (knots + DEBRIS).astype(np.float32), (mus + DEBRIS).astype(np.float32)


def sample(tick, *, locked=PAIRS, share=0.1, attitude=LEVEL, shift=0.0):
    knots, mus = net()
    knots, mus = knots + np.float32(shift), mus + np.float32(shift)
    return NetSample(
        tick * PERIOD, tuple(map(float, knots.mean(axis=0))), DEBRIS, locked, mus, knots,
        center_all=tuple(map(float, knots.mean(axis=0))), debris_attitude=attitude,
        locked=tuple(pair < locked for pair in range(PAIRS)), max_load_share=share, max_contact_force_n=12.0,
    )  # fmt: skip


def missions(hold_s=HOLD_TICKS * PERIOD * 1e-9):
    """Launched, closing, holding, complete."""
    flying = launch(arm(Mission(SYSTEM.unit_count, hold_s=hold_s, tow_n=20.0), DEBRIS, "nominal"), 0)
    closing = advance(flying, SYSTEM, TRIGGER * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)
    judged = advance(closing, SYSTEM, END * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)
    over = advance(judged, SYSTEM, HOLD_END * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)
    return flying, closing, judged, over


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def flown(samples, every=10, clock=None):
    """Every assessment by its stage, of a mission whose states come at the ticks after those that they speak of."""
    made = CaptureAssessor(SYSTEM, CONTROL, every, clock=clock or Clock())
    flying, closing, judged, over = missions()
    news = {0: flying, TRIGGER + 1: closing, END + 1: judged, HOLD_END + 1: over}
    found = []
    for tick in range(HOLD_END + 2):
        if tick in news:
            found += made.take_mission(news[tick])
        if (seen := samples(tick)) is not None:
            found += made.take_sample(seen)
    return made, found


def test_progress_goes_on_and_the_hold_test_has_its_own_end():
    _, found = flown(sample, every=10)
    stages = {stage: [a for a in found if a.stage == stage] for stage in Stage}
    [trigger], [final], [hold] = (stages[stage] for stage in (Stage.TRIGGER, Stage.FINAL, Stage.HELD))
    assert [a.stamp_ns // PERIOD for a in (trigger, final, hold)] == [TRIGGER + 1, END, HOLD_END]
    during = [a for a in stages[Stage.PROGRESS] if END < a.stamp_ns // PERIOD < HOLD_END]
    assert len(during) == HOLD_TICKS // 10
    assert all(math.isfinite(a.mcqi) and a.enclosed is not None for a in during)
    before = [a for a in stages[Stage.PROGRESS] if a.stamp_ns // PERIOD < TRIGGER]
    assert all(math.isnan(a.mcqi) and a.enclosed is None for a in before), "an open net encloses nothing"
    assert (final.held, final.hold_verdict, hold.captured, hold.verdict) == (None, "", False, "")
    seen = sample(END)
    where = (seen.knot_positions, seen.mu_positions, np.array(DEBRIS), np.array(LEVEL), SYSTEM)
    assert (final.mcqi, final.enclosed) == (modified_quality(*where), enclosed(*where))
    assert final.enclosed is True
    assert (hold.max_load_share, hold.max_contact_force_n) == (0.1, 12.0)
    assert hold.held is True
    assert hold.hold_verdict == "held: the closed net goes round the whole debris"


@pytest.mark.parametrize(
    ("at_end", "held", "words"),
    [
        ({"shift": 30.0}, False, "not held: the closed net does not go round the whole debris"),
        ({"locked": PAIRS - 2}, False, "not held: 2 pairs came undone"),
        ({"share": 1.5}, True, "warning: a thread bore 1.50 times what it can"),
        ({"attitude": None}, None, "undecided whether it is held: nothing tells the debris' attitude"),
    ],
)
def test_what_the_hold_test_comes_to(at_end, held, words):
    _, found = flown(lambda tick: sample(tick, **(at_end if tick > END else {})))
    [hold] = [a for a in found if a.stage == Stage.HELD]
    assert hold.held is held
    assert words in hold.hold_verdict


def test_a_load_beyond_the_strength_warns_in_the_verdict_too():
    _, found = flown(lambda tick: sample(tick, share=1.25))
    [final] = [a for a in found if a.stage == Stage.FINAL]
    assert final.verdict.endswith("warning: a thread bore 1.25 times what it can, a real one would have broken")


def test_without_a_simulator_it_says_that_it_cannot_know():
    def from_mus(tick):
        return NetSample(tick * PERIOD, DEBRIS, DEBRIS, 0, np.zeros((SYSTEM.unit_count, 3), np.float32))

    _, found = flown(from_mus)
    [hold] = [a for a in found if a.stage == Stage.HELD]
    assert hold.held is None
    assert hold.hold_verdict == "undecided whether it is held: nothing measures the net"
    assert math.isnan(hold.max_load_share)
    assert hold.enclosed is None


def test_a_mission_that_is_missed_is_not_held():
    made = CaptureAssessor(SYSTEM, CONTROL, 100000, clock=Clock())
    flying = missions()[0]
    made.take_mission(flying)
    made.take_sample(sample(800))
    final, hold = made.take_mission(advance(flying, SYSTEM, 800 * PERIOD, FAR, DEBRIS, RULES, CONTROL))
    assert (final.stage, final.captured, hold.stage) == (Stage.FINAL, False, Stage.HELD)
    assert hold.held is False
    assert hold.hold_verdict == f"not held: {final.verdict}"
    assert hold.hold_verdict.startswith("not held: missed: the net did not come")


def test_samples_that_stop_before_the_end_are_judged_as_far_as_they_go():
    clock = Clock()
    made, found = flown(lambda tick: sample(tick) if tick < HOLD_END - 5 else None, clock=clock)
    assert Stage.HELD not in [a.stage for a in found]
    assert made.overdue() == []
    clock.now = 2.0
    [hold] = made.overdue()
    assert (hold.stage, hold.held, hold.stamp_ns) == (Stage.HELD, True, (HOLD_END - 6) * PERIOD)
    assert made.overdue() == []


def test_nothing_ever_seen():
    clock = Clock()
    made, found = flown(lambda _: None, clock=clock)
    assert found == []
    clock.now = 2.0
    final, hold = made.overdue()
    assert (final.stage, hold.stage, hold.held) == (Stage.FINAL, Stage.HELD, None)


def test_an_aborted_hold_test_gets_its_verdict_and_no_hold_verdict():
    clock = Clock()
    made = CaptureAssessor(SYSTEM, CONTROL, 100000, clock=clock)
    flying, closing, judged, _ = missions()
    for mission in (flying, closing, judged):
        made.take_mission(mission)
    [_, final] = [*made.take_sample(sample(TRIGGER + 1)), *made.take_sample(sample(END))]
    assert final.stage == Stage.FINAL
    made.take_mission(dataclasses.replace(judged, phase=Phase.ABORTED, sequence=judged.sequence + 1))
    clock.now = 100.0
    assert made.overdue() == []
