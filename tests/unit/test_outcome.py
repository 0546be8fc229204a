import json
import math
import os
from types import SimpleNamespace

import pytest

from tethernet_bringup.mission import outcome, outcome_text
from tethernet_bringup.mission.outcome import ExitStatus, FlightRecord
from tethernet_core.mission import Phase
from tethernet_core.system import load_system

ISSUE_KEYS = {
    "captured", "verdict", "cqi", "cqi_all", "locked_pairs", "trigger_time_s", "end_time_s", "fuel_kg",
    "fuel_at_trigger_kg", "mouth_area_m2", "net_debris_distance_m", "max_tracking_error_m", "wall_time_s",
    "real_time_factor", "messages",
    "deadline_misses", "seed", "mus", "policy", "commit",
}  # fmt: skip


def stamp(seconds):
    return SimpleNamespace(sec=math.floor(seconds), nanosec=round((seconds % 1.0) * 1e9))


def header(seconds):
    return SimpleNamespace(stamp=stamp(seconds), frame_id="launch")


def state(phase, launch=0.0, closing=0.0, end=0.0, reason="", sequence=None, planner=7, hold_s=0.0, tow=0.0):
    return SimpleNamespace(
        phase=int(phase), launch_time=stamp(launch), closing_time=stamp(closing), end_time=stamp(end), reason=reason,
        sequence=int(phase) if sequence is None else sequence, mission_id=planner, hold_duration=hold_s, tow=tow,
        hold_time=stamp(end + 0.05 if hold_s else 0.0), hold_end_time=stamp(end + 0.05 + hold_s if hold_s else 0.0),
    )  # fmt: skip


def status(seconds, fuel=0.1, error=0.2, misses=0):
    return SimpleNamespace(
        header=header(seconds), fuel=fuel, fuel_at_trigger=fuel / 2, max_tracking_error=error, tracking_error=error,
        deadline_misses=misses, rejected_odometry=0, aiming_source="nominal",
    )  # fmt: skip


def assessment(seconds, captured=True, cqi=1.5, mouth=420.0):
    return SimpleNamespace(
        header=header(seconds), captured=captured, cqi=cqi, cqi_all=cqi + 0.9,
        locked_pairs=7, max_locked_pairs=8, required_locked_pairs=6,
        mouth_area=mouth, net_debris_distance=0.8, source="net_state", verdict="the debris is held",
        mcqi=1.1, enclosed_valid=True, enclosed=True, max_load_share=0.25, max_contact_force=800.0,
        held_valid=False, held=False, hold_verdict="", prediction_valid=False,
    )  # fmt: skip


def sim(seconds, late=(0,) * 4):
    return SimpleNamespace(
        header=header(seconds), finished=True,
        late_commands=list(late), rejected_commands=[0] * 4, clipped_commands=[0] * 4,
        latency_p50=0.002, latency_p99=0.004, latency_max=0.006,
    )  # fmt: skip


def flown(captured=True, offset=0.0):
    record = FlightRecord(
        system=load_system("zenit_4mu"),
        seed=1,
        policy="nominal",
        commit="abc",
        start_s=4.0,
        wall_time_s=20.0,
        memory_mb=900.0,
    )
    record.take_state(state(Phase.DEPLOYING, offset))
    record.take_state(state(Phase.COMPLETE, offset, offset + 25.0, offset + 40.0))
    record.statuses = {mu: status(offset + 40.0, fuel=mu / 10, misses=mu == 2) for mu in range(1, 5)}
    record.trigger = assessment(offset + 25.0)
    record.final = record.progress = assessment(offset + 40.0, captured)
    record.sim = sim(offset + 40.0, (0, 0, 3, 0))
    record.messages = {"/mu1/odom": 800, "/clock": 801}
    return record


def test_the_keys_that_users_rely_on_are_there_even_when_nothing_happened():
    content = outcome.build(FlightRecord(system=load_system("zenit_8mu"), seed=1, policy="nominal"))
    assert set(content) >= ISSUE_KEYS
    assert content["captured"] is False
    assert content["fuel_kg"] == [None] * 8
    assert content["trigger_time_s"] is None
    assert content["end_time_s"] is None
    json.dumps(content, allow_nan=False)


