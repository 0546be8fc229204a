"""The validation cases: each within its tolerances; and what the command makes of them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from bootstrap.places import ROOT
from tests.command import tethernet
from tethernet_sim.validation import capstan, catenary
from tethernet_sim.validation.bounce import restitution
from tethernet_sim.validation.case import Case, Quantity, Result
from tethernet_sim.validation.cases import CASES
from tethernet_sim.validation.stand import Stand, net_system


@pytest.mark.parametrize("name", CASES)
def test_case(name):
    result = CASES[name].run({})
    missed = [f"{q.name}: {q.measured} instead of {q.reference}" for q in result.quantities if not q.passed]
    assert not missed
    assert any(quantity.reference is not None for quantity in result.quantities)


@pytest.mark.parametrize("name", CASES)
def test_every_case_has_a_page_in_one_order(name):
    text = (ROOT / "docs" / "validation" / f"{name}.md").read_text()
    heads = [line.removeprefix("## ") for line in text.splitlines() if line.startswith("## ")]
    assert heads == ["Geometry", "Material", "Numerics", "Boundary", "Result", "Command"]
    assert f"tethernet validate {name}" in text
    assert f"]({name}.md)" in (ROOT / "docs" / "validation" / "README.md").read_text()


@pytest.mark.parametrize("contact", ["knots", "threads"])
def test_more_friction_multiplies_the_tension_by_more(contact):
    for friction in (0.1, 0.5):
        pulled = capstan.pull(capstan.FINE_M, 48, {"friction_coefficient": friction, "contact": contact})
        assert pulled.ratio == pytest.approx(math.exp(friction * pulled.angle), rel=0.01)
    assert capstan.polygon_ratio(0.3, math.radians(176.4), 6) == pytest.approx(2.576, abs=1e-3)
    for threads in (False, True):
        assert capstan.polygon_ratio(0.3, 3.0, 3000, threads) == pytest.approx(math.exp(0.9), rel=1e-6)
    assert capstan.polygon_ratio(0.3, 3.0, 6, threads=True) < math.exp(0.9) < capstan.polygon_ratio(0.3, 3.0, 6)


def test_the_elastic_catenary_of_a_stiff_thread_is_the_common_one():
    stiff = catenary.elastic_catenary(2.0, 2.2, 3.0, 1e9)
    length = 2.0 * stiff.horizontal / 3.0 * math.sinh(0.5 * 2.0 * 3.0 / stiff.horizontal)
    assert length == pytest.approx(2.2, rel=1e-6)
    x, z = stiff.place(np.array([0.0, 1.1, 2.2]))
    np.testing.assert_allclose(x, (0.0, 1.0, 2.0), atol=1e-9)
    assert z[[0, 2]] == pytest.approx(0.0, abs=1e-9)


def test_restitution_between_its_limits():
    assert restitution(0.0) == pytest.approx(1.0)
    assert restitution(0.999) == pytest.approx(math.exp(-2.0), rel=0.01)


def test_loads_on_the_stand_are_those_of_a_falling_and_braked_body():
    system = net_system(
        [[0, 0, 0], [0, 0, 1]], [[0, 1]], [5.0], thread={"material": "technora", "radius_m": 0.001}, masses={0: 2.0}
    )
    stand = Stand(system, {"time_step_s": 1e-4}, held=(1,), gravity=(0.0, 0.0, -9.81), drag_1_s=1.0)
    stand.force[0, 0] = 4.0
    stand.run(1.0)
    fall = 1.0 - math.exp(-1.0)
    assert stand.velocity[2, 0] == pytest.approx(-9.81 * fall, rel=1e-4)
    assert stand.velocity[0, 0] == pytest.approx(4.0 / stand.masses[0] * fall, rel=1e-4)
    assert stand.position[2, 0] == pytest.approx(-9.81 * math.exp(-1.0), rel=1e-3)
    np.testing.assert_array_equal(stand.position[:, 1], (0.0, 0.0, 1.0))


def test_the_command_writes_a_table_lines_and_pictures(tmp_path, capsys):
    assert tethernet("validate", "bounce", "rotation", "--output", tmp_path / "out") == 0
    out = capsys.readouterr().out
    assert "| bounce " in out and "MISSED" not in out
    lines = [json.loads(line) for line in (tmp_path / "out" / "results.jsonl").read_text().splitlines()]
    assert [line["case"] for line in lines] == ["bounce", "rotation"]
    assert all(line["passed"] for line in lines)
    assert (tmp_path / "out" / "results.md").read_text() == out
    for name in ("bounce", "rotation"):
        assert (tmp_path / "out" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert tethernet("validate", "bounce", "--json") == 0
    assert json.loads(capsys.readouterr().out)["case"] == "bounce"
    assert tethernet("validate", "--list") == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(CASES)


def test_a_missed_tolerance_is_an_exit_status(monkeypatch, capsys):
    wrong = Result((Quantity("height", "m", 1.0, 2.0, 0.5), Quantity("speed", "m/s", math.nan)), lambda figure: None)
    monkeypatch.setattr("tethernet_sim.validation.command.CASES", {"wrong": Case("wrong", "none", lambda _: wrong)})
    assert tethernet("validate") == 1
    captured = capsys.readouterr()
    assert captured.out.count("MISSED") == 2
    assert "1 of 1 cases miss a tolerance: wrong" in captured.err
    assert tethernet("validate", "--json") == 1
    assert json.loads(capsys.readouterr().out)["quantities"][1]["measured"] is None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["sga"], "sga: no such case (did you mean sag?); allowed: sag, "),
        (["sag", "--set", "friction=1"], "--set friction=1: allowed: physics.NAME=VALUE"),
        (["sag", "--set", "physics.frction_coefficient=1"], "frction_coefficient"),
        (["sag", "--set", "physics.friction_coefficient=7"], "allowed: 0 to 2"),
        (["convergence", "--output", "x", "--rows", "nothing"], "nothing"),
        (["convergence", "--output", "x", "--missions", "0"], "0: allowed: a whole number from 1"),
    ],
)
def test_wrong_words_are_explained(words, said, capsys):
    assert tethernet("validate", *words) == 2
    assert said in capsys.readouterr().err
