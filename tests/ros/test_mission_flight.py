"""Missions flown over DDS by the command, to the verdict."""

import math

import numpy as np
import pytest
import yaml

from tests.ros.mission_command import MissionCommand, read_bag
from tests.ros.test_mission_faults import LOCKSTEP, short
from tests.unit.test_outcome import ISSUE_KEYS
from tethernet_bringup.analysis.mission_data import load
from tethernet_bringup.analysis.punctuality import closing_start, late_decisions
from tethernet_bringup.bags.reader import open_bag
from tethernet_core.system import load_system
from tethernet_ros.conversions import nanoseconds
from tethernet_sim import towing
from tethernet_sim.fly import Settings, fly

pytestmark = pytest.mark.ros


def test_every_node_knows_the_parameters_that_the_command_gives_it():
    from tethernet_bringup.mission import parameters as mission_parameters
    from tethernet_bringup.recorder import recorder_node
    from tethernet_control import controller_node
    from tethernet_planner import assessor_node, planner_node
    from tethernet_sim.ros import sim_node

    classes = mission_parameters.node_classes(load_system("zenit_8mu"))
    assert set(classes["sim"]) == set(sim_node.SimNode.PARAMETERS)
    assert set(classes["planner"]) == set(planner_node.PlannerNode.PARAMETERS)
    assert set(classes["assessor"]) == set(assessor_node.AssessorNode.PARAMETERS)
    own = set(controller_node.ControllerNode.PARAMETERS) - {controller_node.ControllerIdentity}
    assert set(classes["mu1_controller"]) == own
    assert classes["recorder"] == (recorder_node.RecorderParameters,)


@pytest.mark.parametrize("mus", [4, 8])
def test_a_missed_mission_is_flown_and_told(tmp_path, domain_id, mus):
    flags = ("--mus", str(mus), "--seed", "7", *LOCKSTEP, *short(tmp_path, 2.0))
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        assert mission.finish() == 3, mission.text
        outcome = mission.outcome
        assert set(outcome) >= ISSUE_KEYS
        assert (outcome["captured"], outcome["mus"], outcome["seed"], outcome["policy"]) == (False, mus, 7, "rl")
        assert (outcome["trigger_time_s"], outcome["end_time_s"], outcome["phase"]) == (None, 2.0, "MISSED")
        assert len(outcome["fuel_kg"]) == mus
        assert all(fuel > 0.0 for fuel in outcome["fuel_kg"])
        assert outcome["deadline_misses"] == 0
        assert outcome["warnings"] == outcome["faults"] == []
        counts = outcome["messages"]
        ticks = counts["/clock"]
        assert ticks >= 41
        recorded = list(open_bag(mission.run).messages())
        assert min(min(message.log_time, message.publish_time) for message in recorded) == 1_000_000_000, "none is 0"
        for mu in range(1, mus + 1):
            assert counts[f"/mu{mu}/odom"] == counts[f"/mu{mu}/thrust"] == ticks
        assert counts["/planner/heartbeat"] == counts["/net/state"] == ticks
        assert {topic: len(found) for topic, found in read_bag(mission.run).items()} == {
            topic: count for topic, count in counts.items() if count
        }
        used = yaml.safe_load((mission.run / "parameters.yaml").read_text())
        assert used["sim"]["ros__parameters"]["seed"] == 7
        assert used["planner"]["ros__parameters"]["give_up_s"] == 2.0
        for node in ("sim", "planner", "assessor", "recorder", f"mu{mus}_controller"):
            assert (mission.run / "logs" / f"{node}.log").exists()


def test_the_default_mission_captures_exactly_as_in_one_process(tmp_path, domain_id):
    with MissionCommand(tmp_path, domain_id, *LOCKSTEP) as mission:
        assert mission.finish() == 0, mission.text
        assert "CAPTURED" in mission.text
        assert mission.outcome["policy"] == mission.outcome["aiming_sources"][0] == "rl"
        assert_same(mission.outcome, in_process())


