"""What goes wrong in a hold test ends it with the true reason, and leaves the verdict that was made before it."""

import os
import signal

import pytest

from tests.ros.mission_command import MissionCommand, read_bag

pytestmark = pytest.mark.ros
HOLDING = r"\d s  HOLDING"
"""A line of progress in the hold test."""
PATIENCE_S = 2.0


def flags(tmp_path, hold_s, **patience):
    """A mission that is judged soon, whether captured or not, and then tested; how patient planner or command are."""
    path = tmp_path / "parameters.yaml"
    lines = ["/**:\n  ros__parameters:\n    capture_duration_s: 1.0\n"]
    lines += [f"{node}:\n  ros__parameters:\n    {name}: {PATIENCE_S}\n" for node, name in patience.items()]
    path.write_text("".join(lines))
    return ("--pace", "lockstep", "--hold", str(hold_s), "--tow", "20", "--params", str(path))


def check_kept(outcome):
    """What was found before the test is told, and that nobody knows whether it holds."""
    assert outcome["capture_verdict"].startswith("not captured: CQI"), "one second is no time to close a net"
    assert outcome["verdict"].endswith(f"; the hold test was not over ({outcome['capture_verdict']})")
    assert (outcome["captured"], outcome["exit_status"]) == (False, 1)
    assert (outcome["held"], outcome["hold_verdict"], outcome["hold_end_time_s"]) == (None, None, None)
    assert outcome["hold_s"] == 900.0
    assert outcome["cqi"] > 0.0
    assert outcome["end_time_s"] == pytest.approx(outcome["trigger_time_s"] + 1.0, abs=0.051)


SILENCE = ("planner", "silence_timeout_s", "the mission was aborted: nothing was measured for 2 s")
HANGS = ("run_mission", "hang_timeout_s", "planner hangs: it has answered nothing for 2 s")
DEATH = ("run_mission", "verdict_timeout_s", "planner died (killed by SIGKILL)")


@pytest.mark.parametrize(
    ("node", "number", "patience"),
    [("sim", signal.SIGSTOP, SILENCE), ("planner", signal.SIGSTOP, HANGS), ("planner", signal.SIGKILL, DEATH)],
    ids=["simulator halts", "planner halts", "planner killed"],
)
def test_a_hold_test_that_cannot_go_on_ends_with_the_reason(tmp_path, domain_id, node, number, patience):
    whose, what, reason = patience
    with MissionCommand(tmp_path / "runs", domain_id, *flags(tmp_path, 900.0, **{whose: what})) as mission:
        mission.wait_for(HOLDING)
        os.kill(mission.nodes()[node], number)
        assert mission.finish() == 1, mission.text
        assert mission.outcome["verdict"].startswith(reason), mission.text
        check_kept(mission.outcome)
        states = read_bag(mission.run)["/mission/state"]
        assert states[-1].phase == (6 if node == "sim" else 7), "the abort is on record where a planner was left to"


def test_a_hold_test_goes_on_without_controllers_for_units_are_off_in_it(tmp_path, domain_id):
    patience = {"run_mission": "hang_timeout_s", "sim": "answer_timeout_s"}
    with MissionCommand(tmp_path / "runs", domain_id, *flags(tmp_path, 100.0, **patience)) as mission:
        mission.wait_for(HOLDING)
        os.kill(mission.nodes()["mu3_controller"], signal.SIGKILL)
        os.kill(mission.nodes()["mu5_controller"], signal.SIGSTOP)
        assert mission.finish() == 3, mission.text
        outcome = mission.outcome
        assert outcome["lost_controllers"] == [3, 5], outcome["warnings"]
        assert outcome["faults"] == []
        off = [text for text in outcome["warnings"] if "the hold test goes on, in which all units are off" in text]
        assert ["mu3_controller died" in off[0], "mu5_controller hangs" in off[1], len(off)] == [True, True, 2]
        assert "thrust" not in "".join(outcome["warnings"])
        assert outcome["verdict"] == outcome["capture_verdict"]
        assert outcome["held"] is False, "a net that was not closed does not hold"
        assert outcome["hold_end_time_s"] == pytest.approx(outcome["end_time_s"] + 100.0, abs=0.101)
