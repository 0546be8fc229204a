"""The convergence table: what each row changes, and that it goes on where it stood."""

from __future__ import annotations

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
    variants = {row: convergence.variant(convergence.ROWS[row], base) for row in convergence.ROWS}
    assert variants["as described"] == (base, Settings.load(base))
    assert variants["time step / 4"][1].physics.time_step_s == pytest.approx(default.time_step_s / 4)
    stiffer = variants["contact stiffness x 10"][1].physics
    assert stiffer.contact_stiffness_n_m == pytest.approx(10 * default.contact_stiffness_n_m)
    assert variants["friction 0.6"][1].physics.friction_coefficient == 0.6
    soft = variants["thread modulus / 10"][0].net.material
    assert soft.modulus_pa == pytest.approx(0.1 * base.net.material.modulus_pa)
    assert soft.density_kg_m3 == base.net.material.density_kg_m3
    assert variants["thread damping ratio 0.2"][0].net.material.damping_ratio == 0.2
    fine = variants["4 springs per thread"][0].net
    assert fine.thread_count == 4 * base.net.thread_count
    assert fine.mass_kg == pytest.approx(base.net.mass_kg)
    assert len({repr(v) for v in variants.values()}) == len(variants), "no two rows are the same"
    for system, settings in variants.values():
        assert settings.physics.time_step_s <= largest_step_of(system, settings.physics)


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
    assert "8 of 13: friction 0.6" in captured.err
    assert (tmp_path / "convergence_zenit_8mu.md").read_text() == captured.out
    now = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.csv")}
    assert len(now) == 2 and written.items() <= now.items(), "nothing is flown again"
    assert tethernet(*words[:3], "3", *words[4:], "as described") == 2
    assert "another campaign" in capsys.readouterr().err
