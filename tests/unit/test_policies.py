"""Policies by name."""

import math

import numpy as np
import pytest

from tethernet_core.system import load_system
from tethernet_planner import policies

SYSTEM = {mus: load_system(f"zenit_{mus}mu") for mus in (4, 8)}


@pytest.fixture
def registry(monkeypatch):
    """Policies registered by a test are forgotten at its end."""
    monkeypatch.setattr(policies, "_FACTORIES", dict(policies._FACTORIES))
    policies._loaded.cache_clear()
    yield policies
    policies._loaded.cache_clear()


@pytest.mark.parametrize("mus", [4, 8])
def test_nominal_points_are_the_papers_table_with_its_repetitions_put_right(mus):
    points = policies.aiming_points("nominal", SYSTEM[mus], (1.0, -2.0, -50.0))
    corners = [(-11.0, -14.0), (13.0, -14.0), (-11.0, 10.0), (13.0, 10.0)]
    sides = [(1.0, -13.71), (12.71, -2.0), (-10.71, -2.0), (1.0, 9.71)]
    assert len(points) == mus == len(set(points))
    for point, expected in zip(points, corners + sides, strict=False):
        assert point == pytest.approx((*expected, -50.0))


def test_unknown_policy_names_the_allowed_ones():
    with pytest.raises(policies.PolicyError, match="no policy named 'best'; allowed: nominal"):
        policies.aiming_points("best", SYSTEM[8], (0.0, 0.0, -50.0))
    with pytest.raises(policies.PolicyError, match="allowed"):
        policies.check("", SYSTEM[8])


def test_nominal_points_of_any_system_lie_round_the_debris():
    six = policies.aiming_points("nominal", load_system("hexagonal_6mu"), (1.0, -2.0, -50.0))
    assert np.hypot(*(np.array(six)[:, :2] - (1.0, -2.0)).T) == pytest.approx([15.0] * 6)
    assert policies.aiming_points("nominal", load_system("passive_5m"), (0.0, 0.0, -7.0)) == []


def test_a_policy_is_made_once_and_only_when_it_is_used(registry):
    made = []

    def factory():
        made.append(1)
        return lambda system, debris: [debris] * system.unit_count

    registry.register("mine", factory)
    registry.check("mine", SYSTEM[4])
    assert registry.names() == ["mine", "nominal", "rl"]
    assert made == []
    for _ in range(2):
        assert registry.aiming_points("mine", SYSTEM[4], (0.0, 0.0, -50.0)) == [(0.0, 0.0, -50.0)] * 4
    assert made == [1]
    with pytest.raises(registry.PolicyError, match="already"):
        registry.register("mine", factory)


@pytest.mark.parametrize("bad", [[], [(0.0, 0.0, 0.0)] * 7, [(0.0, 0.0)] * 8, [(math.nan, 0.0, 0.0)] * 8])
def test_a_policy_must_give_one_finite_point_for_each_mu(registry, bad):
    registry.register("bad", lambda: lambda system, debris: bad)
    with pytest.raises(registry.PolicyError, match="one finite x y z for each of 8 MUs"):
        registry.aiming_points("bad", SYSTEM[8], (0.0, 0.0, -50.0))


def test_a_policy_that_fails_says_why(registry):
    def broken():
        raise FileNotFoundError("no such model")

    registry.register("broken", broken)
    with pytest.raises(registry.PolicyError, match="'broken' failed: FileNotFoundError: no such model"):
        registry.aiming_points("broken", SYSTEM[8], (0.0, 0.0, -50.0))
