import io
import time

from tethernet_bringup.flight import Flight, FlightPlan
from tethernet_bringup.interrupts import Interrupts
from tethernet_bringup.outcome import ExitStatus, FlightRecord, exit_status
from tethernet_bringup.progress import Display
from tethernet_bringup.supervisor_settings import SupervisorParameters
from tethernet_control.parameters import load


class Crew:
    """A supervisor that starts nothing."""

    def __init__(self, folder, error=None):
        self.log_folder = folder
        self.error = error
        self.stopped = self.started = False

    def start_all(self, _):
        self.started = True
        if self.error is not None:
            raise self.error

    def stop(self, hurry):
        self.stopped = True
        return []


def fly(crew, interrupts):
    plan = FlightPlan((), 8, (), True, 0, 1.0, load(SupervisorParameters))
    record = FlightRecord(mu_count=8, seed=1, policy="nominal")
    Flight(plan, crew, interrupts, record, Display(io.StringIO(), 2.0), time.monotonic()).fly()
    return record


def test_a_signal_before_the_first_process_starts_none(tmp_path):
    interrupts = Interrupts()
    interrupts.name = "SIGINT"
    crew = Crew(tmp_path)
    record = fly(crew, interrupts)
    assert not crew.started
    assert crew.stopped
    assert exit_status(record) == ExitStatus.INTERRUPTED


def test_processes_that_cannot_be_started_are_a_fault(tmp_path):
    crew = Crew(tmp_path, OSError(11, "Resource temporarily unavailable"))
    record = fly(crew, Interrupts())
    assert crew.stopped
    assert "Resource temporarily unavailable" in record.faults[0]


def test_what_nobody_foresaw_ends_the_mission_in_order_and_leaves_its_traceback(tmp_path):
    crew = Crew(tmp_path, RuntimeError("who would have thought"))
    record = fly(crew, Interrupts())
    assert crew.stopped
    assert exit_status(record) == ExitStatus.FAULT
    assert "who would have thought" in record.faults[0]
    assert "Traceback" in (tmp_path / "run_mission.log").read_text()
