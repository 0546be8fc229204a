import pytest
import yaml

from tethernet_bringup.mission.arguments import parse
from tethernet_bringup.mission.parameters import MissionParametersError, node_classes, resolve
from tethernet_core.parameters import defaults, field_types
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_sim.settings import ScenarioParameters


@pytest.fixture(autouse=True)
def _domain(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


def resolved(words, tmp_path=None, content=None):
    words = words.split()
    if content is not None:
        path = tmp_path / "p.yaml"
        path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
        words += ["--params", str(path)]
    return resolve(parse(words))


def under(node, **values):
    return {node: {"ros__parameters": values}}


def test_the_shipped_values_are_the_default_mission():
    setup = resolved("")
    shipped = defaults(ScenarioParameters)
    assert (setup.system.name, setup.system.unit_count) == ("zenit_8mu", 8)
    assert list(setup.scenario.debris_position) == shipped["debris_position"]
    assert setup.policy == "rl"
    assert setup.simulated
    assert setup.external == ()
    assert set(setup.nodes) == {
        "sim", "planner", "assessor", "recorder", "viewer", "run_mission", *(f"mu{n}_controller" for n in range(1, 9)),
    }  # fmt: skip
    assert setup.nodes["mu3_controller"] == {"mu": 3, "system": "zenit_8mu", **defaults(ControlParameters)}


def test_every_node_gets_exactly_its_own_parameters():
    for name in ("zenit_4mu", "zenit_8mu", "hexagonal_6mu"):
        setup = resolved(f"--system {name}")
        for node, classes in node_classes(setup.system).items():
            own = {name for cls in classes for name in field_types(cls)}
            missing = own - set(setup.nodes[node])
            assert set(setup.nodes[node]) - own <= {"mu", "system"}
            assert all(field_types(cls)[name] is tuple for cls in classes for name in missing & set(field_types(cls)))


def test_flags_reach_every_node_that_must_know():
    setup = resolved("--mus 4 --debris 1 2 -45 --seed 9 --pace lockstep --attitude 0 0 0 1 --tumble 0 0 0.1")
    assert (
        setup.nodes["planner"]["system"]
        == setup.nodes["assessor"]["system"]
        == setup.nodes["recorder"]["system"]
        == setup.nodes["mu4_controller"]["system"]
        == "zenit_4mu"
    )
    sim = setup.nodes["sim"]
    assert sim["debris_position"] == [1.0, 2.0, -45.0]
    assert (sim["seed"], sim["pace"], sim["system"]) == (9, "lockstep", "zenit_4mu")
    assert sim["debris_rate"] == [0.0, 0.0, 0.1]
    assert "mu5_controller" not in setup.nodes


def test_without_simulator_the_planner_is_told_where_the_debris_is():
    setup = resolved("--no-sim --mus 4 --debris 1 2 -45")
    assert not setup.simulated
    assert setup.external == (1, 2, 3, 4)
    for node in ("planner", "assessor"):
        assert setup.nodes[node]["simulated"] is False
        assert setup.nodes[node]["debris_position"] == [1.0, 2.0, -45.0]
    with_simulator = resolved("")
    assert with_simulator.nodes["planner"]["simulated"] is True
    assert "debris_position" not in with_simulator.nodes["planner"]


def test_a_flag_goes_before_the_file_and_the_file_before_the_shipped_values(tmp_path):
    setup = resolved("--seed 5", tmp_path, under("sim", seed=3, debris_position=[1.0, 1.0, -50]))
    assert setup.scenario.seed == 5
    assert setup.scenario.debris_position == (1.0, 1.0, -50.0)


def test_all_nodes_that_have_it_take_a_parameter_given_for_all(tmp_path):
    setup = resolved("", tmp_path, under("/**", kp=12, trigger_distance_m=3.0))
    assert {setup.nodes[node]["kp"] for node in setup.nodes if "kp" in setup.nodes[node]} == {12.0}
    assert all(isinstance(setup.nodes[f"mu{n}_controller"]["kp"], float) for n in range(1, 9))
    assert setup.nodes["planner"]["trigger_distance_m"] == 3.0


def test_one_controller_may_be_tuned_alone(tmp_path):
    setup = resolved("", tmp_path, under("/mu3_controller", kp=11.0))
    assert setup.nodes["mu3_controller"]["kp"] == 11.0
    assert setup.nodes["mu4_controller"]["kp"] == defaults(ControlParameters)["kp"]


def test_the_written_file_flies_the_same_mission_again(tmp_path):
    first = resolved("--mus 4 --debris 1 2 -45 --seed 9 --no-sim")
    again = resolved("--no-sim", tmp_path, first.yaml())
    assert again == first
    simulated = resolved("--external-mu 3")
    assert resolved("", tmp_path, simulated.yaml()) == simulated


def test_the_recorder_is_told_where_to_record(tmp_path):
    setup = resolved("").recorded_in(tmp_path / "bag", tmp_path / "info.json", tmp_path / "system.yaml")
    written = {node: content["ros__parameters"] for node, content in yaml.safe_load(setup.yaml()).items()}
    assert written["recorder"]["output"] == str(tmp_path / "bag")
    readers = {node for node, values in written.items() if values.get("system") == str(tmp_path / "system.yaml")}
    assert readers == set(written) - {"run_mission"}


@pytest.mark.parametrize(
    ("words", "content", "named", "allowed"),
    [
        ("--debris 0 0 -10", None, "--debris: debris z = -10 m", "-60 to -40 m"),
        ("--debris 9.5 0 -50", None, "debris x = 9.5 m", "-9 to 9 m"),
        ("--tumble 99 0 0", None, "--tumble: ", "-10 to 10 rad/s"),
        ("--policy best", None, "--policy best", "nominal"),
        ("", under("planner", policy="best"), "planner: no policy named 'best'", "nominal"),
        ("", under("sim", mu_count=5), "'mu_count' any more", "follows from system"),
        ("", under("sim", system="zenit_5mu"), "sim: system: no system 'zenit_5mu'", "zenit_8mu"),
        ("", under("sim", system="zenit_4mu") | under("planner", system="zenit_8mu"), "several systems", "one for all"),
        ("", under("/**", thrust_limit_n=4.0), "'thrust_limit_n' any more: it is unit.thrust_limit_n", "--system FILE"),
        ("--system passive_5m --no-sim", None, "passive_5m has no units", "a system with units"),
        ("--external-mu 9", None, "--external-mu 9: system zenit_8mu has 8 units", "1 to 8"),
        ("--mus 4 --external-mu 5", None, "--external-mu 5", "1 to 4"),
        ("", under("sim", gravity=9.81), "sim has no parameter 'gravity'", "time_step_s"),
        ("", under("/**", gravity=9.81), "no node has a parameter 'gravity'", ""),
        ("", under("mu9_controller", kp=1.0), "no node 'mu9_controller'", "mu8_controller"),
        ("--mus 4", under("mu5_controller", kp=1.0), "(system zenit_4mu has 4 units)", "mu4_controller"),
        ("", under("mu3_controller", kp=-1.0), "mu3_controller: ControlParameters.kp = -1.0", "0 to 10000 N/m"),
        ("", under("mu3_controller", kp="big"), "ControlParameters.kp = 'big': not a number", "0 to 10000"),
        ("", under("mu3_controller", kp=float("nan")), "ControlParameters.kp = nan: not finite", "0 to 10000"),
        ("", under("mu3_controller", mu=4), "mu = 4", "3, its own number"),
        ("", under("mu3_controller", control_period_s=0.1), "control_period_s is 0.05", "one value for all"),
        ("", under("/**", give_up_s=110.0), "longest_flight_s = 120 s", "together, 125 s"),
        ("", under("mu3_controller", longest_flight_s=50.0), "mu3_controller: longest_flight_s", "together, 55 s"),
        ("", under("sim", debris_attitude=[0, 0, 0, 0.5]), "norm 0.5", "unit quaternion"),
        ("--mus 4", under("sim", external_mus="7"), "external_mus = '7' of system zenit_4mu", "1 to 4"),
        ("--no-sim", under("sim", pace="lockstep"), "'lockstep' with --no-sim", "realtime"),
        ("", "sim: [", "is not YAML", ""),
        ("", "sim: {kp: 1}", "expected 'NODE: {ros__parameters", ""),
        ("", under("run_mission", graph_timeout_s=0.0), "SupervisorParameters.graph_timeout_s", "1 to 600 s"),
        ("--hold -5", None, "--hold: MissionParameters.hold_s = -5", "0 to 1000 s"),
        ("--hold 1e4", None, "--hold: MissionParameters.hold_s = 10000", "0 to 1000 s"),
        ("--hold 60 --tow 2000", None, "--tow: MissionParameters.tow_n = 2000", "0 to 1000 N"),
        ("--hold 60 --tow -1", None, "--tow: MissionParameters.tow_n = -1", "0 to 1000 N"),
        ("--tow 20", None, "--tow: MissionParameters.tow_n = 20 with hold_s = 0", "hold_s above 0 too (--hold S)"),
        ("", under("planner", tow_n=20.0), "planner: MissionParameters.tow_n = 20", "hold_s above 0 too"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_named_with_what_is_allowed(tmp_path, words, content, named, allowed):
    with pytest.raises(MissionParametersError) as raised:
        resolved(words, tmp_path, content)
    assert named in str(raised.value)
    assert allowed in str(raised.value)


def test_a_hold_test_is_asked_of_the_planner_and_makes_the_longest_mission_longer(tmp_path):
    plain, held = resolved(""), resolved("--hold 60 --tow 20")
    assert (plain.hold_s, plain.tow_n) == (0.0, 0.0)
    assert (held.hold_s, held.tow_n) == (60.0, 20.0)
    assert held.nodes["planner"]["hold_s"] == 60.0
    assert held.longest_s == plain.longest_s + 60.0
    assert resolved("--tow 30", tmp_path, under("/**", hold_s=10.0)).tow_n == 30.0
    assert resolved("", tmp_path, held.yaml()) == held


def test_who_tows_without_a_simulator_is_said():
    options = parse(["--no-sim", "--debris", "0", "0", "-50", "--hold", "60", "--tow", "20"])
    resolve(options)
    assert any("the real chaser tows" in notice for notice in options.notices)


def test_a_missing_parameter_file_is_named():
    with pytest.raises(MissionParametersError, match=r"/nowhere/p\.yaml"):
        resolved("--params /nowhere/p.yaml")


def test_the_rules_checked_here_are_those_of_the_mission_file(tmp_path):
    setup = resolved("--debris 0 0 -65", tmp_path, under("/**", debris_far_m=70.0))
    assert setup.scenario.debris_position == (0.0, 0.0, -65.0)
    assert "debris_far_m" in field_types(MissionParameters)


def test_the_systems_own_parameters_go_before_the_shipped_and_behind_the_files(tmp_path):
    shipped = resolved("").nodes["planner"]["closing_duration_s"]
    setup = resolved("--system envisat_8mu")
    own = setup.system.parameters["mission"]
    assert own["closing_duration_s"] != shipped
    assert {name: setup.nodes["planner"][name] for name in own} == own
    given = resolved("--system envisat_8mu", tmp_path, under("/**", closing_duration_s=20.0))
    assert given.nodes["planner"]["closing_duration_s"] == 20.0


def test_what_a_description_gives_that_no_subsystem_has_is_named(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("based_on: zenit_8mu\nparameters: {control: {gain: 3.0}}\n")
    with pytest.raises(MissionParametersError, match=r"system mine: .*control.*gain"):
        resolved(f"--system {path}")


def test_without_a_model_for_the_system_the_nominal_points_are_flown_and_nothing_predicts():
    options = parse(["--system", "hexagonal_6mu"])
    setup = resolve(options)
    assert (setup.policy, setup.nodes["assessor"]["predictor"], setup.models) == ("nominal", "none", {})
    assert [notice.split(":")[0] for notice in options.notices] == [
        "no policy is shipped for system hexagonal_6mu", "no predictor is shipped for system hexagonal_6mu",
    ]  # fmt: skip
    with pytest.raises(MissionParametersError, match="--policy rl"):
        resolved("--system hexagonal_6mu --policy rl")


def test_a_net_without_units_has_no_controllers():
    setup = resolved("--system passive_5m")
    assert set(setup.nodes) == {"sim", "planner", "assessor", "recorder", "viewer", "run_mission"}
    assert setup.external == ()
    assert setup.nodes["sim"]["time_step_s"] == setup.system.parameters["physics"]["time_step_s"]
