"""A controller in a hold test: off from the verdict on, and still answering."""

import dataclasses

from tests.unit.test_controller import CONTROL, DEBRIS, PERIOD, RULES, STILL, closing, controller, fly, launched
from tethernet_core.mission import Mode, Phase
from tethernet_core.system import load_system
from tethernet_planner.mission_rules import advance


def test_units_are_off_from_the_verdict_to_the_end_of_a_hold_test():
    mission = dataclasses.replace(launched(), hold_s=2.0, tow_n=20.0)
    made = controller(mission)
    fly(made, range(481))
    closed = closing(mission, 480)
    made.take_mission(closed)
    end = closed.end_ns // PERIOD
    assert fly(made, range(481, end)) != STILL
    assert fly(made, [end]) == STILL, "whoever hears of it when"
    fuel = made.statistics.fuel_kg
    holding = advance(closed, load_system("zenit_8mu"), end * PERIOD, DEBRIS, DEBRIS, RULES, CONTROL)
    assert holding.phase == Phase.HOLDING
    assert made.take_mission(holding)
    commands, misses = made.statistics.commands, made.statistics.deadline_misses
    assert fly(made, range(end + 1, end + 42)) == STILL
    assert (made.mode, made.statistics.fuel_kg) == (Mode.OFF, fuel)
    assert made.statistics.commands == commands + 41, "in lock-step the simulator waits for its answers"
    assert made.statistics.deadline_misses == misses
    assert made.take_mission(holding.next(Phase.COMPLETE))
    assert made.mode == Mode.OFF