@pytest.mark.parametrize("launch", [0.0, 1000.5])
def test_times_count_from_launch(launch):
    content = outcome.build(flown(offset=launch))
    assert content["trigger_time_s"] == pytest.approx(25.0)
    assert content["end_time_s"] == pytest.approx(40.0)
    assert content["real_time_factor"] == pytest.approx(2.0)


def test_a_flown_mission_is_told_in_full():
    content = outcome.build(flown())
    assert content["captured"] is True
    assert content["verdict"] == "the debris is held"
    assert content["fuel_kg"] == pytest.approx([0.1, 0.2, 0.3, 0.4])
    assert content["fuel_at_trigger_kg"] == pytest.approx([0.05, 0.1, 0.15, 0.2])
    assert (content["cqi"], content["cqi_all"]) == (1.5, 2.4)
    assert content["mouth_area_m2"] == 420.0
    assert content["deadline_misses"] == 4
    assert (content["late_commands"], content["odometry_gaps"]) == (3, 1)
    assert content["latency_p99_ms"] == 4.0
    assert list(content["messages"]) == ["/clock", "/mu1/odom"]
    assert (content["seed"], content["mus"], content["policy"], content["commit"]) == (1, 4, "nominal", "abc")


def held_test(record, held=True, share=0.4, interrupted="", fault=""):
    """The same flight with a hold test of 60 s, towed with 20 N, at the end of which the load is ``share``."""
    record.take_state(state(Phase.HOLDING, 0.0, 25.0, 40.0, sequence=8, hold_s=60.0, tow=20.0))
    if interrupted or fault:
        record.interrupted_by, record.faults = interrupted, [fault] if fault else []
        return record
    record.take_state(state(Phase.COMPLETE, 0.0, 25.0, 40.0, sequence=9, hold_s=60.0, tow=20.0))
    hold = assessment(100.05, captured=False, cqi=0.5)
    hold.held_valid, hold.held = held is not None, held is True
    hold.hold_verdict, hold.max_load_share, hold.enclosed = "as it is", share, held is True
    record.hold = record.progress = hold
    return record


def test_a_hold_test_stands_beside_the_verdict():
    content = outcome.build(held_test(flown()))
    assert (content["captured"], content["held"], content["hold_verdict"]) == (True, True, "as it is")
    assert (content["hold_s"], content["tow_n"]) == (60.0, 20.0)
    assert (content["end_time_s"], content["hold_end_time_s"]) == pytest.approx((40.0, 100.05))
    assert (content["cqi"], content["mcqi"], content["enclosed"]) == (1.5, 1.1, True), "of the verdict"
    assert (content["max_load_share"], content["max_contact_force_n"]) == (0.4, 800.0), "of the whole mission"
    assert content["exit_status"] == 0
    lost = outcome.build(held_test(flown(), held=False))
    assert (lost["captured"], lost["held"], lost["exit_status"], lost["enclosed"]) == (True, False, 0, True)
    assert outcome.build(held_test(flown(), held=None))["held"] is None
    plain = outcome.build(flown())
    assert (plain["held"], plain["hold_verdict"], plain["hold_s"], plain["hold_end_time_s"]) == (None, None, 0.0, None)
    assert plain["max_load_share"] == 0.25


def test_the_headline_says_both(tmp_path):
    for held, word in (
        (True, "  HELD   as it is"),
        (False, "  NOT HELD   as it is"),
        (None, "  HOLD UNKNOWN   as it is"),
    ):
        record = held_test(flown(), held)
        lines = outcome_text.describe(record, outcome.build(record), tmp_path, "")
        assert lines[1] == "  CAPTURED   the debris is held"
        assert lines[2] == f"{word} (60 s after the verdict, towed with 20 N)"
    assert any("40.0 % of a thread's strength, 800 N of contact" in line for line in lines)
    missed = flown(captured=False)
    missed.state = state(Phase.MISSED, end=40.0, hold_s=60.0, tow=20.0)
    missed.state.hold_time = missed.state.hold_end_time = stamp(0.0)
    missed.hold = assessment(40.0, captured=False)
    missed.hold.held_valid, missed.hold.hold_verdict = True, "not held: missed: too far"
    lines = outcome_text.describe(missed, outcome.build(missed), tmp_path, "")
    assert lines[2] == "  NOT HELD   not held: missed: too far", "it was never tested"