@pytest.mark.parametrize(
    ("system", "flags", "net_contact"), [("zenit_8mu", ("--tow", "20"), "none"), ("zenit_4mu", (), "threads")]
)
def test_a_hold_test_is_flown_exactly_as_in_one_process(tmp_path, domain_id, system, flags, net_contact):
    hold_s = 6.0
    parameters = tmp_path / "net_contact.yaml"
    parameters.write_text(f"sim:\n  ros__parameters:\n    net_contact: {net_contact}\n")
    flags = ("--system", system, "--hold", str(hold_s), *flags, "--params", str(parameters), *LOCKSTEP)
    tow_n = 20.0 if "--tow" in flags else 0.0
    settings = Settings.load(system, mission={"hold_s": hold_s, "tow_n": tow_n}, physics={"net_contact": net_contact})
    with MissionCommand(tmp_path, domain_id, *flags) as mission:
        expected = in_process(settings=settings, system=system)
        assert mission.finish() == 0, mission.text
        outcome = mission.outcome
        assert_same(outcome, expected)
        assert (outcome["held"], outcome["hold_s"], outcome["tow_n"]) == (True, hold_s, tow_n)
        assert outcome["hold_end_time_s"] == pytest.approx(outcome["end_time_s"] + 0.05 + hold_s)
        assert outcome["warnings"] == outcome["faults"] == []
        for line in (
            "hold test: 6 s, the chaser",
            "captured: CQI",
            "end of the hold test",
            "HELD   held: the closed net",
        ):
            assert line in mission.text
    data = load(open_bag(mission.run))
    assert [change.phase.name for change in data.phases][-3:] == ["CLOSING", "HOLDING", "COMPLETE"]
    assert len(data.net_stamps) == outcome["messages"]["/clock"] == round(outcome["hold_end_time_s"] / 0.05) + 1
    _, chaser = data.chaser.sorted()
    _, debris = data.debris.sorted()
    draws_off = np.diff(np.linalg.norm(chaser[:, :3] - debris[:, :3], axis=1)) / 0.05
    ticks = round(hold_s / 0.05)
    if tow_n:
        assert draws_off[-1] == pytest.approx(towing.TAKE_UP_M_S, rel=0.05), "slack is taken up slowly"
    else:
        assert draws_off[-1] == pytest.approx(draws_off[-ticks], abs=0.01), "it coasts"
    loads, forces = data.load_share.values, data.contact.values
    assert loads.max() == outcome["max_load_share"]
    assert forces.max() == outcome["max_contact_force_n"]


@pytest.mark.parametrize("system", ["hexagonal_6mu", "passive_5m"])
def test_other_systems_fly_exactly_as_in_one_process(tmp_path, domain_id, system):
    flags = ("--system", system, *LOCKSTEP)
    with MissionCommand(tmp_path, domain_id, *flags) as mission:
        outcome = in_process("nominal", system=system)
        assert mission.finish() == (0 if outcome.captured else 3), mission.text
        assert_same(mission.outcome, outcome)
        described = load_system(system)
        assert (mission.outcome["system"], mission.outcome["system_digest"]) == (system, described.digest)
        assert load_system(mission.run / "system.yaml") == described
    bag = read_bag(mission.run)
    odometry = {topic for topic in bag if topic.startswith("/mu")}
    assert len(odometry) == 3 * described.unit_count
    assert {len(net.knot_positions) for net in bag["/net/state"]} == {3 * described.net.node_count}
    lines = {marker.ns: marker for marker in bag["/net/markers"][-1].markers}
    assert len(lines["net"].points) == 2 * described.net.thread_count
    _, faces = described.debris.shape.triangles()
    assert len(lines["debris"].points) == 3 * len(faces)
    assert load(open_bag(mission.run)).system == described


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mus", "debris", "tumble"),
    [
        (4, (0.0, 0.0, -50.0), (0.0, 0.0, 0.0)),
        (4, (8.9, 6.2, -44.0), (0.0, 0.0, 0.0)),
        (8, (8.9, 6.2, -44.0), (0.0, 0.0, 0.0)),
        (8, (-3.0, 5.0, -47.0), (0.05, -0.03, 0.02)),
    ],
)
def test_other_missions_fly_exactly_as_in_one_process(tmp_path, domain_id, mus, debris, tumble):
    flags = ("--mus", str(mus), "--debris", *map(str, debris), "--tumble", *map(str, tumble), *LOCKSTEP)
    with MissionCommand(tmp_path, domain_id, *flags) as mission:
        assert mission.finish() == 0, mission.text
        assert_same(mission.outcome, in_process(system=f"zenit_{mus}mu", debris_position=debris, debris_rate=tumble))
        assert mission.outcome["captured"] is True
        assert mission.outcome["cqi"] < 2.5
        assert mission.outcome["locked_pairs"] >= {4: 8, 8: 6}[mus]


