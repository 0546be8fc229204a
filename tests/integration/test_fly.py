"""Whole missions in process."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.physics import diverging
from tethernet_control import law
from tethernet_control.controller import MuController
from tethernet_core.mission import Mission, arm, launch
from tethernet_core.system import load_system
from tethernet_planner import closing
from tethernet_planner.closing_situation import closing_situation, off_course
from tethernet_planner.docking_groups import most_parts
from tethernet_planner.meeting_places import MeetingPlaces
from tethernet_planner.mission_rules import advance
from tethernet_planner.plan_ahead import PlanAhead
from tethernet_sim.fly import Settings, fly, fly_many
from tethernet_sim.scenario import Scenario
from tethernet_sim.sensors import OdometryNoise
from tethernet_sim.settings import ScenarioParameters
from tethernet_sim.state import DEBRIS

OFF_CENTRE = (8.9, 6.2, -44.0)
"""The example scenario of the paper's figure 5 [m]."""


@pytest.fixture(scope="module")
def outcomes():
    """Nominal missions at the default place and at the paper's example, both designs."""
    systems, places = ("zenit_8mu", "zenit_4mu"), ((0.0, 0.0, -50.0), OFF_CENTRE)
    scenarios = [Scenario(system, debris_position=at) for system in systems for at in places]
    return dict(zip(((8, 0), (8, 1), (4, 0), (4, 1)), fly_many(scenarios), strict=True))


@pytest.mark.parametrize("place", [0, 1])
def test_eight_mus_capture(outcomes, place):
    outcome = outcomes[8, place]
    assert outcome.captured, outcome.verdict
    assert outcome.cqi < 2.5
    assert outcome.locked_pairs >= 6


@pytest.mark.parametrize("place", [0, 1])
def test_four_mus_capture(outcomes, place):
    outcome = outcomes[4, place]
    assert outcome.captured, outcome.verdict
    assert outcome.cqi < 2.5
    assert outcome.locked_pairs >= 8
    assert outcome.fuel_kg == outcome.fuel_at_trigger_kg, "with 4 MUs the thrusters are off when closing starts"


def test_what_the_net_weighs_stands_in_both_indices(outcomes):
    """The MUs, 95 % of the net's mass, stay behind the debris; the knots lie round it."""
    for outcome in outcomes.values():
        assert outcome.cqi < outcome.cqi_all < outcome.cqi + 0.8 * 5.0 / 1.95


def test_deployment_is_the_papers(outcomes):
    # The paper's mean deployment takes 25.2 s; the trigger comes shortly before the aiming points are reached.
    for outcome in outcomes.values():
        assert 23.5 < outcome.trigger_time_s < 26.0
        assert outcome.end_time_s == pytest.approx(outcome.trigger_time_s + 15.0)
    assert 500.0 < outcomes[8, 0].mouth_area_m2 < 576.0
    assert 500.0 < outcomes[4, 0].mouth_area_m2 < 576.0


@pytest.mark.parametrize("mus", [4, 8])
def test_a_batch_gives_the_same_bits_as_single_flights(mus):
    system = f"zenit_{mus}mu"
    scenarios = [Scenario(system, seed=seed, debris_position=(seed - 2.0, 1.0, -42.0 - seed)) for seed in range(4)]
    assert fly_many(scenarios) == [fly(scenario) for scenario in scenarios]


def test_one_seed_gives_identical_runs_and_another_does_not():
    first, again, other = (fly(Scenario(seed=seed)) for seed in (11, 11, 12))
    assert first == again
    assert first.fuel_kg != other.fuel_kg


def test_the_controllers_class_gives_the_same_bits_as_the_compiled_batch():
    """Eight MuController objects, fed by hand with what the flight measures, must command what the flight commanded."""
    settings = Settings.load()
    scenario = Scenario(seed=5, debris_position=(3.0, -2.0, -45.0))
    noise = OdometryNoise(scenario.seed, 8, settings.control)
    controllers = [MuController(mu, settings.control, unit) for mu, unit in enumerate(scenario.system.units, start=1)]
    mission = launch(arm(Mission(8), scenario.debris_position, "nominal"), 0)
    ahead = PlanAhead(scenario.system, settings.mission)
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
            lost = off_course(positions, scenario.aiming_points(), scenario.system, settings.mission)
            return closing_situation(positions, velocities, *world.body_motion(0, DEBRIS), lost)

        mission = advance(
            mission, scenario.system, stamp_ns, world.net_center(0), world.debris_position(0), settings.mission,
            settings.control, world.state.locked[0], look, ahead,
        )  # fmt: skip
        for controller in controllers:
            controller.take_mission(mission)

    outcome = fly(scenario, settings, observe)
    assert tuple(c.statistics.fuel_kg for c in controllers) == outcome.fuel_kg
    assert tuple(c.statistics.fuel_at_trigger_kg for c in controllers) == outcome.fuel_at_trigger_kg
    assert max(c.statistics.max_tracking_error_m for c in controllers) == outcome.max_tracking_error_m


