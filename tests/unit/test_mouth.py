"""How far the net lets the mouth open."""

import numpy as np
import pytest

from tethernet_core.aiming import nominal_aiming_points
from tethernet_core.system import load_system
from tethernet_planner.mouth import project_to_reachable

SYSTEM = {mus: load_system(f"zenit_{mus}mu") for mus in (4, 8)}
RIM_M = {4: 22.0 + 2.0 * np.sqrt(2.0), 8: 11.0 + np.sqrt(2.0) + 0.71}
"""Net and threads between neighbours."""
RING = {4: [1, 2, 4, 3], 8: [1, 5, 2, 6, 4, 8, 3, 7]}


def apart(points: np.ndarray) -> np.ndarray:
    ring = np.array(RING[len(points)]) - 1
    return np.linalg.norm(points[ring] - points[np.roll(ring, -1)], axis=1)


@pytest.mark.parametrize("mus", [4, 8])
def test_points_that_the_net_spans_stay(mus):
    nominal = np.array(nominal_aiming_points(SYSTEM[mus], (3.0, -2.0, -50.0)))
    np.testing.assert_array_equal(project_to_reachable(nominal, SYSTEM[mus]), nominal)
    narrow = nominal.copy()
    narrow[:, :2] -= 0.3 * SYSTEM[mus].aiming.offsets
    np.testing.assert_array_equal(project_to_reachable(narrow, SYSTEM[mus]), narrow)


@pytest.mark.parametrize("mus", [4, 8])
def test_points_too_far_apart_are_drawn_together_without_moving_the_middle(mus):
    random = np.random.default_rng(1)
    for _ in range(50):
        aims = np.array(nominal_aiming_points(SYSTEM[mus], (0.0, 0.0, -50.0)))
        aims[:, :2] += random.choice([-5.0, 5.0], (mus, 2))
        drawn = project_to_reachable(aims, SYSTEM[len(aims)])
        assert apart(drawn).max() <= RIM_M[mus] + 1e-3
        np.testing.assert_allclose(drawn.mean(axis=0), aims.mean(axis=0), atol=1e-9)


def test_opposite_sides_are_no_farther_apart_than_a_row_is_long():
    aims = np.array(nominal_aiming_points(SYSTEM[8], (0.0, 0.0, -50.0)))
    aims[4, 1] -= 5.0
    aims[7, 1] += 5.0
    drawn = project_to_reachable(aims, SYSTEM[len(aims)])
    assert drawn[7, 1] - drawn[4, 1] == pytest.approx(22.0 + 2 * 0.71)
    np.testing.assert_array_equal(drawn[[5, 6]], aims[[5, 6]])


def test_two_that_pull_apart_give_way_alike():
    aims = np.array(nominal_aiming_points(SYSTEM[4], (0.0, 0.0, -50.0)))
    aims[0, 0] -= 2.0
    aims[1, 0] += 2.0
    excess = 28.0 - RIM_M[4]
    drawn = project_to_reachable(aims, SYSTEM[len(aims)])
    assert drawn[0, 0] == pytest.approx(-14.0 + excess / 2.0)
    assert drawn[1, 0] == pytest.approx(14.0 - excess / 2.0)
