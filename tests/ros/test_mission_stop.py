"""Ctrl-C and worse, at any time: everything ends, in time, with a readable bag."""

import signal
from pathlib import Path

import pytest

from tests.ros.mission_command import FLYING, STOP_S, MissionCommand, read_bag
from tethernet_bringup.mission import shared_memory

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


def test_interrupt_while_the_kernels_compile(tmp_path, domain_id, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    with MissionCommand(tmp_path / "runs", domain_id, *REALTIME) as mission:
        mission.wait_for("sim: compiling the physics kernels")
        status, took = mission.stop(signal.SIGINT)
        assert (status, took < STOP_S) == (130, True), mission.text
        mission.finish()
        assert mission.outcome["exit_status"] == 130
        assert mission.outcome["warnings"] == [], "the compiler keeps nobody from ending"


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
        assert outcome["warnings"] == [], "and no node had to be killed to keep the promise"
        assert outcome["flown_s"] > 0.5
        messages = read_bag(mission.run)
        assert messages["/mission/state"][-1].phase == 6, "the abort is on record"
        assert len(messages["/mu3/thrust"]) > 10
        assert {topic: len(messages.get(topic, [])) for topic in outcome["messages"]} == outcome["messages"]


def test_interrupt_in_a_hold_test(tmp_path, domain_id):
    parameters = tmp_path / "parameters.yaml"
    parameters.write_text("/**:\n  ros__parameters:\n    capture_duration_s: 1.0\n")
    flags = ("--pace", "lockstep", "--hold", "900", "--tow", "5", "--params", str(parameters))
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        mission.wait_for(r"\d s  HOLDING")
        status, took = mission.stop(signal.SIGINT)
        assert (status, took < STOP_S) == (130, True), mission.text
        mission.finish()
        outcome = mission.outcome
        assert (outcome["captured"], outcome["held"], outcome["hold_s"]) == (False, None, 900.0)
        assert "the hold test was not over (not captured: CQI" in outcome["verdict"], "the verdict was made before"
        assert outcome["cqi"] > 0.0
        assert read_bag(mission.run)["/mission/state"][-1].phase == 6, "the abort is on record"


def test_nodes_end_and_the_bag_is_closed_when_the_command_is_killed(tmp_path, domain_id):
    with MissionCommand(tmp_path, domain_id, *REALTIME) as mission:
        mission.wait_for(FLYING)
        segments = shared_memory.held_by([mission.process.pid, *mission.nodes().values()])
        status, took = mission.stop(signal.SIGKILL)
        assert status == -signal.SIGKILL
        assert took < 2 * STOP_S

        def in_use() -> set[str]:  # some names are used again by whatever else runs on this machine
            return shared_memory.held_by(int(p.name) for p in Path("/proc").iterdir() if p.name.isdigit())

        mission.wait(
            lambda: not [name for name in segments - in_use() if (shared_memory.FOLDER / name).exists()],
            "the shared memory to go",
        )
        assert len(read_bag(mission.run)["/mu3/thrust"]) > 10
