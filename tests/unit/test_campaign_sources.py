"""Scenarios of the maps."""

import math

import numpy as np
import pytest

from tests.systems import zenit
from tethernet_core import sphere_directions
from tethernet_core.parameters import load
from tethernet_core.settings import MissionParameters
from tethernet_core.system import load_system
from tethernet_learning import sphere
from tethernet_learning.campaigns import attitude_map, tumble_map
from tethernet_learning.campaigns import variations as sources
from tethernet_learning.campaigns.body_axis import body_axis
from tethernet_learning.campaigns.cases import Case, row
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.flown_systems import FlownSystems
from tethernet_sim.scenario import FAILURES, Outcome, Scenario

RULES = load(MissionParameters)
Z = (0.0, 0.0, 1.0)


@pytest.mark.parametrize("hemisphere", [False, True])
def test_directions_are_spread_evenly(hemisphere):
    count = 300
    found = sphere_directions.directions(count, hemisphere)
    assert np.allclose(np.linalg.norm(found, axis=1), 1.0)
    assert np.abs(found.mean(axis=0) - (0, 0, 0.5 if hemisphere else 0)).max() < 0.01
    cosines = found @ found.T - 2.0 * np.eye(count)
    nearest = np.arccos(cosines.max(axis=1))
    spacing = math.sqrt((2.0 if hemisphere else 4.0) * math.pi / count)  # side of a square of each one's solid angle
    assert nearest.min() > 0.75 * spacing
    assert nearest.max() < 1.25 * spacing


def test_attitudes_point_the_long_axis_where_they_should():
    cases = sources.attitudes(zenit(8), 40, 2, 1, RULES)
    axes = sphere.axes_of(np.array([case.scenario.debris_attitude for case in cases]), Z)
    assert np.allclose(axes, np.repeat(sphere_directions.directions(40, hemisphere=True), 2, axis=0), atol=1e-9)
    assert len({case.scenario.debris_position for case in cases}) == 80
    steep = next(case for case in cases if case.group.startswith("axis  0 to 15"))
    assert math.degrees(math.acos(sphere.axes_of(np.array([steep.scenario.debris_attitude]), Z)[0, 2])) <= 15.0


def test_both_designs_fly_the_same_places():
    four, eight = (sources.attitudes(zenit(mus), 5, 2, 1, RULES) for mus in (4, 8))
    for one, other in zip(four, eight, strict=True):
        assert one.scenario.mus != other.scenario.mus
        assert one.scenario.debris_position == other.scenario.debris_position
        assert one.scenario.debris_attitude == other.scenario.debris_attitude


def test_tumbles_have_the_rates_and_fly_the_same_places():
    cases = sources.tumbles(zenit(8), [0.0, 2.5, 5.0], 4, 3, 1, RULES)
    assert len(cases) == 36
    rates = [math.degrees(math.hypot(*case.scenario.debris_rate)) for case in cases]
    assert rates == pytest.approx([0.0] * 12 + [2.5] * 12 + [5.0] * 12)
    assert [case.scenario.debris_position for case in cases[:12]] == [c.scenario.debris_position for c in cases[24:]]
    assert {case.scenario.debris_attitude for case in cases} == {Scenario("zenit_8mu").debris_attitude}
    assert len({c.scenario.debris_attitude for c in sources.tumbles(zenit(8), [1.0], 4, 3, 1, RULES, True)}) == 12


def test_losses_are_of_any_mu_at_any_time():
    cases = sources.losses(zenit(4), 200, 1, RULES, 32.0)
    lost = [case.scenario.failure for case in cases]
    assert {failure.mu for failure in lost} == {1, 2, 3, 4}
    assert {failure.kind for failure in lost} == set(FAILURES) == {case.group for case in cases}
    times = [failure.time_s for failure in lost]
    assert 0.0 <= min(times) < 2.0
    assert 30.0 < max(times) <= 32.0
    assert {c.scenario.failure.kind for c in sources.losses(zenit(8), 9, 1, RULES, 5.0, ["no_odometry"])} == {
        "no_odometry"
    }


def test_the_projection_keeps_areas_and_can_be_reversed():
    axes = sphere_directions.directions(2000, hemisphere=True)
    flat = sphere.equal_area(axes)
    assert np.allclose(sphere.from_equal_area(flat), axes)
    inner = np.hypot(*flat.T) < math.sqrt(0.5)  # half of the disc's area
    assert inner.mean() == pytest.approx(0.5, abs=0.005)


def texts(figure):
    for panel in figure.axes:
        yield panel.get_title()
        yield from (text.get_text() for text in panel.texts)


def fly_nothing(cases, captured):
    return [
        row(
            i, case, Outcome(captured(case), "", 1.0, 7, 24.0, 40.0, (0.02,) * 8, (0.01,) * 8, 530.0, 1.0, 0.1, 1, 8), 8
        )
        for i, case in enumerate(cases)
    ]


