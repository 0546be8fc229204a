import dataclasses
import io
import subprocess
import sys
import time
from typing import ClassVar

import pytest

from tethernet_bringup.mission.conductor import Flight
from tethernet_bringup.mission.connection_check import ConnectionCheck
from tethernet_bringup.mission.domain_claim import DomainClaim
from tethernet_bringup.mission.flight_plan import FlightPlan
from tethernet_bringup.mission.graph import GraphCheck, Publisher
from tethernet_bringup.mission.interrupts import Interrupts
from tethernet_bringup.mission.live_display import Display
from tethernet_bringup.mission.outcome import ExitStatus, FlightRecord, exit_status
from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_core.parameters import load
from tethernet_core.system import load_system
from tethernet_sim.compiling import COMPILED, COMPILING


class Crew:
    """A supervisor that starts nothing."""

    def __init__(self, folder, error=None):
        self.log_folder = folder
        self.error = error
        self.stopped = self.started = self.in_graph = False

    def start_all(self, _):
        self.started = True
        if self.error is not None:
            raise self.error

    def let_in(self):
        self.in_graph = True

    def deaths(self):
        return []

    def stand_by(self):
        pass

    def clean_up(self):
        pass

    def call_off(self):
        pass

    def stop(self, hurry):
        self.stopped = True
        return []


class Graph:
    """The command's own node in a graph with these publishers besides."""

    dropped: ClassVar[dict[str, str]] = {}

    def __init__(self, publishers=()):
        self._publishers = dict(publishers)

    def spin(self, _):
        time.sleep(0.001)

    def publishers(self, topic):
        return self._publishers.get(topic, [])


def fly(crew, interrupts, graph=None, domain_id=900):
    parameters = dataclasses.replace(load(SupervisorParameters), probe_s=0.01)
    plan = FlightPlan((), load_system("zenit_8mu"), (), True, domain_id, 1.0, parameters)
    record = FlightRecord(system=load_system("zenit_8mu"), seed=1, policy="nominal")
    display = Display(io.StringIO(), 2.0)
    Flight(plan, crew, interrupts, record, display, time.monotonic(), lambda _: graph or Graph()).fly()
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


HOLDER = """
import sys
from tethernet_bringup.mission.domain_claim import DomainClaim
claim = DomainClaim(901)
claim.take()
print("taken", flush=True)
sys.stdin.read()
"""


def test_nothing_is_started_in_a_domain_that_another_mission_holds(tmp_path):
    holder = subprocess.Popen([sys.executable, "-c", HOLDER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert holder.stdout.readline() == "taken\n"
    crew = Crew(tmp_path)
    record = fly(crew, Interrupts(), domain_id=901)
    assert not crew.started
    assert exit_status(record) == ExitStatus.FAULT
    assert f"DDS domain 901: another mission flies there, started by process {holder.pid}" in record.faults[0]
    assert "--domain-id" in record.faults[0]
    holder.kill()  # however it ends, its claim ends too
    holder.wait()
    holder.stdin.close()
    holder.stdout.close()
    crew = Crew(tmp_path, OSError("enough"))
    fly(crew, Interrupts(), domain_id=901)
    assert crew.started


def test_a_mission_gives_its_domain_back(tmp_path):
    fly(Crew(tmp_path, OSError("enough")), Interrupts(), domain_id=902)
    claim = DomainClaim(902)
    claim.take()
    claim.release()


def test_no_node_joins_a_graph_that_shows_another_mission(tmp_path):
    crew = Crew(tmp_path)
    record = fly(crew, Interrupts(), Graph({"/mu3/thrust": [Publisher("mu3_\x1b[31mcontroller", b"1")]}))
    assert crew.stopped and not crew.in_graph
    assert "somebody else is in DDS domain 900: node mu3_\\x1b[31mcontroller publishes /mu3/thrust" in record.faults[0]


class CompilingCrew(Crew):
    """Its simulator says that it compiles, for so many looks at its log."""

    def __init__(self, folder, looks):
        super().__init__(folder)
        self.looks = looks
        self.shown = 0

    def tail(self, name):
        assert name == "sim"
        self.shown += 1
        said = (f"{COMPILING}: about a minute, this once", "[WARN] of its node, which is made meanwhile")
        return said if self.shown <= self.looks else (*said, f"{COMPILED} in 50 s")


class SlowGraph(Graph):
    """No node is there, ever."""

    def check_graph(self, endpoints):
        return GraphCheck(endpoints, lambda _: [], lambda _: [])

    def check_connections(self, listeners, onlookers):
        return None


class UnansweredGraph(Graph):
    """Every node is there, none answers, ever."""

    def check_graph(self, endpoints):
        there = list(endpoints)
        return GraphCheck(there, *(lambda topic: [e.node for e in there if e.topic == topic] for _ in range(2)))

    def check_connections(self, listeners, onlookers):
        return ConnectionCheck(listeners, dict.fromkeys(listeners, self), lambda _: 0, onlookers)

    def planner_ready(self):
        return True

    def ready(self):
        return True

    def ask(self, _request, _check, _callback):
        pass


@pytest.mark.parametrize(
    ("graph", "fault"),
    [(SlowGraph(), "nodes are missing"), (UnansweredGraph(), "nodes do not find each other: planner has not answered")],
    ids=["its node is not there yet", "its node is there"],
)
def test_a_simulator_that_compiles_is_waited_for_beyond_the_patience_with_nodes(tmp_path, graph, fault):
    crew, text = CompilingCrew(tmp_path, looks=200), io.StringIO()
    parameters = dataclasses.replace(load(SupervisorParameters), probe_s=0.01, graph_timeout_s=0.05)
    plan = FlightPlan((), load_system("zenit_8mu"), (), True, 901, 1.0, parameters)
    record = FlightRecord(system=load_system("zenit_8mu"), seed=1, policy="nominal")
    flight = Flight(plan, crew, Interrupts(), record, Display(text, 2.0), time.monotonic(), lambda _: graph)
    flight.fly()
    assert crew.shown > crew.looks, "it was waited for as long as it said so"
    assert record.faults[0].startswith(fault), "and then no longer than for any node"
    assert text.getvalue().count(f"sim: {COMPILING}") == 1


@pytest.mark.parametrize("graph", [SlowGraph(), UnansweredGraph()], ids=["its node is not there yet", "it is there"])
def test_a_compiler_that_never_ends_is_not_waited_for_for_ever(tmp_path, graph):
    crew = CompilingCrew(tmp_path, looks=10**9)
    parameters = dataclasses.replace(
        load(SupervisorParameters), probe_s=0.01, graph_timeout_s=0.02, compile_timeout_s=0.1
    )
    record = FlightRecord(system=load_system("zenit_8mu"), seed=1, policy="nominal")
    plan = FlightPlan((), load_system("zenit_8mu"), (), True, 902, 1.0, parameters)
    Flight(plan, crew, Interrupts(), record, Display(io.StringIO(), 2.0), time.monotonic(), lambda _: graph).fly()
    assert record.faults[0].startswith("nodes ")
