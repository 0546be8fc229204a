"""Which states of the mission are followed."""

import dataclasses

import pytest

from tethernet_core.mission import Mission, Phase, abort, arm, launch
from tethernet_core.mission_gate import MissionGate

DEBRIS = (0.0, 0.0, -50.0)
MINE, OTHERS, FORGED = 11, 22, 0


def waiting(planner):
    return Mission(8, mission_id=planner)


def armed(planner):
    return arm(waiting(planner), DEBRIS, "nominal")


def flying(planner, sequence=2):
    return dataclasses.replace(launch(armed(planner), 0), sequence=sequence)


def gate(*states):
    made = MissionGate(Mission(8))
    for state in states:
        assert made.take(state)
    return made


def test_one_planners_states_in_order():
    made = gate(waiting(MINE), armed(MINE), flying(MINE))
    assert not made.take(armed(MINE))
    assert not made.take(flying(MINE))
    assert made.is_present(flying(MINE))
    assert made.mission == flying(MINE)
    assert made.refused == 0


@pytest.mark.parametrize("planner", [MINE, OTHERS, FORGED])
def test_the_largest_sequence_number_blocks_nothing(planner):
    made = gate(waiting(MINE), armed(MINE), flying(MINE))
    assert not made.take(flying(planner, 2**32 - 1))
    assert made.refused == 1
    assert made.take(flying(MINE, 3))


def test_before_a_flight_a_forged_state_does_not_block_the_planners_own():
    made = gate(waiting(MINE))
    made.take(dataclasses.replace(armed(FORGED), sequence=2**32 - 1))
    assert made.take(armed(MINE))
    assert made.take(flying(MINE))


@pytest.mark.parametrize("state", [waiting(OTHERS), armed(OTHERS), flying(OTHERS)])
def test_in_flight_another_planner_leads_only_where_the_first_has_fallen_silent(state):
    made = gate(waiting(MINE), armed(MINE), flying(MINE))
    assert not made.take(state)
    assert made.mission.mission_id == MINE
    assert made.take(state, leader_lost=True)
    assert made.mission.mission_id == OTHERS


@pytest.mark.parametrize("planner", [MINE, OTHERS, FORGED])
@pytest.mark.parametrize("sequence", [0, 1, 2, 3, 2**32 - 1])
def test_an_abort_is_obeyed_in_flight_whoever_says_it(planner, sequence):
    made = gate(waiting(MINE), armed(MINE), flying(MINE))
    assert made.take(dataclasses.replace(abort(waiting(planner), "stop"), sequence=sequence))
    assert made.mission.phase == Phase.ABORTED
    assert not made.take(flying(MINE, 3)), "the mission that was aborted is over"
    assert made.mission.phase == Phase.ABORTED
    assert made.take(armed(99)), "a new planner's is not"


def test_an_old_abort_does_not_stop_who_is_not_flying():
    made = gate(abort(waiting(OTHERS), "long ago"), waiting(MINE))
    assert not made.take(abort(waiting(OTHERS), "long ago"))
    assert made.mission.mission_id == MINE
    assert made.take(armed(MINE))


def test_what_is_remembered_is_bounded():
    made = MissionGate(Mission(8))
    for planner in range(1, 10_000):
        made.take(flying(planner), leader_lost=True)
        made.take(abort(waiting(planner), "stop"))
    assert len(made._counts) <= 16
    assert len(made._ended) <= 16
