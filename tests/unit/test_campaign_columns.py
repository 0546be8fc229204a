"""Scenarios and outcomes as rows."""

import dataclasses
import math
from pathlib import Path

import pytest

import tethernet_planner
from tethernet_learning.campaigns.cases import Case, outcome_columns, row
from tethernet_learning.campaigns.chunks import failed
from tethernet_learning.campaigns.columns import columns, flatten, in_words, rebuild, rebuild_given
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
    cells = flatten(SCENARIO)
    assert (cells["debris_position_z"], cells["debris_attitude_w"]) == (-50.0, math.sqrt(0.5))
    assert (cells["aiming_offsets_mu3_y"], cells["aiming_offsets_mu5_x"]) == (5.0, None)
    assert (cells["failure_mu"], cells["failure_kind"], cells["failure_time_s"]) == (3, "no_thrust", 12.5)
    assert list(cells) == list(columns(Scenario))
    assert columns(Outcome)["fuel_kg_mu8"] is float
    assert columns(Outcome)["captured"] is bool


@pytest.mark.parametrize("scenario", [SCENARIO, Scenario("zenit_8mu", seed=2**62)])
def test_a_scenario_comes_back(scenario):
    assert rebuild(Scenario, flatten(scenario)) == scenario
    assert rebuild_given(Scenario, flatten(scenario)) == scenario


def test_an_outcome_comes_back_and_what_is_unknown_stays_so():
    assert rebuild(Outcome, flatten(OUTCOME)) == OUTCOME
    cells = flatten(failed(SCENARIO, "no reason"))
    assert cells["cqi"] is None
    again = rebuild(Outcome, cells)
    assert math.isnan(again.cqi)
    assert len(again.fuel_kg) == 4
    assert all(math.isnan(fuel) for fuel in again.fuel_kg)
    assert again.error == "no reason"


def test_a_field_added_later_gets_columns_and_older_rows_take_its_default():
    assert flatten(Grown(4, 1.0, (1.0, 2.0, 3.0))) == {
        "mus": 4, "mass_kg": 1.0, "torque_x": 1.0, "torque_y": 2.0, "torque_z": 3.0, "kind": "plain",
    }  # fmt: skip
    assert rebuild(Grown, {"mus": 4, "mass_kg": 1.0}) == Grown(4, 1.0)


def test_half_a_vector_is_refused():
    with pytest.raises(ValueError, match="debris_position_y"):
        rebuild_given(Scenario, {"debris_position_x": 1.0})


def test_a_row_tells_scenario_outcome_and_labels():
    cells = row(7, Case(SCENARIO, "some", "nominal"), OUTCOME)
    assert list(cells) == list(outcome_columns())
    assert (cells["index"], cells["group"], cells["policy"], cells["mus"]) == (7, "some", "nominal", 4)


def test_the_readme_describes_every_column():
    text = (Path(tethernet_planner.__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    lacking = [name for name in in_words(outcome_columns()).split(", ") if f"`{name}`" not in text]
    assert not lacking, f"describe these in the README's table of columns: {lacking}"