def test_a_mission_ended_by_hand_in_its_hold_test_has_not_done_what_was_asked():
    record = held_test(flown(), interrupted="SIGINT")
    assert outcome.exit_status(record) == ExitStatus.INTERRUPTED
    content = outcome.build(record)
    assert (content["captured"], content["held"]) == (False, None)
    assert content["verdict"] == "ended by SIGINT 40.0 s after launch: the hold test was not over (the debris is held)"


@pytest.mark.parametrize("aborted", [False, True])
def test_a_fault_in_the_hold_test_leaves_the_verdict_that_was_made_before_it(aborted):
    record = held_test(flown(), fault="planner died")
    if aborted:  # as the planner does where it is told to, or hears nothing any more
        record.take_state(state(Phase.ABORTED, 0.0, 25.0, 40.0, sequence=9, hold_s=60.0, tow=20.0))
    content = outcome.build(record)
    assert (content["captured"], content["exit_status"]) == (False, 1)
    assert content["verdict"] == "planner died; the hold test was not over (the debris is held)"
    assert content["capture_verdict"] == "the debris is held"
    assert (content["held"], content["hold_verdict"], content["hold_end_time_s"]) == (None, None, None)
    assert (content["cqi"], content["end_time_s"]) == (1.5, 40.0), "of the verdict"


def test_a_fault_that_is_found_after_the_hold_test_says_nothing_of_it():
    record = held_test(flown())
    record.faults.append("the bag is gone")
    content = outcome.build(record)
    assert (content["verdict"], content["capture_verdict"]) == ("the bag is gone", "the debris is held")
    assert (content["held"], content["hold_verdict"]) == (True, "as it is")
    assert outcome.build(FlightRecord(load_system("zenit_4mu"), 1, "nominal"))["capture_verdict"] is None


def test_what_could_not_be_measured_is_null_and_not_nan(tmp_path):
    record = flown()
    record.final.cqi = record.progress.cqi = math.nan
    record.trigger.mouth_area = math.nan
    path = outcome.write(tmp_path, outcome.build(record))
    text = path.read_text()
    assert "NaN" not in text
    assert json.loads(text)["cqi"] is None
    assert json.loads(text)["mouth_area_m2"] is None


def test_what_comes_from_no_unit_of_the_mission_counts_nowhere():
    record = flown()
    expected = outcome.build(record)
    record.statuses[200] = status(40.0, fuel=99.0, error=5.0, misses=7)
    assert outcome.build(record) == expected


@pytest.mark.parametrize("first", [True, False])
def test_a_number_that_is_none_takes_the_place_of_no_other(first):
    record = flown()
    broken = status(40.0, fuel=math.nan, error=math.nan)
    record.statuses = {1: broken, 2: status(40.0, error=0.3)} if first else {1: status(40.0, error=0.3), 2: broken}
    content = outcome.build(record)
    assert content["max_tracking_error_m"] == 0.3
    assert sorted(content["fuel_kg"][:2], key=lambda fuel: fuel is None) == [0.1, None]
    json.dumps(content, allow_nan=False)


def test_captured_is_what_the_exit_status_says():
    cases = {"captured": flown(), "missed": flown(captured=False), "faulted": flown(), "nothing": flown()}
    cases["faulted"].faults.append("nothing new has been heard")
    cases["nothing"].forget_what_was_heard()
    for name, record in cases.items():
        content = outcome.build(record)
        assert content["exit_status"] == outcome.exit_status(record), name
        assert content["captured"] == (content["exit_status"] == 0), name
    assert outcome.build(cases["faulted"])["cqi"] == 1.5, "what was measured is told all the same"


def test_a_missed_mission_has_an_end_and_no_trigger():
    record = flown(captured=False)
    record.state = state(Phase.MISSED, end=40.0, reason="the net did not come near")
    content = outcome.build(record)
    assert content["trigger_time_s"] is None
    assert content["end_time_s"] == 40.0


