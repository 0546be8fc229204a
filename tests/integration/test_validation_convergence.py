"""The convergence table: what each row changes, and that it goes on where it stood."""

from __future__ import annotations

import numpy as np
import pytest

from tests.command import tethernet
from tethernet_core.system import load_system
from tethernet_learning.campaigns import convergence
from tethernet_sim.fly import Settings
from tethernet_sim.stability import largest_step_of


@pytest.mark.parametrize("name", ["zenit_8mu", "zenit_4mu", "passive_5m"])
def test_every_row_changes_what_it_says_and_is_stable(name):
    base = load_system(name)
    default = Settings.load(base).physics
    rows = convergence.rows_of(base)
    variants = {name: convergence.variant(row, base) for name, row in rows.items()}
    assert variants["as described"] == (base, Settings.load(base))
    assert variants["time step / 4"][1].physics.time_step_s == pytest.approx(default.time_step_s / 4)
    stiffer = variants["contact stiffness x 10"][1].physics
    assert stiffer.contact_stiffness_n_m == pytest.approx(10 * default.contact_stiffness_n_m)
    assert variants["friction 0.6"][1].physics.friction_coefficient == 0.6
    soft = variants["thread modulus / 10"][0].net.material
    assert soft.modulus_pa == pytest.approx(0.1 * base.net.material.modulus_pa)
    assert soft.density_kg_m3 == base.net.material.density_kg_m3
    assert variants["thread damping ratio 0.2"][0].net.material.damping_ratio == 0.2
    assert variants["fold factor 0.1"][1].physics.fold_factor == 0.1
    assert variants["contact of knots alone"][1].physics.contact == "knots"
    if "tether stiffness / 2" in rows:
        assert variants["tether stiffness / 2"][0].tether.stiffness_n_m == 0.5 * base.tether.stiffness_n_m
    assert ("winch stiffness / 10" in rows) == (base.closing.kind == "winch")
    fine = variants["4 springs per thread"][0].net
    assert fine.thread_count == 4 * base.net.thread_count
    assert fine.mass_kg == pytest.approx(base.net.mass_kg)
    assert len({repr(v) for v in variants.values()}) == len(variants), "no two rows are the same"
    for system, settings in variants.values():
        assert settings.physics.time_step_s <= largest_step_of(system, settings.physics)


@pytest.mark.parametrize("name", ["zenit_8mu", "zenit_4mu"])
def test_a_net_with_smaller_meshes_is_as_large_and_its_units_and_winches_are_where_they_were(name):
    base = load_system(name)
    fine, settings = convergence.variant(convergence.ROWS["mesh 0.5 m"], base)
    assert "mesh 1 m" not in convergence.rows_of(base), "that is what it has"
    assert fine.net.node_count == 45 * 45
    assert np.ptp(fine.net.nodes, axis=0).tolist() == np.ptp(base.net.nodes, axis=0).tolist()
    places = [[system.net.nodes[unit.node].tolist() for unit in system.units] for system in (base, fine)]
    assert places[0] == places[1]
    if base.closing.kind == "winch":
        rings = [[system.net.nodes[node].tolist() for node in system.closing.ring] for system in (base, fine)]
        assert rings[0] == rings[1]
    assert settings.physics.time_step_s <= largest_step_of(fine, settings.physics)


def test_a_table_with_a_hold_test_and_a_policy_has_their_columns(tmp_path, capsys):
    words = ["validate", "convergence", "--mus", "4", "--missions", "1", "--rows", "as described", "friction 1"]
    assert tethernet(*words, "--policy", "rl", "--hold", "5", "--tow", "20", "--output", tmp_path) == 0
    head, _, *rows = [line.strip("| ").split(" | ") for line in capsys.readouterr().out.splitlines()]
    assert head[3:6] == ["captured", "held", "pairs of 12, mean (fewest)"]
    assert head[-3:] == ["with the policy: captured", "held", "fuel saved, %"]
    assert [row[0] for row in rows] == ["as described", "friction 1"]
    for row in rows:
        assert len(row) == len(head)
        assert 0.0 < float(row[-1].split()[0]) < 60.0
    assert len(list(tmp_path.glob("*_rl.csv"))) == 2
    assert tethernet(*words[:4], "--rows", "mesh 1 m", "--output", tmp_path) == 2
    assert "--rows mesh 1 m: changes nothing in zenit_4mu; allowed: as described; " in capsys.readouterr().err


def test_the_table_goes_on_where_it_stood(tmp_path, capsys):
    words = ["validate", "convergence", "--missions", "2", "--output", tmp_path, "--rows"]
    assert tethernet(*words, "as described") == 0
    first = capsys.readouterr().out.splitlines()
    assert first[2].startswith("| as described | 100 | 2 | 2 | ")
    written = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.csv")}
    assert tethernet(*words, "friction 0.6", "as described") == 0
    captured = capsys.readouterr()
    lines = captured.out.splitlines()
    assert lines[:3] == first
    assert lines[3].startswith("| friction 0.6 | 100 | 2 | ")
    assert "8 of 20: friction 0.6" in captured.err
    assert (tmp_path / "convergence_zenit_8mu.md").read_text() == captured.out
    now = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.csv")}
    assert len(now) == 2 and written.items() <= now.items(), "nothing is flown again"
    assert tethernet(*words[:3], "3", *words[4:], "as described") == 2
    assert "another campaign" in capsys.readouterr().err
