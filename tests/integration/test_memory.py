"""What does not fit into the memory is refused before it flies, and large batches are flown in smaller chunks."""

import dataclasses
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from tests.systems import zenit
from tethernet_bringup.cli.main import main
from tethernet_core.parameters import ParameterError, load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system
from tethernet_sim import fly as flying
from tethernet_sim import memory
from tethernet_sim.fly import Settings, fly_many
from tethernet_sim.model import build_model
from tethernet_sim.scenario import Scenario
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.state import initial_state
from tethernet_sim.world import World

TAKEN = """
import dataclasses, json, mmap
from pathlib import Path
import numpy as np
from tethernet_core.parameters import load
from tethernet_core.system import load_system
from tethernet_sim import cores, memory
from tethernet_sim.engine import Commands, EdgeListEngine, GridEngine
from tethernet_sim.model import build_model
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.state import initial_state

def size(name):
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(name))
    return 1024 * int(line.split()[1])

cores.use(1)
system = load_system("zenit_8mu", {"net.square.rows": 61, "net.square.columns": 61})
debris = np.array([[0.0, 0.0, -50.0]]), np.array([[0.0, 0.0, 0.0, 1.0]]), np.zeros((1, 3))
shares = {}
for contact in ("knots", "threads"):
    physics = dataclasses.replace(load(PhysicsParameters, {"contact": contact}), time_step_s=1e-6)
    model = build_model(system, physics)
    for engine in (GridEngine(model), EdgeListEngine(model)):
        state = initial_state(model, system, physics, *debris)
        commands = Commands.of_thrust(np.zeros_like(state.mu_pos))
        engine.advance(state, commands, physics.time_step_s)  # loads the kernels
        filler = mmap.mmap(-1, size("VmPeak") - size("VmSize") + 16 * mmap.PAGESIZE)
        before = size("VmPeak")  # what is there now, so that every further byte raises it
        engine.advance(state, commands, physics.time_step_s)
        shares[f"{contact} {type(engine).__name__}"] = (size("VmPeak") - before) / memory.work_bytes(model)
        filler.close()
print(json.dumps(shares))
"""
"""Prints which share of the booked work space the kernels take, by contact and engine."""


@pytest.fixture
def allow(monkeypatch):
    return lambda number: monkeypatch.setattr(memory, "free_bytes", lambda: int(number / memory.SHARE))


@pytest.mark.parametrize("contact", ["knots", "threads"])
def test_the_estimate_covers_the_state_and_little_more(contact):
    system = load_system("envisat_8mu")
    physics = load(PhysicsParameters, {"contact": contact})
    model = build_model(system, physics)
    batch = 3
    state = initial_state(
        model, system, physics, np.zeros((batch, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (batch, 1)), np.zeros((batch, 3))
    )
    held = sum(getattr(state, field.name).nbytes for field in dataclasses.fields(state))
    assert held <= batch * memory.scenario_bytes(model) <= 1.3 * held


def test_the_booked_work_space_covers_what_the_kernels_take():
    # Every array of some size is a mapping of its own, which is given back at once: address space is what is allocated.
    own_mappings = {"MALLOC_MMAP_THRESHOLD_": "16384", "MALLOC_TOP_PAD_": "0", "MALLOC_TRIM_THRESHOLD_": "0"}
    told = subprocess.run(
        [sys.executable, "-c", TAKEN], env=os.environ | own_mappings, capture_output=True, text=True, check=True
    )
    shares = json.loads(told.stdout)
    assert len(shares) == 4
    for what, share in shares.items():  # booked for the worst contacts; a change of the kernels shows here
        least = 0.3 if what.startswith("threads") else 0.1
        assert least < share < 0.6, what


def test_a_net_that_is_too_large_is_refused_with_its_entries(allow):
    allow(100_000)
    system = load_system("envisat_8mu")
    for contact, entries in (("knots", "net: 1681 nodes:"), ("threads", "net: 1681 nodes, physics.contact: threads, ")):
        needed = memory.flight_bytes(build_model(system, load(PhysicsParameters, {"contact": contact})), 1)
        with pytest.raises(ParameterError) as refused:
            fly_many([Scenario(system)], Settings.load(system, physics={"contact": contact}))
        assert f"system envisat_8mu: {entries}" in str(refused.value)
        assert f"{needed} bytes needed; allowed: 100000, half of what is free" in str(refused.value)


def test_a_batch_that_is_too_large_is_refused(allow):
    system, physics = zenit(4), load(PhysicsParameters)
    allow(memory.flight_bytes(build_model(system, physics), 10))
    debris = np.zeros((11, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (11, 1)), np.zeros((11, 3))
    with pytest.raises(ParameterError, match=r"bytes needed for 11 scenarios together; allowed: \d+"):
        World(system, *debris, physics, load(ControlParameters))
    World(system, *(values[:10] for values in debris), physics, load(ControlParameters))


def test_what_does_not_fit_together_is_flown_in_smaller_chunks_with_the_same_bits(allow, monkeypatch):
    settings = Settings.load("zenit_4mu", mission={"give_up_s": 1.0})
    scenarios = [Scenario("zenit_4mu", seed=seed) for seed in range(5)]
    chunks = []
    at_once = fly_many(scenarios, settings, progress=lambda done, _: chunks.append(done))
    assert chunks == [5]
    allow(memory.flight_bytes(build_model(zenit(4), settings.physics), 2))
    chunks.clear()
    assert fly_many(scenarios, settings, progress=lambda done, _: chunks.append(done)) == at_once
    assert chunks == [2, 4, 5]
    assert flying.CHUNK > 5


def test_the_check_of_a_description_states_the_memory(allow, capsys):
    assert main(["systems", "check", "zenit_8mu"]) == 0
    needed = memory.flight_bytes(build_model(zenit(8), load(PhysicsParameters)), 1)
    assert f"a flight takes {needed / 1e6:.1f} MB beside the program" in capsys.readouterr().out
    allow(1000)
    assert main(["systems", "check", "zenit_8mu"]) == 1
    said = capsys.readouterr().out
    assert "zenit_8mu: parameters: system zenit_8mu: net: 529 nodes, physics.contact: threads, 2577 contacts" in said


def test_the_limit_of_this_process_counts(monkeypatch):
    assert memory.free_bytes() > 0
    monkeypatch.setattr(memory.resource, "getrlimit", lambda _: (1, 1))
    assert memory.free_bytes() == 0
