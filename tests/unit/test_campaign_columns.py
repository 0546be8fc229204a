"""Scenarios and outcomes as rows."""

import dataclasses
import math
from pathlib import Path

import pytest

import tethernet_learning
from tethernet_core.system import load_system
from tethernet_learning.campaigns.cases import Case, outcome_columns, row
from tethernet_learning.campaigns.chunks import failed
from tethernet_learning.campaigns.columns import columns, flatten, in_words, rebuild, rebuild_given, units_in
from tethernet_learning.campaigns.flown_systems import FlownSystems
from tethernet_sim.scenario import Failure, Outcome, Scenario

SCENARIO = Scenario(
    "zenit_4mu",
    debris_position=(1.0, 2.0, -50.0),
    aiming_offsets=((0.0, 1.0), (2.0, 3.0), (4.0, 5.0), (6.0, 7.0)),
    failure=Failure(mu=3, kind="no_thrust", time_s=12.5),
)
OUTCOME = Outcome(True, "captured", 1.5, 8, None, 40.0, (0.1, 0.2, 0.3, 0.4), (0.0,) * 4, 560.0, 3.0, 0.2, 1, 4)


@dataclasses.dataclass(frozen=True)
class Grown:
    mus: int
    mass_kg: float
    torque: tuple[float, float, float] | None = None
    kind: str = "plain"


def test_every_number_has_a_plain_column():
    cells = flatten(SCENARIO, 8)
    assert (cells["debris_position_z"], cells["debris_attitude_w"]) == (-50.0, math.sqrt(0.5))
    assert (cells["aiming_offsets_mu3_y"], cells["aiming_offsets_mu5_x"]) == (5.0, None)
    assert (cells["failure_mu"], cells["failure_kind"], cells["failure_time_s"]) == (3, "no_thrust", 12.5)
    assert list(cells) == list(columns(Scenario, 8))
    assert columns(Outcome, 8)["fuel_kg_mu8"] is float
    assert columns(Outcome, 8)["captured"] is bool


@pytest.mark.parametrize("scenario", [SCENARIO, Scenario("zenit_8mu", seed=2**62)])
def test_a_scenario_comes_back(scenario):
    cells = flatten(scenario, 8)
    assert (cells["system"], cells["system_digest"]) == (scenario.system.name, scenario.system.digest)
    assert rebuild_given(Scenario, cells, FlownSystems().of) == scenario


def test_an_outcome_comes_back_and_what_is_unknown_stays_so():
    assert rebuild(Outcome, flatten(OUTCOME, 4)) == OUTCOME
    cells = flatten(failed(SCENARIO, "no reason"), 6)
    assert cells["cqi"] is None
    again = rebuild(Outcome, cells)
    assert math.isnan(again.cqi)
    assert len(again.fuel_kg) == 4
    assert all(math.isnan(fuel) for fuel in again.fuel_kg)
    assert again.error == "no reason"


def test_a_field_added_later_gets_columns_and_older_rows_take_its_default():
    assert flatten(Grown(4, 1.0, (1.0, 2.0, 3.0)), 4) == {
        "mus": 4, "mass_kg": 1.0, "torque_x": 1.0, "torque_y": 2.0, "torque_z": 3.0, "kind": "plain",
    }  # fmt: skip
    assert rebuild(Grown, {"mus": 4, "mass_kg": 1.0}) == Grown(4, 1.0)


def test_half_a_vector_is_refused():
    with pytest.raises(ValueError, match="debris_position_y"):
        rebuild_given(Scenario, {"debris_position_x": 1.0}, FlownSystems().of)


def test_a_row_tells_scenario_outcome_and_labels():
    cells = row(7, Case(SCENARIO, "some", "nominal"), OUTCOME, 4)
    assert list(cells) == list(outcome_columns(4))
    assert (cells["index"], cells["group"], cells["policy"], cells["mus"]) == (7, "some", "nominal", 4)


def test_the_readme_describes_every_column():
    text = (Path(tethernet_learning.__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    lacking = [name for name in in_words(outcome_columns(2)).split(", ") if f"`{name}`" not in text]
    assert not lacking, f"describe these in the README's table of columns: {lacking}"


def test_columns_of_units_follow_the_largest_system_and_none_is_needed_without_units():
    for units in (0, 1, 6, 24):
        names = [name for name in outcome_columns(units) if name.startswith("fuel_kg_mu")]
        assert len(names) == units == units_in(outcome_columns(units))
    passive = Scenario("passive_5m")
    cells = flatten(failed(passive, "not flown"), 0)
    assert rebuild(Outcome, cells).fuel_kg == ()
    assert rebuild_given(Scenario, flatten(passive, 8), FlownSystems().of) == passive


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        (("zenit_8mu", "f" * 64, None), "is .*the description has changed since"),
        (("zenit_8mu", None, 4), "mus = 4, but system zenit_8mu has 8 units"),
        (("mine", None, None), "system = 'mine': no system 'mine'.*--system FILE"),
    ],
)
def test_a_row_of_another_system_than_there_is_is_refused(cells, words):
    with pytest.raises(ValueError, match=words):
        FlownSystems().of(*cells)


def test_rows_find_their_system_by_name_by_units_and_among_those_given():
    own = load_system("zenit_8mu", {"name": "mine", "debris.mass_kg": 8000.0})
    assert FlownSystems([own]).of("mine", own.digest, 8) is own
    assert FlownSystems().of(None, None, 4).name == "zenit_4mu"
    assert FlownSystems().of(None, None, None).name == "zenit_8mu"
