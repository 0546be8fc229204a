"""The evaluation command."""

import json

import pytest

from tethernet_planner.evaluate import main, random_scenarios, summary
from tethernet_sim.fly import Settings, fly_many


def test_writes_statistics_and_every_record(tmp_path, capsys):
    target = tmp_path / "result.json"
    assert main(["--mus", "8", "--scenarios", "2", "--seed", "3", "--output", str(target)]) == 0
    result = json.loads(target.read_text())
    assert result["success_rate"] == 1.0
    assert result["locked_pairs"] == {"8": 2}
    assert result["errors"] == 0
    assert len(result["scenarios"]) == 2
    flown = [record["outcome"]["fuel_kg"] for record in result["scenarios"]]
    assert result["fuel_per_mu_kg"] == pytest.approx(sum(map(sum, flown)) / 16)
    assert "captured          100.0 %" in capsys.readouterr().out
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]


def test_one_seed_gives_one_list_within_the_papers_bounds():
    some, more = random_scenarios(4, 5, 7, "nominal"), random_scenarios(4, 50, 7, "nominal")
    assert more[:5] == some
    assert random_scenarios(4, 5, 8, "nominal") != some
    for scenario in more:
        x, y, z = scenario.debris_position
        assert max(abs(x), abs(y)) <= 9.0
        assert -60.0 <= z <= -40.0
        assert round(x, 1) == x
    assert len({scenario.seed for scenario in more}) == 50


def test_a_mission_in_error_is_counted_not_dropped():
    scenarios = random_scenarios(4, 2, 1, "nominal")
    result = summary(scenarios, fly_many(scenarios, Settings.load(physics={"thread_modulus_pa": 1e12})))
    assert result["errors"] == 2
    assert result["success_rate"] == 0.0
    assert result["fuel_per_mu_kg"] is None
    assert len(result["scenarios"]) == 2


@pytest.mark.parametrize("wrong", [["--mus", "5"], ["--mus", "8", "--scenarios", "0"], ["--mus", "8", "--policy", "x"]])
def test_wrong_arguments_are_explained(wrong, capsys):
    with pytest.raises(SystemExit) as ended:
        main(wrong)
    assert ended.value.code == 2
    assert wrong[-1] in capsys.readouterr().err
