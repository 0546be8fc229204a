"""A mission that nobody ends is ended by the command: with the reason, within a stated time, as a fault."""

import dataclasses
import io
import time
from types import SimpleNamespace

import pytest

from tests.unit.test_outcome import header, state, status
from tests.unit.test_supervisor_flight import Crew, Graph
from tethernet_bringup.mission import outcome
from tethernet_bringup.mission.conductor import Flight
from tethernet_bringup.mission.flight_plan import FlightPlan
from tethernet_bringup.mission.interrupts import Interrupts
from tethernet_bringup.mission.live_display import Display
from tethernet_bringup.mission.outcome import ExitStatus, FlightRecord
from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_core.mission import Phase
from tethernet_core.parameters import load
from tethernet_core.system import load_system

SYSTEM = load_system("zenit_4mu")
LONGEST_S = 55.0
SILENCE_S = 0.2
BROKEN = "the simulation diverged 0.20 s after launch"


class Flying(Graph):
    """A graph in which a mission flies; every look at it makes what is told of it newer."""

    def __init__(self, record, tell):
        super().__init__()
        self._record, self._tell = record, tell
        self.looks = 0

    def spin(self, _):
        super().spin(_)
        self.looks += 1
        assert self.looks < 3000, "nobody ends it"
        self._tell(self._record, self.looks)


def ended(tmp_path, tell, launched=True):
    """The record of a mission of which this is told."""
    parameters = dataclasses.replace(load(SupervisorParameters), probe_s=0.01, silence_timeout_s=SILENCE_S)
    plan = FlightPlan((), SYSTEM, (), True, 903, 1.0, parameters, longest_s=LONGEST_S)
    record = FlightRecord(system=SYSTEM, seed=1, policy="nominal")
    flight = Flight(
        plan, Crew(tmp_path), Interrupts(), record, Display(io.StringIO(), 2.0), time.monotonic(),
        lambda record: Flying(record, tell),
    )  # fmt: skip
    if launched:
        record.take_state(confirmed(Phase.DEPLOYING))
        record.statuses = {mu: status(0.0) for mu in range(1, 5)}
        for step in ("assemble", "await_drivers", "know_publishers"):
            setattr(flight._assembly, step, lambda: None)
        flight._launch = lambda: None
    flight.fly()
    return record


def confirmed(phase, **more):
    """A state of the mission that all controllers have echoed."""
    made = state(phase, **more)
    made.confirmed = True
    return made


def clocks(record, seconds):
    for told in record.statuses.values():
        told.header = header(seconds)


def assert_fault(record, verdict):
    content = outcome.build(record)
    assert content["verdict"] == verdict
    assert (content["captured"], content["exit_status"]) == (False, ExitStatus.FAULT)


@pytest.mark.parametrize("launched", [False, True])
def test_a_simulation_that_diverges_is_a_fault_with_its_own_sentence(tmp_path, launched):
    def tell(record, looks):
        broken = looks > 3 or not launched
        record.sim = SimpleNamespace(header=header(0.05 * looks), fault=BROKEN if broken else "")
        record.sim.late_commands = record.sim.rejected_commands = record.sim.clipped_commands = [0] * 4
        record.sim.latency_p50 = record.sim.latency_p99 = record.sim.latency_max = 0.0

    assert_fault(ended(tmp_path, tell, launched), BROKEN)


def test_a_mission_of_which_nothing_is_heard_is_ended(tmp_path):
    begin = time.monotonic()
    record = ended(tmp_path, lambda record, looks: clocks(record, min(0.05 * looks, 3.0)))
    assert time.monotonic() - begin >= SILENCE_S
    assert_fault(record, f"nothing new has been heard of the mission for {SILENCE_S:g} s, at 3.00 s after launch")


def test_a_mission_that_its_planner_does_not_end_is_ended(tmp_path):
    """Everything lives and speaks; the longest mission that the rules allow is over, and some seconds more."""
    heard = []

    def tell(record, looks):
        heard.append(float(looks))
        clocks(record, heard[-1])

    record = ended(tmp_path, tell)
    assert LONGEST_S < heard[-1] <= LONGEST_S + 6.0
    longest = f"the longest mission takes {LONGEST_S:g} s"
    assert_fault(record, f"the planner has not ended the mission {heard[-1]:.1f} s after launch; {longest}")


def test_a_clock_gone_wrong_ends_no_mission_early(tmp_path):
    """One of four tells of a far future: the time flown is that of the others."""

    def tell(record, looks):
        clocks(record, 0.1 * looks)
        record.statuses[3].header = header(1.7e9)
        if looks == 100:
            record.take_state(confirmed(Phase.ABORTED, reason="asked for"))

    assert_fault(ended(tmp_path, tell), "the mission was aborted: asked for")
