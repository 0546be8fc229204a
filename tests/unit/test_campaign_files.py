"""Outcomes files: both kinds, begun, continued, refused."""

import json

import pytest

from tethernet_core.system import load_system
from tethernet_learning.campaigns import scenario_file, tables
from tethernet_learning.campaigns.cases import Case, aim, outcome_columns, row
from tethernet_learning.campaigns.chunks import failed
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.provenance import describe, differences
from tethernet_learning.campaigns.results import Results
from tethernet_learning.source_digest import source_digest
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Failure, Scenario

COLUMNS = {"name": str, "count": int, "size": float, "good": bool}
ROWS = [
    {"name": 'a, "b"\nc', "count": 2**62, "size": 0.1 + 0.2, "good": True},
    {"name": None, "count": None, "size": None, "good": None},
    {"name": "d", "count": -1, "size": 1e-300, "good": False},
]
SETTINGS = {load_system("zenit_8mu"): Settings.load("zenit_8mu")}
CASES = [Case(Scenario("zenit_8mu", seed=seed), "some") for seed in range(3)]


def rows(cases):
    return [row(i, case, failed(case.scenario, "not flown"), 8) for i, case in enumerate(cases)]


@pytest.fixture
def description():
    return describe({"name": "test", "seed": 1}, CASES, SETTINGS)


@pytest.mark.parametrize("suffix", tables.SUFFIXES)
def test_a_table_comes_back(tmp_path, suffix):
    path = tmp_path / f"table{suffix}"
    tables.write(path, COLUMNS, ROWS)
    assert tables.read(path, COLUMNS) == ROWS
    assert tables.read(path, {"count": int}) == [{"count": line["count"]} for line in ROWS]
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name,count\na,many\n", "row 1: count = 'many'; allowed: a whole number"),
        ("name,good\na,perhaps\n", "good = 'perhaps'; allowed: true or false"),
        ("name,count\na\n", "row 1: 1 cells for 2 columns"),
        ("other\n1\n", "none of the expected columns; it has: other"),
        ("", "none of the expected columns"),
    ],
)
def test_a_wrong_table_is_explained(tmp_path, text, told):
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(CampaignError) as found:
        tables.read(path, COLUMNS)
    assert told in str(found.value)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(CampaignError, match=r"\.parquet or \.csv"):
        tables.read(tmp_path / "table.xlsx", COLUMNS)
    with pytest.raises(CampaignError, match="cannot be read"):
        tables.read(tmp_path / "none.csv", COLUMNS)
    (tmp_path / "text.parquet").write_text("text")
    with pytest.raises(CampaignError, match="not a Parquet file"):
        tables.read(tmp_path / "text.parquet", COLUMNS)


@pytest.mark.parametrize("suffix", tables.SUFFIXES)
def test_scenarios_come_from_a_file(tmp_path, suffix):
    path = tmp_path / f"scenarios{suffix}"
    lost = Scenario("zenit_4mu", debris_position=(1.0, 2.0, -45.0), failure=Failure(2, "no_odometry", 3.0))
    aimed = Scenario("zenit_4mu", aiming_offsets=((0.0, 0.5),) * 4)
    cases = [Case(lost, "lost", "nominal"), Case(aimed, "aimed", "clever")]
    tables.write(path, outcome_columns(8), rows(cases))
    assert aim(scenario_file.read(path), "nominal") == cases


def test_what_a_scenario_file_lacks_is_the_default(tmp_path):
    path = tmp_path / "scenarios.csv"
    path.write_text("system,mus,seed\n,4,7\nzenit_8mu,,\n")
    assert [case.scenario for case in scenario_file.read(path)] == [
        Scenario("zenit_4mu", seed=7),
        Scenario("zenit_8mu"),
    ]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("mus,sped\n8,1\n", "unknown columns: sped"),
        ("mus\n5\n", "row 1: --mus 5: no shipped system for it"),
        ("system\nzenit_9mu\n", "row 1: system = 'zenit_9mu': no system"),
        ("system,mus\nzenit_4mu,8\n", "row 1: mus = 8, but system zenit_4mu has 4 units"),
        ("mus,debris_rate_x\n8,\n8,1\n", "row 2: column debris_rate_y is empty"),
        ("mus,failure_mu,failure_kind,failure_time_s\n4,5,no_thrust,1\n", "mu from 1 to 4"),
        ("mus\n", "has no rows"),
    ],
)
def test_a_wrong_scenario_file_is_explained(tmp_path, text, told):
    path = tmp_path / "scenarios.csv"
    path.write_text(text)
    with pytest.raises(CampaignError) as found:
        scenario_file.read(path)
    assert told in str(found.value)