def test_the_trigger_leaves_nothing_to_plan(monkeypatch):
    """However the debris tumbles: at most one part of a plan at any tick, none at the trigger."""
    done: dict[int, int] = {}
    now = 0
    best = MeetingPlaces.best

    def counted(places, group):
        done[now] = done.get(now, 0) + 1
        return best(places, group)

    def observe(stamp_ns, _world, _flying):
        nonlocal now
        now = stamp_ns

    monkeypatch.setattr(MeetingPlaces, "best", counted)
    outcome = fly(Scenario(debris_rate=(0.087, 0.0, 0.0)), observer=observe)
    trigger_ns = round(outcome.trigger_time_s * 1e9) - Settings.load().control.period_ns
    assert sum(done.values()) >= most_parts(Scenario().system)
    assert max(done.values()) == 1
    assert 0 < trigger_ns - min(done) <= 1_100_000_000
    assert max(done) < trigger_ns


def test_the_closing_is_planned_from_odometry(monkeypatch):
    """With much noise the planner sees it, with none it sees the MUs as they are."""
    seen = []
    planning = closing.planning
    monkeypatch.setattr(
        closing,
        "planning",
        lambda situation, *rest: seen.append(situation) or planning(situation, *rest),
    )
    for sigma in (0.0, 0.3):
        fly(Scenario(), Settings.load(control={"position_sigma_m": sigma}, mission={"capture_duration_s": 1.0}))
    exact, noisy = (situation.mu_positions for situation in seen)
    assert 0.1 < np.abs(noisy - exact).mean() < 0.6


def test_fuel_against_its_closed_form():
    """No gains, no fuel. A huge proportional gain alone turns any error, and noise sees to it that there is one on
    every axis, into the limit on all three axes all the time: then the closed form holds exactly.
    """
    silent = fly(Scenario(), Settings.paper(control={"kp": 0.0, "ki": 0.0, "kd": 0.0}, mission={"give_up_s": 1.0}))
    assert silent.fuel_kg == (0.0,) * 8
    full = fly(
        Scenario(load_system("zenit_8mu", {"unit.thrust_limit_n": 0.01})),
        Settings.paper(control={"kp": 1e4, "ki": 0.0, "kd": 0.0}, mission={"give_up_s": 2.0}),
    )
    closed_form = np.sqrt(3.0) * 0.01 * full.end_time_s / (9.81 * 60.0)
    # Start points are measured ones: the very first error is exactly zero, one control period goes without thrust.
    assert np.allclose(full.fuel_kg, closed_form * (1.0 - 0.05 / full.end_time_s), rtol=1e-9)


def test_a_mission_that_never_triggers_is_missed():
    outcome = fly(Scenario(), Settings.load(mission={"give_up_s": 5.0}))
    assert not outcome.captured
    assert outcome.verdict.startswith("missed")
    assert outcome.trigger_time_s is None
    assert outcome.mouth_area_m2 is None
    assert outcome.end_time_s == 5.0


def test_a_diverging_simulation_says_so(monkeypatch):
    outcome = fly(Scenario(), diverging(monkeypatch))
    assert not outcome.captured
    assert "diverged" in outcome.error
    assert outcome.verdict.startswith("error")


def test_aiming_offsets_and_tumbling_change_the_flight():
    plain = fly(Scenario())
    shifted = fly(Scenario(aiming_offsets=((1.0, 0.0),) * 8))
    tumbling = fly(Scenario(debris_rate=(0.0, 0.0, 0.05)))
    assert len({plain.fuel_kg, shifted.fuel_kg}) == 2
    assert tumbling.trigger_time_s == plain.trigger_time_s  # nothing has touched the debris before
    assert tumbling.cqi != plain.cqi


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"system": "zenit_5mu"}, "no system 'zenit_5mu'.*zenit_4mu"),
        ({"debris_position": (0.0, 0.0)}, "debris_position"),
        ({"debris_position": (float("nan"), 0.0, -50.0)}, "debris_position"),
        ({"debris_attitude": (0.0, 0.0, 0.0, 0.5)}, "unit quaternion"),
        ({"seed": -1}, "seed"),
        ({"aiming_offsets": ((0.0, 0.0),) * 3}, "aiming_offsets"),
    ],
)
def test_bad_scenarios_are_refused(changes, word):
    with pytest.raises(ValueError, match=word):
        Scenario(**changes)


def test_the_default_scenario_is_the_parameter_files():
    assert {f.name for f in dataclasses.fields(ScenarioParameters)} >= {"system", "debris_position", "seed"}
    assert Scenario().system is load_system("zenit_8mu")
    assert Scenario().mus == 8
    assert Scenario().debris_position == (0.0, 0.0, -50.0)


