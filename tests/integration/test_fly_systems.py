"""Whole missions in process of systems that the paper does not have."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tethernet_control import law
from tethernet_control.controller import MuController
from tethernet_core.mission import Mission, arm, launch
from tethernet_core.system import load_system
from tethernet_planner.closing_situation import closing_situation, off_course
from tethernet_planner.mission_rules import advance
from tethernet_planner.plan_ahead import PlanAhead
from tethernet_sim.fly import Settings, fly, fly_many
from tethernet_sim.scenario import Scenario
from tethernet_sim.sensors import OdometryNoise
from tethernet_sim.state import DEBRIS

OWN = """
name: own
based_on: zenit_8mu
net:
  square: {rows: 19, columns: 19, mesh_m: 1.25}
units:
  - {node: {row: first, column: first}, thread_length_m: 1.0}
  - {node: {row: first, column: last}, thread_length_m: 1.0, mass_kg: 3.0}
  - {node: {row: last, column: first}, thread_length_m: 1.0, thrust_limit_n: 6.0}
  - {node: {row: last, column: last}, thread_length_m: 1.0, specific_impulse_s: 120.0}
  - {node: {row: first, column: middle}, thread_length_m: 0.7}
  - {node: {row: last, column: middle}, thread_length_m: 0.7}
closing:
  docking: {ring: null}
capture: {required_locked_pairs: null}
aiming: null
"""


def unlike():
    """The paper's net with units of different mass, thrust and specific impulse."""
    units = {"units[0].mass_kg": 4.0, "units[2].thrust_limit_n": 3.0, "units[5].specific_impulse_s": 120.0}
    return load_system("zenit_8mu", units)


def test_six_units_capture_with_their_six_sided_net():
    for outcome in fly_many([Scenario("hexagonal_6mu", seed=seed) for seed in range(2)]):
        assert outcome.captured, outcome.verdict
        assert outcome.locked_pairs >= 4
        assert (outcome.mus, outcome.system, len(outcome.fuel_kg)) == (6, "hexagonal_6mu", 6)


def test_an_own_description_flies_by_its_path(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text(OWN)
    scenario = Scenario(path)
    assert (scenario.mus, scenario.system.net.node_count) == (6, 361)
    outcome = fly(scenario)
    assert outcome.captured, outcome.verdict
    assert outcome.system == "own"
    # The same twice the specific impulse takes half of the propellant.
    assert outcome.fuel_kg[3] < 0.65 * outcome.fuel_kg[0]


def test_unlike_units_are_flown_by_laws_of_their_own_with_the_same_bits_as_their_controllers():
    system = unlike()
    settings = Settings.load(system)
    scenario = Scenario(system, seed=5, debris_position=(3.0, -2.0, -45.0))
    noise = OdometryNoise(scenario.seed, 8, settings.control)
    controllers = [MuController(mu, settings.control, unit) for mu, unit in enumerate(system.units, start=1)]
    mission = launch(arm(Mission(8), scenario.debris_position, "nominal"), 0)
    ahead = PlanAhead(system, settings.mission)
    for controller, point in zip(controllers, scenario.aiming_points(), strict=True):
        controller.take_mission(mission)
        controller.aim(point, "nominal")

    def observe(stamp_ns, world, _):
        nonlocal mission
        drawn = noise.draw(1)[0]
        positions, velocities = world.state.mu_pos[0] + drawn[:, 0], world.state.mu_vel[0] + drawn[:, 1]
        for controller, position, velocity in zip(controllers, positions, velocities, strict=True):
            controller.on_odometry(stamp_ns, position.tolist(), velocity.tolist())

        def look():
            lost = off_course(positions, scenario.aiming_points(), system, settings.mission)
            return closing_situation(positions, velocities, *world.body_motion(0, DEBRIS), lost)

        mission = advance(
            mission, system, stamp_ns, world.net_center(0), world.debris_position(0), settings.mission,
            settings.control, world.state.locked[0], look, ahead,
        )  # fmt: skip
        for controller in controllers:
            controller.take_mission(mission)

    outcome = fly(scenario, settings, observe)
    assert outcome.captured, outcome.verdict
    assert tuple(c.statistics.fuel_kg for c in controllers) == outcome.fuel_kg
    alike = fly(dataclasses.replace(scenario, system="zenit_8mu"))
    assert alike.fuel_kg != outcome.fuel_kg


def test_equal_units_are_flown_alike_however_they_are_described():
    """Laws per unit must not cost the uniform case a bit."""
    written_out = load_system("zenit_8mu", {f"units[{i}].mass_kg": 2.5 for i in range(8)})
    assert written_out.digest == load_system("zenit_8mu").digest
    rules = {"capture_duration_s": 1.0}
    one, other = (fly(Scenario(s), Settings.load(mission=rules)) for s in ("zenit_8mu", written_out))
    assert one == other


def test_where_nothing_closes_the_net_units_fly_on_to_their_points_and_beyond():
    system = load_system("zenit_8mu", {"closing": "none", "capture.required_locked_pairs": None})
    places = []

    def observe(stamp_ns, world, _):
        places.append(world.state.mu_pos[0].mean(axis=0))

    outcome = fly(Scenario(system), observer=observe)
    assert outcome.locked_pairs == 0
    assert outcome.trigger_time_s is not None
    assert places[-1][2] < -53.0, "beyond the debris"
    assert "the CQI alone decides" in outcome.verdict
    assert sum(outcome.fuel_kg) > sum(outcome.fuel_at_trigger_kg)


def test_systems_fly_side_by_side_as_they_do_alone():
    rules = Settings.load(mission={"give_up_s": 2.0})
    mixed = [Scenario(name, seed=seed) for seed, name in enumerate(("zenit_4mu", "hexagonal_6mu", "zenit_4mu"))]
    together = fly_many(mixed, rules)
    assert [outcome.system for outcome in together] == ["zenit_4mu", "hexagonal_6mu", "zenit_4mu"]
    assert together == [fly(scenario, rules) for scenario in mixed]


def test_a_scenario_takes_what_it_lacks_from_its_system():
    passive = Scenario("passive_5m")
    assert passive.debris_position == (0.0, 0.0, -7.0)
    assert passive.mus == 0
    assert passive.aiming_points().shape == (0, 3)
    assert passive.debris_attitude == Scenario().debris_attitude
    with pytest.raises(ValueError, match="no system 'nothing'"):
        Scenario("nothing")
    with pytest.raises(ValueError, match="mu from 1 to 0"):
        from tethernet_sim.scenario import Failure

        Scenario("passive_5m", failure=Failure(1, "no_thrust", 1.0))


def test_fuel_is_counted_with_each_units_own_specific_impulse():
    assert np.isclose(law.fuel_used((1.0, 2.0, 2.0), 2.0, 60.0, 9.81), 3.0 * 2.0 / (9.81 * 60.0))