def test_what_was_added_is_kept_and_a_torn_line_is_not(tmp_path, description):
    path = tmp_path / "out.parquet"
    with Results(path, description) as results:
        results.add(rows(CASES)[:2])
    with (tmp_path / "out.parquet.part").open("a") as file:
        file.write('{"index": 2, "gro')
    with Results(path, description) as results:
        assert results.rows == rows(CASES)[:2]
        results.add(rows(CASES)[2:])
        results.finish()
        assert results.complete
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.parquet", "out.parquet.json"]
    with Results(path, description) as results:
        assert results.complete
        assert results.rows == rows(CASES)


@pytest.mark.parametrize("flown", [1, 3])
def test_another_campaigns_file_is_refused(tmp_path, description, flown):
    path = tmp_path / "out.csv"
    with Results(path, description) as results:
        results.add(rows(CASES)[:flown])
        if flown == len(CASES):
            results.finish()
    [system] = SETTINGS
    changed = load_system("zenit_8mu", {"debris.mass_kg": 8000.0})
    for settings, cases, told in (
        ({system: Settings.load(system, control={"kp": 11.0})}, CASES, "settings.zenit_8mu.control.kp: "),
        ({changed: SETTINGS[system]}, CASES, "system_digests.zenit_8mu: "),
        (SETTINGS, CASES[:2], "scenarios: 3 in the file, 2 now"),
        (SETTINGS, [*CASES[:2], CASES[0]], "scenarios_sha256"),
    ):
        with pytest.raises(CampaignError) as found:
            Results(path, describe({"name": "test", "seed": 1}, cases, settings))
        assert told in str(found.value)
        assert "give another file, or remove out.csv" in str(found.value)
        assert str(found.value).isprintable(), "a line end would be shown as its escape"


def test_other_code_is_another_campaign(monkeypatch, description):
    import tethernet_planner

    monkeypatch.setattr("tethernet_learning.source_digest.FLOWN_BY", (tethernet_planner,))
    source_digest.cache_clear()
    [difference] = differences(description, describe({"name": "test", "seed": 1}, CASES, SETTINGS))
    source_digest.cache_clear()
    assert difference.startswith("code_sha256: ")


def test_a_file_of_nobody_known_is_not_overwritten(tmp_path, description):
    path = tmp_path / "out.csv"
    path.write_text("precious")
    with pytest.raises(CampaignError, match=r"out\.csv exists, but out\.csv\.json does not"):
        Results(path, description)
    assert path.read_text() == "precious"


def test_a_damaged_file_is_refused(tmp_path, description):
    path = tmp_path / "out.csv"
    with Results(path, description):
        pass
    (tmp_path / "out.csv.part").write_text('{"index": 0\n')
    with pytest.raises(CampaignError, match="line 1 is damaged"):
        Results(path, description)
    (tmp_path / "out.csv.json").write_text("nonsense")
    with pytest.raises(CampaignError, match="is no campaign's"):
        Results(path, description)


def test_two_processes_do_not_write_one_file(tmp_path, description):
    path = tmp_path / "out.csv"
    with Results(path, description), pytest.raises(CampaignError, match="another process"):
        Results(path, description)


def test_the_description_is_complete_json(tmp_path, description):
    Results(tmp_path / "out.csv", description).__exit__()
    told = json.loads((tmp_path / "out.csv.json").read_text())
    assert told == description
    assert told["settings"]["zenit_8mu"]["physics"]["fold_factor"] == 0.05
    assert told["source"] == {"name": "test", "seed": 1}
