"""What the planner knows when the closing is planned."""

import numpy as np

from tethernet_core.aiming import nominal_aiming_points
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_planner.closing_watch import ClosingWatch

CONTROL, RULES = load(ControlParameters), load(MissionParameters)
EIGHT, FOUR = load_system("zenit_8mu"), load_system("zenit_4mu")
DEBRIS = (0.0, 0.0, -50.0)
MOTION = (DEBRIS, (0.0, 0.0, 0.0, 1.0), (0.0,) * 3, (0.0,) * 3)
MOUTH = np.array(nominal_aiming_points(EIGHT, DEBRIS))
SECOND = 10**9


def closing_watch(system=EIGHT):
    mus = system.unit_count
    made = ClosingWatch(system, RULES, CONTROL)
    made.debris = lambda: MOTION
    made.aiming_points = nominal_aiming_points(system, DEBRIS)
    made.saw_mus(20 * SECOND, MOUTH[:mus], np.zeros((mus, 3)))
    return made


def test_a_healthy_swarm():
    seen = closing_watch().look()
    assert seen.lost == (False,) * 8
    assert np.allclose(seen.mu_positions, MOUTH)


def test_silent_dead_and_strayed_mus_are_lost():
    made = closing_watch()
    strayed = MOUTH.copy()
    strayed[6, 0] -= RULES.off_course_m + 0.1
    made.saw_mus(20 * SECOND, strayed, np.zeros((8, 3)), silent={2})
    for mu in range(1, 9):
        made.saw_status(mu, (18 if mu == 4 else 20) * SECOND)
    assert [mu for mu, lost in enumerate(made.look().lost, start=1) if lost] == [2, 4, 7]
    made.saw_status(4, 20 * SECOND)
    assert made.dead() == set()


def test_nothing_is_told_where_too_little_is_known():
    made = closing_watch()
    made.debris = lambda: None
    assert made.look() is None
    made = closing_watch()
    made.saw_mus(20 * SECOND, [], [])
    assert made.look() is None, "nobody was ever heard of"
    made.saw_mus(20 * SECOND, MOUTH[:7], np.zeros((7, 3)))
    assert made.look() is None, "one was never heard of"
    made.saw_mus(20 * SECOND, np.full((8, 3), np.nan), np.zeros((8, 3)))
    assert made.look() is None
    assert closing_watch(FOUR).look() is None, "winches close the net"


def test_a_status_from_the_future_does_not_hide_that_its_controller_dies():
    made = closing_watch()
    for mu in range(1, 9):
        made.saw_status(mu, 17 * SECOND)
    made.saw_status(4, 10**18)
    made.saw_status(200, 17 * SECOND)
    for mu in (1, 2, 3, 5, 6, 7, 8):
        made.saw_status(mu, 20 * SECOND)
    assert made.dead() == {4}
