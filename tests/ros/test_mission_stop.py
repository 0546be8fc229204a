"""Ctrl-C and worse, at any time: everything ends, in time, with a readable bag."""

import signal

import pytest

from tests.ros.mission_command import FLYING, STOP_S, MissionCommand, read_bag

pytestmark = pytest.mark.ros
REALTIME = ("--pace", "realtime")


@pytest.mark.parametrize("moment", ["mission:", "run:"])
def test_interrupt_during_start_up(tmp_path, domain_id, moment):
    with MissionCommand(tmp_path, domain_id, *REALTIME) as mission:
        mission.wait_for(moment)
        status, took = mission.stop(signal.SIGINT)
        assert status == 130, mission.text
        assert took < STOP_S
        assert "Traceback" not in mission.text
        mission.finish()
        assert mission.outcome["captured"] is False
        assert "SIGINT before launch" in mission.outcome["verdict"]


def test_interrupt_when_the_nodes_are_up(tmp_path, domain_id):
    with MissionCommand(tmp_path, domain_id, "--external-mu", "3", *REALTIME) as mission:
        mission.wait_for(r"mu_driver\.py --mu 3")
        status, took = mission.stop(signal.SIGINT)
        assert (status, took < STOP_S) == (130, True)
        assert read_bag(mission.run)["/mission/state"]


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_interrupt_in_flight(tmp_path, domain_id, number, status):
    with MissionCommand(tmp_path, domain_id, *REALTIME) as mission:
        mission.wait_for(FLYING)
        ended, took = mission.stop(number)
        assert ended == status, mission.text
        assert took < STOP_S
        mission.finish()
        assert "Traceback" not in mission.text
        outcome = mission.outcome
        assert outcome["captured"] is False
        assert number.name in outcome["verdict"]
        # On a machine with far too little CPU time a node may have to be killed to keep the promise of 6 s.
        assert [warning for warning in outcome["warnings"] if "was killed" not in warning] == []
        assert outcome["flown_s"] > 0.5
        messages = read_bag(mission.run)
        assert messages["/mission/state"][-1].phase == 6, "the abort is on record"
        assert len(messages["/mu3/thrust"]) > 10
        assert {topic: len(messages.get(topic, [])) for topic in outcome["messages"]} == outcome["messages"]


def test_nodes_end_and_the_bag_is_closed_when_the_command_is_killed(tmp_path, domain_id):
    with MissionCommand(tmp_path, domain_id, *REALTIME) as mission:
        mission.wait_for(FLYING)
        status, took = mission.stop(signal.SIGKILL)
        assert status == -signal.SIGKILL
        assert took < 2 * STOP_S
        assert len(read_bag(mission.run)["/mu3/thrust"]) > 10
