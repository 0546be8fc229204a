"""Policies by name."""

import math

import pytest

from tethernet_planner import policies


@pytest.fixture
def registry(monkeypatch):
    """Policies registered by a test are forgotten at its end."""
    monkeypatch.setattr(policies, "_FACTORIES", dict(policies._FACTORIES))
    policies._loaded.cache_clear()
    yield policies
    policies._loaded.cache_clear()


@pytest.mark.parametrize("mus", [4, 8])
def test_nominal_points_are_the_papers_table_with_its_repetitions_put_right(mus):
    points = policies.aiming_points("nominal", mus, (1.0, -2.0, -50.0))
    corners = [(-11.0, -14.0), (13.0, -14.0), (-11.0, 10.0), (13.0, 10.0)]
    sides = [(1.0, -13.71), (12.71, -2.0), (-10.71, -2.0), (1.0, 9.71)]
    assert len(points) == mus == len(set(points))
    for point, expected in zip(points, corners + sides, strict=False):
        assert point == pytest.approx((*expected, -50.0))


def test_unknown_policy_names_the_allowed_ones():
    with pytest.raises(policies.PolicyError, match="no policy named 'best'; allowed: nominal"):
        policies.aiming_points("best", 8, (0.0, 0.0, -50.0))
    with pytest.raises(policies.PolicyError, match="allowed"):
        policies.check("", 8)


def test_unknown_design_names_the_allowed_ones():
    with pytest.raises(ValueError, match=r"5 MUs; allowed: 4 .* or 8"):
        policies.aiming_points("nominal", 5, (0.0, 0.0, -50.0))


def test_a_policy_is_made_once_and_only_when_it_is_used(registry):
    made = []

    def factory():
        made.append(1)
        return lambda mus, debris: [debris] * mus

    registry.register("mine", factory)
    registry.check("mine", 4)
    assert registry.names() == ["mine", "nominal", "rl"]
    assert made == []
    for _ in range(2):
        assert registry.aiming_points("mine", 4, (0.0, 0.0, -50.0)) == [(0.0, 0.0, -50.0)] * 4
    assert made == [1]
    with pytest.raises(registry.PolicyError, match="already"):
        registry.register("mine", factory)


@pytest.mark.parametrize("bad", [[], [(0.0, 0.0, 0.0)] * 7, [(0.0, 0.0)] * 8, [(math.nan, 0.0, 0.0)] * 8])
def test_a_policy_must_give_one_finite_point_for_each_mu(registry, bad):
    registry.register("bad", lambda: lambda mus, debris: bad)
    with pytest.raises(registry.PolicyError, match="one finite x y z for each of 8 MUs"):
        registry.aiming_points("bad", 8, (0.0, 0.0, -50.0))


def test_a_policy_that_fails_says_why(registry):
    def broken():
        raise FileNotFoundError("no such model")

    registry.register("broken", broken)
    with pytest.raises(registry.PolicyError, match="'broken' failed: FileNotFoundError: no such model"):
        registry.aiming_points("broken", 8, (0.0, 0.0, -50.0))