def test_the_attitude_map_paints_each_direction_with_its_own_share():
    cases = sources.attitudes(zenit(8), 50, 2, 1, RULES)
    axis = sphere_directions.directions(50, hemisphere=True)[10]
    rows = fly_nothing(cases, lambda case: case.scenario.debris_attitude == sphere.attitude_along(axis))
    figure = attitude_map.draw(rows, FlownSystems())
    assert "zenit_8mu: 2 of 100 captured (2.0 %)\nlong axis, 50 directions; missions for each: 2" in list(texts(figure))
    image = figure.axes[0].images[0].get_array()
    x, y = sphere.equal_area(axis[None])[0]
    pixel = tuple(int((value + 1.0) / 2.0 * attitude_map.PIXELS) for value in (y, x))
    assert image[pixel] == 100.0
    assert np.ma.filled(image, np.nan)[attitude_map.PIXELS // 2, attitude_map.PIXELS // 2] == 0.0
    assert np.nanmean(np.ma.filled(image, np.nan)) == pytest.approx(2.0, abs=0.5)  # equal area


def test_many_single_attitudes_are_gathered():
    random = np.random.default_rng(1)
    attitudes = [sphere.random_attitude(random) for _ in range(attitude_map.LARGEST_CELLS + 100)]
    some = row(
        0, Case(Scenario("zenit_8mu"), ""), Outcome(True, "", 1.0, 8, 24.0, 40.0, (), (), 530.0, 1.0, 0.1, 1, 8), 8
    )
    rows = [
        {**some, **dict(zip((f"debris_attitude_{axis}" for axis in "xyzw"), attitude, strict=True))}
        for attitude in attitudes
    ]
    axes, cell = attitude_map._cells(rows, Z)
    assert len(axes) == attitude_map.CELLS
    found = sphere.axes_of(np.array(attitudes), Z)
    assert np.abs(np.sum(found * axes[cell], axis=1)).min() > math.cos(math.radians(15.0))


def test_the_tumble_map_counts_rates_and_axes():
    cases = sources.tumbles(zenit(8), [0.0, 5.0], 12, 1, 1, RULES)
    figure = tumble_map.draw(fly_nothing(cases, lambda case: abs(case.scenario.debris_rate[2]) < 1e-6), FlownSystems())
    found = list(texts(figure))
    assert "zenit_8mu: 12 of 24 captured (50.0 %)" in found
    assert found.count("n = 12") == 2
    cells = [text for text in found if " of " in text and "\n" in text]
    assert sum(int(text.split()[-1]) for text in cells) == 24  # twelve that tumble, in both panels
    assert all(text.startswith("0 %\n0 of") for text in cells)


def test_maps_show_what_was_held_beside_what_was_captured():
    cases = sources.tumbles(zenit(8), [0.0, 5.0], 12, 1, 1, RULES)
    rows = fly_nothing(cases, lambda _: True)
    rows = [{**row, "held": number % 4 == 0} for number, row in enumerate(rows)]
    title = "zenit_8mu: 24 of 24 captured (100.0 %), 6 of 24 held (25.0 %)"
    attitudes = attitude_map.draw(rows, FlownSystems())
    captured, held, _ = (panel.images[0].get_array() for panel in attitudes.axes[:3])
    assert np.ma.filled(captured, 100.0).min() == 100.0
    assert 0.0 <= np.ma.filled(held, np.nan)[attitude_map.PIXELS // 2, attitude_map.PIXELS // 2] < 100.0
    assert any(text.startswith(title) for text in texts(attitudes))
    tumbles = tumble_map.draw(rows, FlownSystems())
    assert [panel.get_ylabel() for panel in tumbles.axes[:6:3]] == [
        "captured, with 95 % interval [%]", "held, with 95 % interval [%]"
    ]  # fmt: skip
    assert list(texts(tumbles)).count(title) == 2
    untested = attitude_map.draw(fly_nothing(cases, lambda _: True), FlownSystems())
    assert not any("held" in text for text in texts(untested))


def test_the_axis_is_the_long_one_where_there_is_one():
    assert body_axis(zenit(8)) == (Z, "long axis", True)
    assert body_axis(load_system("passive_5m")) == (Z, "body axis z", True)
    lying = load_system("zenit_8mu", {"debris.shape": {"kind": "box", "size_m": [9.0, 2.0, 2.0]}})
    assert body_axis(lying) == ((1.0, 0.0, 0.0), "long axis", True)
    cases = sources.attitudes(lying, 12, 1, 1, RULES)
    axes = sphere.axes_of(np.array([case.scenario.debris_attitude for case in cases]), (1.0, 0.0, 0.0))
    assert np.allclose(axes, sphere_directions.directions(12, hemisphere=True), atol=1e-9)
    envisat = load_system("envisat_8mu")
    assert not body_axis(envisat).ends_alike
    down = [case.scenario.debris_attitude for case in sources.attitudes(envisat, 12, 1, 1, RULES)]
    assert len({tuple(np.round(attitude, 6)) for attitude in down}) == 12
    along = sphere.in_launch_frame(np.array(down), np.tile(body_axis(envisat).direction, (12, 1)))
    assert np.allclose(along, sphere_directions.directions(12), atol=1e-9), "either end, over the whole sphere"


def test_without_units_none_can_be_lost():
    with pytest.raises(CampaignError, match="passive_5m has no units"):
        sources.losses(load_system("passive_5m"), 3, 1, RULES, 5.0)
