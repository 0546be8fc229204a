"""The energy of whole missions: nothing comes from nowhere, and what goes, goes where it is booked."""

from __future__ import annotations

import pytest

from tests.physics import coast, flying_net
from tethernet_core.system import load_system
from tethernet_sim.energy import Auditor, audit_mission
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Scenario


@pytest.mark.parametrize(
    ("mus", "step_s", "net_contact", "share", "booked"),
    [
        (8, 1e-4, "none", 0.02, 1e-7),
        (4, 1e-4, "none", 0.02, 1e-7),
        (4, 1e-4, "threads", 0.02, 1e-7),
        # In this mission the booking finds a point of a thread elsewhere than the flight did, by 0.9 mJ of 310 J.
        (4, 5e-5, "none", 0.01, 1e-5),
    ],
)
def test_the_energy_of_a_whole_mission_balances(mus, step_s, net_contact, share, booked):
    name = f"zenit_{mus}mu"
    physics = {"time_step_s": step_s, "net_contact": net_contact}
    outcome, balance = audit_mission(Scenario(name), Settings.load(name, physics=physics))
    assert outcome.captured, "to the end of the capture"
    assert balance.work == pytest.approx(balance.gained, abs=booked * balance.all_in), "the kernels follow the laws"
    assert abs(balance.residual) < share * balance.all_in
    assert min(balance.lost.values()) >= 0.0
    busy = {"threads", "tether", "contact", "friction", "joints"} | ({"winches slipping"} if mus == 4 else set())
    busy |= {"net on net"} if net_contact == "threads" else set()
    assert {name for name, energy in balance.lost.items() if energy > 0.01} == busy
    assert balance.put_in["thrusters"] > 10.0
    assert (balance.put_in["winches"] > 10.0) == (mus == 4)


def test_docking_puts_in_no_more_than_its_motors_can():
    _, balance = audit_mission(Scenario("zenit_8mu"))
    assert 0.0 < balance.put_in["docking motors"] <= 8 * 0.5 * load_system("zenit_8mu").closing.pull_n


@pytest.mark.parametrize("contact", ["knots", "threads"])
@pytest.mark.parametrize("mus", [4, 8])
def test_every_force_is_booked(mus, contact):
    """A shaken net thrown at a tumbling debris, closing, the chaser towing: the work of all laws is the kinetic energy,
    to rounding.
    """
    world = flying_net(mus, closing=True, contact=contact)
    world.chaser_force[0] = (3.0, -1.0, 20.0)
    auditor = Auditor()
    auditor.attach(world)
    for _ in coast(world, 60):
        pass
    balance = auditor.balance()
    assert balance.work == pytest.approx(balance.gained, rel=1e-9)
    assert balance.lost["contact"] > 0.0
    assert balance.lost["friction"] > 0.0
    assert balance.put_in["thrusters"] != 0.0, "the chaser's"
