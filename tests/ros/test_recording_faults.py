"""A recording that goes wrong while the mission flies is a fault, said at its end at the latest."""

import os
import signal

import pytest

from tests.ros.mission_command import FLYING, MissionCommand, read_bag
from tethernet_bringup.bags.salvage import salvage
from tethernet_bringup.recorder.recording import faults

pytestmark = pytest.mark.ros


def short(tmp_path, seconds, **more):
    """A parameter file with which a mission is given up soon."""
    path = tmp_path / "short.yaml"
    lines = [f"    {key}: {value}" for key, value in {"give_up_s": seconds, **more}.items()]
    path.write_text("/**:\n  ros__parameters:\n" + "\n".join(lines) + "\n")
    return ("--params", str(path))


def test_a_recorder_that_hangs_in_flight_ends_the_mission(tmp_path, domain_id):
    with MissionCommand(tmp_path / "runs", domain_id, *short(tmp_path, 30.0, hang_timeout_s=2.0)) as mission:
        mission.wait_for(FLYING)
        os.kill(mission.nodes()["recorder"], signal.SIGSTOP)
        assert mission.finish() == 1
        assert mission.outcome["verdict"] == "recorder hangs: it has answered nothing for 2 s"
        assert salvage(mission.run / "bag", tmp_path / "salvaged").message_count > 0


def test_a_recorder_that_hangs_until_the_mission_is_over_is_a_fault(tmp_path, domain_id):
    """In lock-step the mission is over before the recorder can be missed."""
    with MissionCommand(tmp_path / "runs", domain_id, "--pace", "lockstep", *short(tmp_path, 10.0)) as mission:
        mission.wait_for(FLYING)
        os.kill(mission.nodes()["recorder"], signal.SIGSTOP)
        assert mission.finish() == 1
        assert "ended without closing the bag" in mission.outcome["verdict"]
        assert "FAULT" in mission.text


@pytest.mark.parametrize("what", ["deleted", "replaced", "cut"])
def test_a_bag_that_is_tampered_with_in_flight_is_a_fault(tmp_path, domain_id, what):
    with MissionCommand(tmp_path / "runs", domain_id, "--pace", "lockstep", *short(tmp_path, 20.0)) as mission:
        mission.wait_for(FLYING)
        path = mission.run / "bag" / "bag_0.mcap"
        if what == "cut":
            os.truncate(path, 20_000)
        else:
            path.unlink()
            if what == "replaced":
                path.write_bytes(b"\x89MCAP0\r\n" + bytes(5000))
        assert mission.finish() == 1
        assert "the bag was changed while it was recorded" in mission.outcome["verdict"]
        assert "bag_0.mcap" in mission.outcome["verdict"]
        assert "the bag was changed" in mission.text


@pytest.mark.parametrize("folder", ["runs", "Flüge 漢字"])
def test_a_recording_that_is_left_alone_has_no_faults(tmp_path, domain_id, monkeypatch, folder):
    monkeypatch.setenv("LC_ALL", "C")  # the poorest locale: no letter of the other name is in it
    with MissionCommand(tmp_path / folder, domain_id, "--pace", "lockstep", *short(tmp_path, 5.0)) as mission:
        assert mission.finish() == 3
        assert faults(mission.run, mission.run / "bag") == []
        assert len(read_bag(mission.run)["/mu3/thrust"]) > 10