@pytest.mark.parametrize(("reason", "told"), [("on request", "on request"), ("", "no reason was given")])
def test_an_abort_is_told_with_its_reason(reason, told):
    record = FlightRecord(system=load_system("zenit_4mu"), seed=1, policy="nominal")
    record.take_state(state(Phase.DEPLOYING))
    record.take_state(state(Phase.ABORTED, reason=reason))
    assert outcome.build(record)["verdict"] == f"aborted: {told}"


def test_exit_statuses():
    assert outcome.exit_status(flown()) == ExitStatus.CAPTURED == 0
    assert outcome.exit_status(flown(captured=False)) == ExitStatus.NOT_CAPTURED == 3
    broken = flown()
    broken.faults.append("recorder died")
    assert outcome.exit_status(broken) == ExitStatus.FAULT == 1
    assert outcome.verdict(broken) == "recorder died"
    for signal, expected in (("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 130)):
        stopped = FlightRecord(system=load_system("zenit_4mu"), seed=1, policy="nominal", interrupted_by=signal)
        assert outcome.exit_status(stopped) == expected
        assert signal in outcome.verdict(stopped)
    assert (
        outcome.exit_status(FlightRecord(system=load_system("zenit_4mu"), seed=1, policy="nominal")) == ExitStatus.FAULT
    )


def test_the_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    outcome.write(tmp_path, {"captured": True})
    with pytest.raises(ValueError, match="JSON"):
        outcome.write(tmp_path, {"captured": math.nan})
    assert json.loads((tmp_path / "outcome.json").read_text()) == {"captured": True}
    monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(OSError, match="No space"):
        outcome.write(tmp_path, {"captured": False})
    assert [path.name for path in tmp_path.iterdir()] == ["outcome.json"]
    assert json.loads((tmp_path / "outcome.json").read_text()) == {"captured": True}


def test_the_last_lines_name_the_verdict_the_files_and_what_to_do_next(tmp_path):
    record = flown()
    record.lost_controllers.add(3)
    record.warnings.append("mu3_controller died")
    text = "\n".join(outcome_text.describe(record, outcome.build(record), tmp_path, "python analyse_mission.py RUN"))
    told = ("CAPTURED", "7 of 8 (6 needed)", "25.00 s", "MU 4: 0.400 kg", "MU 3", "mu3_controller died")
    for part in (*told, str(tmp_path / "bag"), str(tmp_path / "outcome.json"), "python analyse_mission.py RUN"):
        assert part in text
    record.final.cqi = math.nan
    assert "could not be measured" in "\n".join(outcome_text.describe(record, outcome.build(record), tmp_path, ""))


def test_an_end_before_launch_is_told_although_some_controllers_were_never_heard(tmp_path):
    record = FlightRecord(system=load_system("zenit_4mu"), seed=1, policy="nominal")
    record.statuses = {3: status(0.0, fuel=0.0)}
    text = "\n".join(outcome_text.describe(record, outcome.build(record), tmp_path, ""))
    assert "most by MU 3: 0.000 kg" in text


def test_one_clock_gone_wrong_does_not_make_a_mission_longer():
    record = FlightRecord(system=load_system("zenit_8mu"), seed=1, policy="nominal")
    assert record.most_flown_s is None
    record.take_state(state(Phase.DEPLOYING, launch=5.0))
    record.statuses = {mu: SimpleNamespace(header=header(12.0)) for mu in range(1, 9)}
    record.statuses[3] = SimpleNamespace(header=header(1.7e9))
    assert record.most_flown_s == 7.0


def test_states_that_do_not_count_are_not_put_on_record():
    record = FlightRecord(system=load_system("zenit_4mu"), seed=1, policy="nominal")
    record.take_state(state(Phase.DEPLOYING, 5.0))
    for forged in (
        state(Phase.COMPLETE, sequence=2**32 - 1),
        state(Phase.COMPLETE, planner=0),
        state(99, sequence=3),
        state(Phase.ARMED),
    ):
        record.take_state(forged)
        assert record.phase == Phase.DEPLOYING
    record.take_state(state(Phase.CLOSING, 5.0))
    assert record.phase == Phase.CLOSING
    record.take_state(state(Phase.ABORTED, planner=0, sequence=1))
    assert record.phase == Phase.ABORTED
