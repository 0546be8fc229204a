"""What does not fit into the memory is refused before it flies, and large batches are flown in smaller chunks."""

import dataclasses

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
