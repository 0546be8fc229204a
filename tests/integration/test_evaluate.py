"""Scenarios and records of what is flown."""

from tests.physics import diverging
from tests.systems import zenit
from tethernet_core.parameters import load
from tethernet_core.settings import MissionParameters
from tethernet_learning.assumed_numbers import RANDOM
from tethernet_learning.campaigns.cases import aim
from tethernet_learning.campaigns.chunks import fly_cases
from tethernet_learning.campaigns.records import records
from tethernet_learning.campaigns.variations import random_positions
from tethernet_learning.evaluation.policy_scores import evaluate
from tethernet_learning.flight_settings import flights_of
from tethernet_planner import policies
from tethernet_sim.fly import Settings

RULES = load(MissionParameters)


def test_one_seed_gives_one_list_within_the_papers_bounds():
    some, more = random_positions(zenit(4), 5, 7, RULES), random_positions(zenit(4), 50, 7, RULES)
    assert more[:5] == some
    assert random_positions(zenit(4), 5, 8, RULES) != some
    for scenario in (case.scenario for case in more):
        x, y, z = scenario.debris_position
        assert max(abs(x), abs(y)) <= 9.0
        assert -60.0 <= z <= -40.0
        assert round(x, 1) == x
    assert len({case.scenario.seed for case in more}) == 50


def test_a_mission_in_error_is_counted_not_dropped(monkeypatch):
    cases = random_positions(zenit(4), 2, 1, RULES)
    settings = diverging(monkeypatch)
    result = records(cases, fly_cases(cases, {zenit(4): settings}), cases[0].scenario.system)
    assert result["errors"] == 2
    assert all("diverged" in record["outcome"]["error"] for record in result["scenarios"])
    assert result["success_rate"] == 0.0
    assert result["fuel_per_mu_kg"] is None
    assert len(result["scenarios"]) == 2


def test_a_policy_that_fails_at_one_scenario_costs_that_one_only(monkeypatch):
    cases = random_positions(zenit(8), 2, 1, RULES)
    refused = cases[0].scenario.debris_position

    def picky(system, position):
        if position == refused:
            raise RuntimeError("not there")
        return policies.nominal_aiming_points(system, position)

    monkeypatch.setitem(policies._FACTORIES, "picky", lambda: picky)
    aimed = aim(cases, "picky")
    settings = Settings.load(mission={"trigger_distance_m": 50.0})
    result = records(aimed, fly_cases(aimed, {zenit(8): settings}), aimed[0].scenario.system)
    assert result["errors"] == 1
    first, second = (record["outcome"] for record in result["scenarios"])
    assert "not there" in first["error"]
    assert not first["captured"]
    assert second["error"] == ""


def test_all_policies_fly_with_the_same_random_draw_of_the_assumed_numbers():
    system = zenit(4)
    flights = flights_of([], [system])
    chosen = {system: [policies.NOMINAL, policies.RL]}
    [described] = evaluate(chosen, 3, 5, flights)
    [drawn] = evaluate(chosen, 3, 5, flights, assumed=RANDOM)
    systems = {name: {case.scenario.system.digest for case in cases} for name, cases in drawn.cases.items()}
    assert systems[policies.NOMINAL] == systems[policies.RL], "one draw for these three, whoever aims"
    assert len(systems[policies.RL]) == 1
    assert systems[policies.RL] != {system.digest}
    for name in (policies.NOMINAL, policies.RL):
        aims = [[case.scenario.aiming_offsets for case in e.cases[name]] for e in (described, drawn)]
        assert aims[0] == aims[1], "aimed for the system as it is described"
        fuel = [[sum(outcome.fuel_kg) for outcome in e.outcomes[name]] for e in (described, drawn)]
        assert all(a != b for a, b in zip(*fuel, strict=True))
        assert not any(outcome.error for outcome in drawn.outcomes[name])
    assert drawn.compared()[policies.RL].pairs == 3
