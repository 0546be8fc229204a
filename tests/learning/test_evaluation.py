"""The evaluation of policies, with missions that are over within a second of flight; shipping; model cards."""

import dataclasses
import json
import math
import statistics

import pytest

from tests import tiny_models
from tests.command import tethernet
from tests.systems import zenit
from tethernet_learning import seeds
from tethernet_learning.campaigns.cases import Case
from tethernet_learning.campaigns.chunks import failed
from tethernet_learning.campaigns.comparison import compare
from tethernet_learning.campaigns.report import read, table
from tethernet_learning.evaluation import policy_scores as evaluation
from tethernet_learning.evaluation import report as evaluation_report
from tethernet_learning.flight_settings import Flight
from tethernet_learning.random_scenarios import STILL, Turned, random_scenarios
from tethernet_planner import policies
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.model_file import file_fingerprint
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Outcome, Scenario

pytestmark = pytest.mark.learning


@pytest.fixture(autouse=True)
def shipped(monkeypatch, tmp_path):
    """Nothing is shipped but what the test puts there."""
    folder = tmp_path / "models"
    monkeypatch.setattr(shipped_models, "FOLDER", folder)
    policies._model.cache_clear()
    yield folder
    policies._model.cache_clear()


@pytest.fixture
def short(monkeypatch):
    rules = {"trigger_distance_m": 50.0, "capture_duration_s": 1.0}
    settings = Settings.load(mission=rules)
    monkeypatch.setattr(Settings, "load", classmethod(lambda cls, *_, **__: settings))
    return settings


def outcome(fuel, captured=True, seed=0):
    return Outcome(captured, "", 1.0, 8, 20.0, 40.0, (fuel,) * 8, (0.0,) * 8, 500.0, 1.0, 0.1, seed, 8)


def test_the_reduction_is_the_mean_over_pairs_with_its_interval():
    nominal = [outcome(2.0), outcome(1.0), outcome(4.0, captured=False), failed(Scenario("zenit_8mu", seed=0), "lost")]
    policy = [outcome(1.8), outcome(1.1, captured=False), outcome(3.0), outcome(1.0)]
    found = compare(nominal, policy)
    assert (found.pairs, found.both, found.only_nominal, found.only_policy, found.neither) == (3, 1, 1, 1, 0)
    assert found.reduction.value == pytest.approx((0.1 - 0.1 + 0.25) / 3)
    half = 4.302653 * statistics.stdev([0.1, -0.1, 0.25]) / math.sqrt(3)
    assert found.reduction.high - found.reduction.value == pytest.approx(half)
    assert found.reduction_where_captured.value == pytest.approx(0.1)
    assert found.saved_kg == pytest.approx((1.6, -0.8, 8.0))
    with pytest.raises(ValueError, match="same scenarios"):
        compare(nominal, [*policy[:3], outcome(1.0, seed=9)])


def test_both_fly_the_same_unseen_scenarios_with_the_same_noise(short):
    shipped_models.FOLDER.mkdir()
    tiny_models.policy(shipped_models.place("policy", "zenit_8mu"), zenit(8))
    [flown] = evaluation.evaluate({zenit(8): ["nominal", "rl"]}, 3, 5, {zenit(8): Flight(zenit(8), short)})
    plain, aimed = ([case.scenario for case in flown.cases[name]] for name in ("nominal", "rl"))
    assert plain == random_scenarios(zenit(8), seeds.Purpose.POLICY_EVALUATION, 5, 0, 3)
    assert [(s.debris_position, s.seed) for s in plain] == [(s.debris_position, s.seed) for s in aimed]
    assert [s.aiming_offsets is None for s in plain + aimed] == [True] * 3 + [False] * 3
    assert flown.outcomes["nominal"] != flown.outcomes["rl"]
    assert flown.compared()["rl"].pairs == 3


