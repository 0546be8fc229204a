"""Intervals and tables."""

import math

import pytest

from tethernet_learning.campaigns.cases import Case, row
from tethernet_learning.campaigns.chunks import failed
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.report import table
from tethernet_learning.campaigns.statistics import mean, share, summarise
from tethernet_sim.scenario import Outcome, Scenario


def outcome(captured=True, pairs=8, fuel=0.02, cqi=1.0):
    return Outcome(captured, "", cqi, pairs, 24.0, 40.0, (fuel, 2 * fuel) * 4, (fuel,) * 8, 530.0, 1.0, 0.1, 1, 8)


@pytest.mark.parametrize(("count", "total"), [(0, 10), (7, 10), (97, 100), (40, 40)])
def test_the_share_has_wilsons_interval(count, total):
    z = 1.959963984540054
    p = count / total
    center = (p + z * z / (2 * total)) / (1 + z * z / total)
    half = z / (1 + z * z / total) * math.sqrt(p * (1 - p) / total + z * z / (4 * total * total))
    found = share(count, total)
    assert found.value == p
    assert (found.low, found.high) == pytest.approx((center - half, center + half), abs=1e-12)


def test_the_mean_has_students_interval():
    found = mean([1.0, 2.0, 3.0, math.nan])
    assert found.value == 2.0
    half = 4.302652729696142 / math.sqrt(3.0)  # t of 2 degrees of freedom at 97.5 %, standard deviation 1
    assert (found.low, found.high) == pytest.approx((2.0 - half, 2.0 + half))
    assert math.isnan(mean([1.0]).low)
    assert mean([math.nan]) is None


def test_errors_count_as_not_captured_and_spoil_no_mean():
    summary = summarise([outcome(), outcome(False, 3, cqi=2.0), failed(Scenario("zenit_8mu"), "broken")])
    assert (summary.count, summary.captured, summary.errors) == (3, 1, 1)
    assert summary.success.value == pytest.approx(1 / 3)
    assert summary.fuel_kg.value == pytest.approx(0.03)
    assert summary.fuel_at_trigger_kg.value == pytest.approx(0.02)
    assert summary.cqi == 1.5
    assert summary.locked_pairs == {0: 1, 3: 1, 8: 1}


def test_the_table_has_one_line_for_each_group():
    flown = [("a", outcome()), ("b", outcome(False, 5)), ("a", outcome())]
    rows = [row(i, Case(Scenario("zenit_8mu"), group), result, 8) for i, (group, result) in enumerate(flown)]
    head, first, second = table(rows)
    assert head.split()[:3] == ["system", "policy", "group"]
    assert first.split()[:5] == ["zenit_8mu", "nominal", "a", "2", "100.0"]
    assert second.split()[:5] == ["zenit_8mu", "nominal", "b", "1", "0.0"]
    assert second.endswith("5: 1")
    assert len(table(rows, ["failure_kind"])) == 2
    with pytest.raises(CampaignError, match="'speed'"):
        table(rows, ["speed"])