def test_in_real_time_all_controllers_act_on_every_decision_at_the_next_tick(tmp_path, domain_id):
    """Round a debris that tumbles: closing begins exactly one tick after the trigger; docked MUs are off and docking
    groups fly to new meeting places when they should.

    A machine that is too busy may make any process late once. It does not do so at the very tick of the trigger in
    three flights, and where the simulator had all commands in time about the trigger it is no excuse at all.
    """
    parameters = tmp_path / "parameters.yaml"
    parameters.write_text("/**:\n  ros__parameters:\n    capture_duration_s: 11.0\n")
    flags = ("--pace", "realtime", "--tumble", "0.087", "0.0", "0.0", "--params", str(parameters))
    found = []
    for attempt in range(3):
        with MissionCommand(tmp_path / f"runs{attempt}", domain_id, *flags) as mission:
            assert mission.finish() in (0, 3), mission.text
        data = load(open_bag(mission.run))
        start = closing_start(data)
        count, late = late_decisions(data)
        assert any(any(nanoseconds(time) for time in state.docked_times) for state in data.states), "nobody docked"
        assert count >= 2 * 8, "the trigger and the docking at least, of each controller"
        if start.ticks == dict.fromkeys(range(1, 9), 1) and not late:
            return
        busy = late_commands(mission.run, data, start.trigger_s)
        found.append(f"closing after {start.ticks} ticks, late {late}, {busy} late commands about the trigger")
        if not busy:
            break
    pytest.fail("; ".join(found))


def late_commands(run, data, trigger_s):
    """Commands that the simulator did not have in time, from a second before to a second after the trigger."""
    totals = {
        float(data.seconds(nanoseconds(message.header.stamp))): sum(message.late_commands)
        for message in read_bag(run)["/sim/status"]
    }
    before = [total for time_s, total in totals.items() if time_s <= trigger_s - 1.0]
    until = [total for time_s, total in totals.items() if time_s <= trigger_s + 2.0]
    return max(until) - max(before)


def in_process(policy="rl", settings=None, **scenario):
    """The outcome of the default mission, some of it changed, with the aiming points of a policy."""
    from tethernet_learning.campaigns.cases import Case, aim
    from tethernet_sim.scenario import Scenario

    [case] = aim([Case(Scenario(**scenario), "")], policy)
    return fly(case.scenario, settings)


def assert_same(over_ros, in_process):
    """Bit for bit: the nodes run the code of the in-process call."""
    for name in (
        "captured", "verdict", "cqi", "cqi_all", "locked_pairs", "trigger_time_s", "end_time_s", "enclosed", "held",
        "hold_verdict", "hold_s", "tow_n",
    ):  # fmt: skip
        assert over_ros[name] == getattr(in_process, name), name
    for name in (
        "mcqi", "mouth_area_m2", "net_debris_distance_m", "max_tracking_error_m", "max_load_share",
        "max_contact_force_n", "seed", "mus",
    ):  # fmt: skip
        value = getattr(in_process, name)
        assert over_ros[name] == (None if value is None or math.isnan(value) else value), name
    assert tuple(over_ros["fuel_kg"]) == in_process.fuel_kg
    assert tuple(over_ros["fuel_at_trigger_kg"]) == in_process.fuel_at_trigger_kg


def test_each_of_24_controllers_flies_to_the_point_that_the_planner_gave(tmp_path, domain_id):
    units = [{"node": node, "thread_length_m": 1.0} for node in (*range(0, 23, 2), *range(506, 529, 2))]
    changes = {"name": "many_24mu", "units": units, "closing": "none", "capture": None, "aiming": None}
    system = load_system("zenit_8mu", changes)
    assert system.unit_count == 24
    description = tmp_path / "many.yaml"
    description.write_text(system.to_yaml())
    flags = ("--system", str(description), "--policy", "nominal", *LOCKSTEP, *short(tmp_path, 1.0))
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        assert mission.finish() == 3, mission.text
        assert mission.outcome["warnings"] == mission.outcome["faults"] == []
        messages = read_bag(mission.run)
        sources = [messages[f"/mu{mu}/status"][-1].aiming_source for mu in range(1, 25)]
        assert sources == ["nominal"] * 24, "none fell back for want of an answer"