def test_one_command_compares_both_designs_and_writes_everything(tmp_path, short, capsys):
    files = [tiny_models.policy(tmp_path / f"p{mus}.safetensors", zenit(mus)) for mus in (4, 8)]
    words = ["--scenarios", "2", "--policy", *map(str, files), "--output", str(tmp_path / "out")]
    assert tethernet("evaluate", "policies", *words) == 0
    printed = capsys.readouterr().out
    assert "| zenit_4mu, 2 scenarios | nominal |" in printed
    assert "the paper's trained policy" in printed
    result = json.loads((tmp_path / "out" / "evaluation.json").read_text())
    assert result["stream"] == "POLICY_EVALUATION"
    for name, file, reduction in (("zenit_4mu", files[0], 0.11), ("zenit_8mu", files[1], 0.018)):
        flown = result["systems"][name]
        assert flown["paper"]["reduction"] == reduction
        assert list(flown["policies"]) == ["nominal", str(file)]
        own = flown["policies"][str(file)]
        assert own["model"] == file_fingerprint(file)
        assert own["against_nominal"]["pairs"] == 2
        assert len(own["scenarios"]) == 2
    assert (tmp_path / "out" / "fuel.png").stat().st_size > 10_000
    assert "![Fuel](fuel.png)" in (tmp_path / "out" / "report.md").read_text()
    rows = read([tmp_path / "out" / "outcomes.csv"])
    assert len(rows) == 8
    assert len(table(rows)) == 5


def test_parameters_are_replaced_for_the_nominal_points_and_the_policy_alike(tmp_path, capsys):
    file = tiny_models.policy(tmp_path / "p8.safetensors", zenit(8))
    words = ["--mus", "8", "--scenarios", "1", "--policy", str(file), "--output"]
    short = ["mission.trigger_distance_m=50", "mission.capture_duration_s=1"]
    found = {}
    for ratio in (0.05, 0.08):
        chosen = ["--set", *short, f"system.net.thread.damping_ratio={ratio}"]
        assert tethernet("evaluate", "policies", *words, str(tmp_path / str(ratio)), *chosen) == 0
        result = json.loads((tmp_path / str(ratio) / "evaluation.json").read_text())
        assert result["set"] == chosen[1:]
        flown = result["systems"]["zenit_8mu"]["policies"]
        found[ratio] = [flown[name]["scenarios"][0]["outcome"]["cqi"] for name in ("nominal", str(file))]
    assert all(a != b for a, b in zip(*found.values(), strict=True))
    capsys.readouterr()
    assert tethernet("evaluate", "policies", *words, str(tmp_path / "no"), "--set", "physics.damping=1") == 2
    assert "has no parameter 'damping'" in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


def test_both_indices_stand_in_the_table_with_how_many_are_below_the_threshold(short):
    cases = [Case(Scenario("zenit_8mu", seed=seed), "") for seed in range(3)]
    flown = [dataclasses.replace(outcome(1.0, seed=s), cqi=1.0, cqi_all=a) for s, a in enumerate((2.4, 2.5, 2.9))]
    system = cases[0].scenario.system
    told = evaluation_report.table([evaluation.Evaluated(system, {"nominal": cases}, {"nominal": flown})])
    assert "| CQI, mean; below the threshold | 1.00; 3 of 3 |" in told
    assert "| CQI with the MUs counted, mean; below the threshold | 2.60; 1 of 3 |" in told


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "no policy for system zenit_4mu is shipped"),
        (["--policy", "missing.safetensors"], "there is no file"),
        (["--policy", "best"], "no policy named 'best'"),
        (["--mus", "8", "--policy", "FOUR"], "was made for system zenit_4mu (digest "),
    ],
)
def test_wrong_policies_are_explained_before_anything_flies(tmp_path, capsys, words, message):
    four = str(tiny_models.policy(tmp_path / "four.safetensors", zenit(4)))
    words = [four if word == "FOUR" else word for word in words]
    assert tethernet("evaluate", "policies", *words, "--output", str(tmp_path / "out")) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_shipping_puts_a_model_where_its_name_looks_for_it_with_a_card(tmp_path, short, capsys):
    policy = tiny_models.policy(tmp_path / "policy.safetensors", zenit(8))
    (tmp_path / "history.png").write_bytes(b"a picture")
    out = tmp_path / "out"
    words = ["--mus", "8", "--scenarios", "2", "--output", str(out)]
    assert tethernet("evaluate", "policies", *words, "--policy", str(policy)) == 0
    assert tethernet("models", "install", str(policy), "--evaluation", str(out / "evaluation.json")) == 0
    policies.check("rl", zenit(8))
    card = (shipped_models.FOLDER / "policy_zenit_8mu.md").read_text()
    for words in (
        "# policy_zenit_8mu",
        "| commit | abc |",
        "| against_nominal.pairs | 2 | - |",
        "![Training](policy_zenit_8mu.png)",
    ):
        assert words in card
    assert (shipped_models.FOLDER / "policy_zenit_8mu.png").read_bytes() == b"a picture"
    assert tethernet("models", "install", str(tiny_models.surrogate(tmp_path / "surrogate.safetensors", zenit(4)))) == 0
    assert "# surrogate_zenit_4mu" in (shipped_models.FOLDER / "surrogate_zenit_4mu.md").read_text()
    (tmp_path / "noise.safetensors").write_bytes(b"noise")
    capsys.readouterr()
    assert tethernet("models", "install", str(tmp_path / "noise.safetensors")) == 2
    assert "cannot be read as a model" in capsys.readouterr().err