def test_noise_does_not_depend_on_the_pieces_it_is_drawn_in():
    control = Settings.load().control
    whole = OdometryNoise(3, 8, control).draw(10)
    pieces = OdometryNoise(3, 8, control)
    assert np.array_equal(whole, np.concatenate([pieces.draw(n) for n in (1, 4, 5)]))
    many = OdometryNoise(4, 8, control).draw(4000)
    assert np.allclose(many.std(axis=(0, 1, 3)), 0.1 / 3.0, rtol=0.02)
    assert np.allclose(many.mean(axis=(0, 1, 3)), 0.0, atol=1e-3)


@pytest.mark.parametrize("mus", [4, 8])
def test_our_control_needs_less_than_half_of_the_baselines_fuel(mus):
    """Mean fuel per MU over the whole mission, under the paper's noise: against the paper's control as printed, and
    against the paper's own figures.
    """
    scenarios = [Scenario(f"zenit_{mus}mu", seed=seed) for seed in range(4)]
    ours, baseline = fly_many(scenarios), fly_many(scenarios, Settings.paper(scenarios[0].system))
    assert all(outcome.captured for outcome in ours), [outcome.verdict for outcome in ours]
    mean = {name: np.mean([o.fuel_kg for o in flown]) for name, flown in (("ours", ours), ("baseline", baseline))}
    assert mean["ours"] < 0.5 * mean["baseline"]
    assert mean["ours"] < {4: 0.028, 8: 0.021}[mus]


def test_a_narrow_mouth_comes_late_and_saves_fuel_if_the_reference_follows_through():
    def narrow(width):
        offsets = tuple(((width - 1.0) * np.array(place)).tolist() for place in load_system("zenit_4mu").aiming.offsets)
        return [Scenario("zenit_4mu", seed=seed, aiming_offsets=offsets) for seed in range(2)]

    nominal, drawn_in = fly_many(narrow(1.0)), fly_many(narrow(0.75))
    held = fly_many(narrow(0.75), Settings.load(control={"follow_through_m": 0.0}))
    assert all(outcome.captured for outcome in nominal + drawn_in)
    assert min(o.trigger_time_s for o in drawn_in) > 26.0 > max(o.trigger_time_s for o in nominal)
    fuel = [np.mean([o.fuel_kg for o in flown]) for flown in (drawn_in, nominal, held)]
    assert fuel[0] < 0.89 * fuel[1]
    assert fuel[2] > 1.3 * fuel[1]


@pytest.mark.parametrize(
    "offsets",
    [
        # Neighbours farther apart than the rim between them is long; opposite sides farther than a row.
        ((-2.3, -4.4), (1.5, 0.4), (-3.6, 3.3), (4.5, -3.4), (1.2, 2.1), (0.8, -0.7), (2.3, -1.4), (-4.1, -2.4)),
        ((-2.8, -1.1), (0.8, 1.3), (-2.8, 2.3), (2.5, -1.7), (1.8, -4.3), (4.0, -2.6), (-0.8, -0.8), (-3.4, 4.3)),
    ],
)
def test_a_mouth_wider_than_the_net_is_closed_by_all(offsets):
    outcomes = fly_many([Scenario("zenit_8mu", seed=seed, aiming_offsets=offsets) for seed in range(2)])
    assert [outcome.captured for outcome in outcomes] == [True] * 2


def test_stops_at_the_trigger_with_the_net_as_a_whole_flight_has_it():
    scenarios = [Scenario("zenit_4mu", seed=seed) for seed in (1, 2)]
    seen = {}

    def look(number, world, index):
        seen.setdefault(number, []).append(world.knots_as_published(index))

    short = fly_many(scenarios, at_trigger=look, stop_at_trigger=True)
    whole = fly_many(scenarios, at_trigger=look)
    for number, (before, after) in enumerate(zip(short, whole, strict=True)):
        assert before.stopped_at_trigger
        assert not before.captured
        assert before.end_time_s == before.trigger_time_s == after.trigger_time_s
        assert before.fuel_kg == after.fuel_at_trigger_kg
        assert before.mouth_area_m2 == after.mouth_area_m2
        assert (seen[number][0] == seen[number][1]).all()


def test_the_propellant_is_a_budget_in_process_too():
    """The same as in the controller: thrust ends within one period of the budget's end."""
    settings = Settings.load(mission={"give_up_s": 6.0})
    little = load_system("zenit_4mu", {"unit.propellant_kg": 0.004})
    free = fly(Scenario("zenit_4mu"), Settings.load(mission={"give_up_s": 6.0}))
    bounded = fly(Scenario(little), settings)
    tick = law.fuel_used((5.1, 5.1, 5.1), 0.05, 60.0, 9.81)
    assert min(free.fuel_kg) > 0.004 + tick
    assert all(0.004 <= fuel <= 0.004 + tick for fuel in bounded.fuel_kg)
