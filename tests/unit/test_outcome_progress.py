import io
import math
from types import SimpleNamespace

from tests.unit.test_outcome import assessment, state, status
from tethernet_bringup.mission.live_display import Display, flight_line
from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_core.mission import Phase
from tethernet_core.system import load_system


def record_at(seconds, phase=Phase.DEPLOYING, **times):
    record = FlightRecord(system=load_system("zenit_4mu"), seed=1, policy="nominal")
    record.take_state(state(phase, **times))
    record.statuses = {mu: status(seconds) for mu in range(1, 5)}
    record.progress = assessment(seconds)
    return record


def test_the_line_tells_all_and_fits_a_terminal():
    line = flight_line(record_at(12.3))
    for part in ("12.3 s", "DEPLOYING", "distance  0.80 m", "error 0.20 m", "fuel 0.400 kg", "pairs 7/8"):
        assert part in line
    assert len(line) < 80


def test_what_is_not_known_is_a_dash():
    record = record_at(1.0)
    record.progress.net_debris_distance = math.nan
    assert "distance     - m" in flight_line(record)


def test_plain_lines_come_every_two_seconds_of_mission_time():
    out = io.StringIO()
    display = Display(out, 2.0)
    for tick in range(200):
        display.flight(record_at(tick * 0.05))
    lines = out.getvalue().splitlines()
    assert lines[0].endswith("launch: the units pull the net open")
    assert [line.split()[0] for line in lines[1:]] == ["0.0", "2.0", "4.0", "6.0", "8.0"]
    assert "\x1b" not in out.getvalue()


def test_a_jump_in_time_gives_one_line():
    out = io.StringIO()
    display = Display(out, 2.0)
    display.flight(record_at(0.0))
    display.flight(record_at(7.9))
    display.flight(record_at(8.0))
    assert [line.split()[0] for line in out.getvalue().splitlines()[1:]] == ["0.0", "7.9", "8.0"]


def test_a_terminal_gets_one_line_that_is_overwritten():
    out = io.StringIO()
    display = Display(out, 2.0, live=True)
    display.flight(record_at(1.0))
    display.note("mu3_controller died")
    assert out.getvalue().count("\n") == 2
    assert "\r\x1b[K" in out.getvalue()
    assert out.getvalue().endswith("mu3_controller died\n")


def test_phases_are_told_once_and_with_the_reason():
    out = io.StringIO()
    display = Display(out, 2.0)
    missed = record_at(40.0, Phase.MISSED, end=40.0)
    missed.state.reason = "too far"
    display.flight(missed)
    display.flight(missed)
    assert out.getvalue() == "  40.0 s  missed: too far\n"


def test_a_reader_that_goes_away_does_not_disturb():
    def gone(_):
        raise BrokenPipeError

    display = Display(SimpleNamespace(write=gone, flush=lambda: None, isatty=lambda: False), 2.0)
    display.note("one")
    display.note("two")
    display.flight(record_at(1.0))