def test_a_card_with_the_scores_of_another_policy_is_refused(tmp_path, short, capsys):
    flown, other = (tiny_models.policy(tmp_path / f"{dx}.safetensors", zenit(8), dx) for dx in (0.5, 1.0))
    out = tmp_path / "out"
    assert tethernet("evaluate", "policies", "--mus", 8, "--scenarios", 1, "--policy", flown, "--output", out) == 0
    assert tethernet("models", "install", str(other), "--evaluation", str(out / "evaluation.json")) == 2
    assert "has not flown this policy" in capsys.readouterr().err
    assert not shipped_models.place("policy", "zenit_8mu").exists()


def test_narrow_aiming_points_come_late_and_burn_less(capsys):
    assert tethernet("evaluate", "widths", "--mus", "4", "--scenarios", "1", "--factors", "0.9", "1") == 0
    narrow, nominal = (
        [float(cell) for cell in row.split("|")[3:7]] for row in capsys.readouterr().out.splitlines()[2:]
    )
    assert narrow[2] > nominal[2] + 0.5  # the trigger
    assert narrow[0] < 0.9 * nominal[0]  # the fuel
    assert narrow[3] < nominal[3]  # the mouth
    assert tethernet("evaluate", "widths", "--mus", "4", "--factors", "-1") == 2


def test_one_systems_evaluation_as_a_json_file_with_the_hold_test(tmp_path, capsys):
    """At the top what was asked for: rates, means, loads and every mission."""
    file = tmp_path / "found.json"
    words = ["evaluate", "--system", "zenit_4mu", "--policy", "nominal", "--scenarios", "2", "--seed", "5"]
    words += ["--attitude", "random", "--tumble-rate", "1", "--hold", "2", "--tow", "20", "--output", str(file)]
    assert tethernet(*words) == 0, capsys.readouterr().err
    found = json.loads(file.read_text())
    rates = [found[f"{name}_rate"] for name in ("success", "held", "enclosed", "both_cqi")]
    assert rates == [1.0] * 4
    assert len(found["scenarios"]) == 2
    means = ("fuel_per_mu_kg", "fuel_at_trigger_per_mu_kg", "cqi_mean", "cqi_all_mean", "mcqi_mean", "max_load_share")
    assert all(found[name] > 0.0 for name in means)
    assert found["locked_pairs"]
    assert found["errors"] == 0
    attitudes = [one["scenario"]["debris_attitude"] for one in found["scenarios"]]
    assert attitudes[0] != attitudes[1]
    rates_rad_s = [math.hypot(*one["scenario"]["debris_rate"]) for one in found["scenarios"]]
    assert rates_rad_s == pytest.approx([math.radians(1.0)] * 2)
    assert all(one["outcome"]["held"] for one in found["scenarios"])
    assert tethernet("evaluate", "--policy", "nominal", "--scenarios", "1", "--output", str(file)) == 2
    assert "allowed: a JSON file for one --system, or a folder" in capsys.readouterr().err


def test_places_and_noise_are_those_of_the_stream_however_the_debris_turns():
    places = [
        [(s.debris_position, s.seed) for s in random_scenarios(zenit(8), seeds.Purpose.POLICY_EVALUATION, 3, 0, 3, how)]
        for how in (STILL, Turned(True), Turned(False, 5.0))
    ]
    assert places[0] == places[1] == places[2]
