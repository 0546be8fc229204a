"""The same scenarios under different settings."""

from tests.command import tethernet
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_learning.campaigns import sweep
from tethernet_sim.fly import Settings


def test_every_option_and_winch_has_settings_that_load():
    options, winches = sweep.option_settings(load_system("zenit_8mu")), sweep.winch_systems(load_system("zenit_4mu"))
    assert options["paper as printed"] == Settings.paper()
    assert options["default"] == Settings.load()
    assert len({repr(s) for s in options.values()}) == len(options), "no two options are the same"
    assert len({winch.digest for winch in winches.values()}) == len(winches)
    assert len(winches) == len(sweep.SPEEDS_M_S) * len(sweep.TENSIONS_N) + len(sweep.STIFFNESSES_N_M)
    assert {w.closing.winch_stiffness_n_m for w in winches.values()} > set(sweep.STIFFNESSES_N_M)
    assert load(ControlParameters).closing_law == "intercept"
    assert options["default, fixed closing place"].mission.closing_plan == "fixed"
    assert load(MissionParameters).closing_plan == "planned"


def test_a_sweep_goes_on_where_it_stood_and_makes_a_table(tmp_path, capsys, monkeypatch):
    short = {"a": Settings.load(mission={"give_up_s": 2.0}), "b": Settings.load(mission={"give_up_s": 3.0})}
    monkeypatch.setattr(sweep, "option_settings", lambda _: short)
    words = ["options", "--mus", "8", "--scenarios", "2", "--output", str(tmp_path)]
    assert tethernet("campaign", "sweep", *words) == 0
    lines = (tmp_path / "options_zenit_8mu.md").read_text().splitlines()
    assert lines[2].startswith("| a | 0 % | 0.0")
    assert len(lines) == 4
    written = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.csv")}
    assert len(written) == 2
    assert tethernet("campaign", "sweep", *words) == 0
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.csv")} == written, "nothing is flown again"
    capsys.readouterr()
    assert tethernet("campaign", "sweep", *words[:4], "3", *words[5:]) == 2
    assert "tethernet campaign sweep: error: " in capsys.readouterr().err


def test_wrong_words_are_explained(capsys):
    assert tethernet("campaign", "sweep", "options", "--scenarios", "0", "--output", "x") == 2
    assert "0: allowed: a whole number from 1" in capsys.readouterr().err
    assert tethernet("campaign", "sweep", "winch", "--mus", "8", "--output", "x") == 2
    said = capsys.readouterr().err
    assert "zenit_8mu: closes by docking; allowed with winch: " in said
    assert "passive_5m, zenit_4mu" in said
