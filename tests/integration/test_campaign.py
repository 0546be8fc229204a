"""The campaign command, with missions that are over within a second of flight."""

import os
import signal
import subprocess
import time

import pytest

from tests.command import COMMAND, tethernet
from tethernet_learning.campaigns import chunks as flight
from tethernet_learning.campaigns import tables
from tethernet_learning.campaigns.cases import outcome_columns
from tethernet_learning.campaigns.chunks import failed
from tethernet_learning.campaigns.columns import flatten
from tethernet_sim.fly import fly_many
from tethernet_sim.scenario import Scenario

SHORT = ["--set", "mission.trigger_distance_m=50", "mission.capture_duration_s=1", "mission.debris_far_m=45"]
SIX = ["random", "--mus", "4", "8", "--scenarios", "3", "--seed", "3", *SHORT, "--chunk", "1"]


def read(path):
    return tables.read(path, outcome_columns(8))


def test_a_killed_campaign_goes_on_to_the_same_file(tmp_path, capsys):
    whole, killed = tmp_path / "whole.parquet", tmp_path / "killed.parquet"
    assert tethernet("campaign", *SIX, "--output", str(whole)) == 0
    command = [*COMMAND, "campaign", *SIX, "--output", str(killed)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    for line in process.stderr:
        if line.startswith("2 of 6 flown"):
            process.send_signal(signal.SIGKILL)
            break
    process.communicate(timeout=30)
    assert process.returncode == -signal.SIGKILL
    kept = len((tmp_path / "killed.parquet.part").read_text().splitlines())
    assert 2 <= kept < 6
    assert not killed.exists()
    capsys.readouterr()
    assert tethernet("campaign", *SIX, "--output", str(killed)) == 0
    assert f"6 missions, {kept} flown before" in capsys.readouterr().err
    assert killed.read_bytes() == whole.read_bytes()
    assert [row["mus"] for row in read(killed)] == [4, 4, 4, 8, 8, 8]

    began = time.monotonic()
    assert tethernet("campaign", *SIX, "--output", str(killed)) == 0  # nothing to do
    assert "flown" not in capsys.readouterr().err
    assert time.monotonic() - began < 1.0
    assert tethernet("campaign", *SIX, "--output", str(killed), "--seed", "4") == 2
    assert "source.seed: 3 in the file, 4 now" in capsys.readouterr().err


def test_outcomes_flown_again_from_their_file_are_the_same(tmp_path):
    first, again = tmp_path / "first.csv", tmp_path / "again.parquet"
    assert tethernet("campaign", "loss", "--scenarios", "1", *SHORT, "--output", str(first)) == 0
    assert tethernet("campaign", "file", "--scenarios", str(first), *SHORT, "--output", str(again)) == 0
    assert read(again) == read(first)
    assert {row["group"] for row in read(first)} == {row["failure_kind"] for row in read(first)}


def test_a_mission_that_fails_spoils_no_other(tmp_path, monkeypatch, capsys):
    def fragile(scenarios, settings):
        scenarios = list(scenarios)
        if any(scenario.debris_position[2] < -55.0 for scenario in scenarios):
            raise FloatingPointError("too far")
        return fly_many(scenarios, settings)

    scenarios = tmp_path / "scenarios.csv"
    scenarios.write_text("mus,debris_position_x,debris_position_y,debris_position_z\n8,0,0,-50\n8,0,0,-59\n8,1,0,-50\n")
    monkeypatch.setattr(flight, "fly_many", fragile)
    output = tmp_path / "out.csv"
    assert tethernet("campaign", "file", "--scenarios", str(scenarios), *SHORT, "--output", str(output)) == 0
    assert [row["error"] for row in read(output)] == [None, "FloatingPointError: too far", None]
    assert read(output)[1]["captured"] is False
    assert "3 of 3 flown, 1 in error" in capsys.readouterr().err


def test_an_interrupt_keeps_what_is_flown(tmp_path, monkeypatch, capsys):
    calls = 0

    def interrupted(scenarios, settings):
        nonlocal calls
        calls += 1
        if calls == 3:
            raise KeyboardInterrupt
        return fly_many(scenarios, settings)

    monkeypatch.setattr(flight, "fly_many", interrupted)
    assert tethernet("campaign", *SIX, "--output", str(tmp_path / "out.csv")) == 130
    assert "2 of 6 missions are kept, the same command goes on" in capsys.readouterr().err
    assert len((tmp_path / "out.csv.part").read_text().splitlines()) == 2


def test_maps_and_tables_are_made_from_files(tmp_path, capsys):
    output = str(tmp_path / "out.parquet")
    few = ["tumble", "--rates", "0", "5", "--axes", "2", "--each", "1", "--mus", "8", "--attitude", "random"]
    assert tethernet("campaign", *few, *SHORT, "--output", output) == 0
    capsys.readouterr()
    assert tethernet("campaign", "table", output) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[2:5] for line in lines[1:]] == [["0", "deg/s", "2"], ["5", "deg/s", "2"]]
    for kind in ("attitude", "tumble"):
        picture = tmp_path / f"{kind}.png"
        assert tethernet("campaign", "plot", kind, output, "--output", str(picture)) == 0
        assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["random", "--output", "x.txt"], "x.txt: unknown kind of file; allowed"),
        (["random", "--output", "nowhere/x.csv"], "its folder does not exist"),
        (["random", "--output", "x.csv", "--scenarios", "0"], "0: allowed: a whole number from 1"),
        (["random", "--output", "x.csv", "--seed", "-1"], "-1: allowed: a whole number from 0"),
        (["random", "--output", "x.csv", "--mus", "5"], "5"),
        (["random", "--output", "x.csv", "--set", "kp=3"], "--set kp=3: allowed: PART.NAME=VALUE"),
        (["random", "--output", "x.csv", "--set", "control.kp=-3"], "ControlParameters.kp = -3"),
        (["tumble", "--output", "x.csv", "--rates", "fast"], "fast: allowed: 0 to 90 deg/s"),
        (["loss", "--output", "x.csv", "--latest", "nan"], "nan: allowed: 0 to 1000 s"),
        (["file", "--output", "x.csv", "--scenarios", "none.csv"], "none.csv cannot be read"),
        (["table", "none.parquet"], "none.parquet cannot be read"),
        (["plot", "tumble", "x.csv", "--output", "x.jpg"], "allowed: names that end in .png"),
    ],
)
def test_wrong_arguments_are_explained(words, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert tethernet("campaign", *words) == 2
    assert told in capsys.readouterr().err
    assert not os.listdir(tmp_path)  # noqa: PTH208


def test_any_systems_fly_in_one_campaign_with_entries_replaced_and_fly_again_from_their_file(tmp_path, capsys):
    own = tmp_path / "mine.yaml"
    own.write_text("name: mine\nbased_on: hexagonal_6mu\ndebris: {mass_kg: 8000.0}\n")
    first, again = tmp_path / "first.csv", tmp_path / "again.csv"
    words = ["--system", "passive_5m", str(own), "--scenarios", "1", "--set", "mission.give_up_s=1"]
    words += ["mission.capture_duration_s=1", "system.net.thread.damping_ratio=0.05"]
    assert tethernet("campaign", "random", *words, "--output", str(first)) == 0
    assert [(row["system"], row["mus"], row["error"]) for row in read(first)] == [
        ("passive_5m", 0, None),
        ("mine", 6, None),
    ]
    header = first.read_text().splitlines()[0].split(",")
    assert "fuel_kg_mu6" in header
    assert "fuel_kg_mu7" not in header
    assert len({row["system_digest"] for row in read(first)}) == 2
    rules = ["--set", "mission.give_up_s=1", "mission.capture_duration_s=1"]
    assert tethernet("campaign", "file", "--scenarios", str(first), *rules, "--output", str(again)) == 0
    assert [{**row, "index": 0} for row in read(again)] == [{**row, "index": 0} for row in read(first)]
    capsys.readouterr()
    assert tethernet("campaign", "table", str(first)) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["system", "passive_5m", "mine"]
    picture = tmp_path / "map.png"
    assert tethernet("campaign", "plot", "attitude", str(first), "--output", str(picture)) == 0
    (tmp_path / "first.csv.json").unlink()
    assert tethernet("campaign", "plot", "attitude", str(first), "--output", str(picture)) == 2
    assert "--system FILE" in capsys.readouterr().err


def test_an_outcomes_file_from_before_systems_is_read(tmp_path, capsys):
    cells = flatten(failed(Scenario("zenit_4mu"), ""), 4)
    cells = {name: cell for name, cell in cells.items() if not name.startswith("system")}
    cells |= {"index": 0, "group": "random", "policy": "nominal", "cqi": 1.0}
    tables.write(tmp_path / "old.csv", {name: outcome_columns(4)[name] for name in cells}, [cells])
    lacking = tethernet("campaign", "table", str(tmp_path / "old.csv"))
    assert lacking == 0, capsys.readouterr().err
    assert "zenit_4mu  nominal  random" in capsys.readouterr().out
