"""The closing plan made before the trigger."""

import math

import numpy as np
import pytest

from tethernet_core.mission import Mission, Phase, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_planner import closing
from tethernet_planner.closing_situation import closing_situation, foreseen
from tethernet_planner.docking_groups import most_parts
from tethernet_planner.meeting_places import MeetingPlaces
from tethernet_planner.mission_rules import advance
from tethernet_planner.plan_ahead import PlanAhead

CONTROL, RULES = load(ControlParameters), load(MissionParameters)
PERIOD = CONTROL.period_ns
DEBRIS = (0.0, 0.0, -50.0)
SYSTEM = load_system("zenit_8mu")
MOST_PARTS = most_parts(SYSTEM)
SPEED = 2.0  # [m/s]
MOUTH = np.array([(x, y, 0.0) for x, y in SYSTEM.aiming.offsets])
ATTITUDE = (0.1, 0.5, 0.1, math.sqrt(0.73))
TURNING = (0.0, 0.06, 0.0)


class Approach:
    """A net that flies to a tumbling debris at constant speed; counts what is asked and worked for."""

    def __init__(self, monkeypatch, rules=RULES, ahead=True, far=10.0, system=SYSTEM):
        self.system = system
        self.mission = launch(arm(Mission(system.unit_count), DEBRIS, "nominal"), 0)
        self.rules, self.far = rules, far
        self.ahead = PlanAhead(SYSTEM, rules) if ahead else None
        self.tick = self.looks = self.parts = 0
        self.work = []
        best = MeetingPlaces.best

        def counted(places, group):
            self.parts += 1
            return best(places, group)

        monkeypatch.setattr(MeetingPlaces, "best", counted)

    def distance(self, tick):
        return self.far - SPEED * tick * CONTROL.control_period_s

    def net(self, tick):
        return (0.0, 0.0, DEBRIS[2] + self.distance(tick))

    def closing_situation(self, tick):
        places, velocities = MOUTH + self.net(0), np.tile((0.0, 0.0, -SPEED), (8, 1))
        at_first = closing_situation(places, velocities, DEBRIS, ATTITUDE, (0.0,) * 3, TURNING)
        return foreseen(at_first, tick * CONTROL.control_period_s, SYSTEM)

    def look(self):
        self.looks += 1
        return self.closing_situation(self.tick)

    def step(self, net=None):
        """One control tick; returns the parts of plans that were worked on."""
        before = self.parts
        self.mission = advance(
            self.mission, self.system, self.tick * PERIOD, self.net(self.tick) if net is None else net, DEBRIS,
            self.rules, CONTROL, look=self.look, ahead=self.ahead,
        )  # fmt: skip
        self.tick += 1
        self.work.append(self.parts - before)
        return self.work[-1]

    def fly(self):
        while self.mission.phase == Phase.DEPLOYING:
            self.step()
        return self.mission


def test_nothing_is_worked_out_at_the_trigger_and_little_at_any_tick(monkeypatch):
    flight = Approach(monkeypatch)
    mission = flight.fly()
    assert mission.closing_ns == flight.tick * PERIOD, "one tick after the trigger"
    assert flight.work[-1] == 0
    assert max(flight.work) == 1
    assert sum(flight.work) == MOST_PARTS, "one plan"
    assert flight.looks == 1
    first = next(tick for tick, parts in enumerate(flight.work) if parts)
    assert (len(flight.work) - 1 - first) * PERIOD == pytest.approx(RULES.plan_ahead_s * 1e9, abs=PERIOD)


def test_without_planning_ahead_all_of_it_is_done_at_the_trigger(monkeypatch):
    never = load(MissionParameters, {"plan_ahead_s": 0})
    for flight in (Approach(monkeypatch, ahead=False), Approach(monkeypatch, never)):
        flight.fly()
        assert flight.work[-1] == sum(flight.work) == MOST_PARTS


def test_the_plan_is_the_one_for_what_is_seen_at_the_trigger(monkeypatch):
    flight = Approach(monkeypatch)
    mission = flight.fly()
    at_the_trigger = closing.plan(flight.closing_situation(flight.tick - 1), SYSTEM, RULES)
    assert np.allclose(mission.closing_points, at_the_trigger.points, atol=0.1)
    assert mission.closing_duration_s == pytest.approx(at_the_trigger.duration_s)
    before = closing.plan(flight.closing_situation(flight.tick - 21), SYSTEM, RULES)
    assert not np.allclose(mission.closing_points, before.points, atol=0.1), "the debris turns in the meantime"


def test_the_same_measurements_give_the_same_plan(monkeypatch):
    assert Approach(monkeypatch).fly() == Approach(monkeypatch).fly()


def test_a_trigger_out_of_the_blue_is_planned_at_once(monkeypatch):
    flight = Approach(monkeypatch, far=2.0)
    flight.fly()
    assert flight.work == [MOST_PARTS]
    flight = Approach(monkeypatch, far=30.0)
    flight.step()
    flight.step(net=(0.0, 0.0, DEBRIS[2] + 1.0))
    assert flight.mission.phase == Phase.CLOSING
    assert flight.work == [0, MOST_PARTS]


def test_a_net_that_waits_before_the_debris_is_planned_anew(monkeypatch):
    flight = Approach(monkeypatch)
    while sum(flight.work) != MOST_PARTS:
        flight.step()
    here = flight.net(flight.tick)
    for _ in range(100):
        flight.step(net=here)
    assert max(flight.work) == 1
    flight.step(net=(0.0, 0.0, DEBRIS[2] + 2.4))
    assert flight.mission.phase == Phase.CLOSING
    assert flight.work[-1] == MOST_PARTS, "the plan is too old by now"


def test_a_net_that_comes_slowly_is_planned_again_and_again(monkeypatch):
    ahead, looks = PlanAhead(SYSTEM, RULES), []

    def look():
        looks.append(1)
        return closing_situation(MOUTH + DEBRIS, np.zeros((8, 3)), DEBRIS, ATTITUDE, (0.0,) * 3, TURNING)

    for tick in range(101):
        distance = RULES.trigger_distance_m + 0.06 * math.exp(-0.06 * tick)
        ahead.watch(tick * PERIOD, (0.0, 0.0, DEBRIS[2] + distance), DEBRIS, look)
    assert ahead.ready(100 * PERIOD) is not None
    assert ahead.ready(400 * PERIOD) is None, "too old"
    assert len(looks) <= 6, "no oftener than every plan_ahead_s"


def test_nothing_is_planned_of_what_is_not_known(monkeypatch):
    ahead = PlanAhead(SYSTEM, RULES)
    for tick in range(200):
        distance = 10.0 - 0.05 * tick
        ahead.watch(tick * PERIOD, (math.nan, 0.0, DEBRIS[2] + distance), DEBRIS, lambda: pytest.fail("asked"))
        ahead.watch(tick * PERIOD, (0.0, 0.0, DEBRIS[2] + max(distance, 3.0)), DEBRIS, lambda: None)
    assert ahead.ready(200 * PERIOD) is None


def test_winches_and_the_paper_need_no_plan(monkeypatch):
    fixed = Approach(monkeypatch, load(MissionParameters, {"closing_plan": "fixed"}))
    fixed.fly()
    winches = Approach(monkeypatch, system=load_system("zenit_4mu"))
    winches.fly()
    assert sum(fixed.work) == sum(winches.work) == fixed.looks == winches.looks == 0
