"""The closing plan of other systems than the paper's: rings of any size, debris of any shape, tumbling of any body."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tethernet_core.free_rotation import attitude_after
from tethernet_core.parameters import load
from tethernet_core.rotation import matrix, quaternion_of
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import System, load_system
from tethernet_planner import closing
from tethernet_planner.closing_situation import closing_situation
from tethernet_planner.debris_section import DebrisPose, longest_axis
from tethernet_planner.docking_groups import docked_mus, docking_groups, groupings, most_parts, pairs_of
from tethernet_planner.meeting_places import sideways_directions

RULES, CONTROL = load(MissionParameters), load(ControlParameters)
CENTER = np.array((3.0, -4.0, -50.0))
BOX = {"debris.shape": {"kind": "box", "size_m": [3.0, 4.0, 9.0]}, "debris.cqi": None}


def ring_of(count: int) -> System:
    """The paper's net with ``count`` units on its border that dock."""
    places = 11.0 * np.stack(
        [np.cos(2 * np.pi * np.arange(count) / count), np.sin(2 * np.pi * np.arange(count) / count)]
    )
    places *= 11.0 / np.abs(places).max(axis=0)  # out to the border of the square
    units = [{"node": {"near": place.tolist()}, "thread_length_m": 1.0} for place in places.T]
    changes = {"units": units, "closing.docking.ring": None, "aiming": None, "capture.required_locked_pairs": None}
    return load_system("zenit_8mu", changes)


def seen(system: System, rotation: Rotation, rate=(0.0, 0.0, 0.0), lost=()):
    mouth = np.column_stack([system.aiming.offsets, np.full(system.unit_count, 0.5)])
    velocities = np.tile((0.0, 0.0, -2.0), (system.unit_count, 1))
    in_body = rotation.inv().apply(rate)
    return closing_situation(mouth + CENTER, velocities, CENTER, rotation.as_quat(), (0.0,) * 3, in_body, lost)


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 8, 12, 24])
def test_every_way_to_part_a_ring_is_there_once_and_keeps_neighbours_together(count):
    system = ring_of(count)
    ring = system.closing_ring
    ways = groupings(system, ())
    assert ways[0] == [list(ring)]
    assert pairs_of(ways[0], system) == count
    halves = ways[1:]
    assert len(halves) == (0 if count == 3 else count // 2 if count % 2 == 0 else count)
    assert len({frozenset(map(frozenset, groups)) for groups in halves}) == len(halves)
    neighbours = {frozenset(pair) for pair in system.ring_neighbours}
    for groups in halves:
        assert sorted(itertools.chain(*groups)) == sorted(ring)
        assert abs(len(groups[0]) - len(groups[1])) <= 1
        for group in groups:
            assert all(frozenset(pair) in neighbours for pair in itertools.pairwise(group))
        assert pairs_of(groups, system) == count - 2


@pytest.mark.parametrize("count", [3, 4, 6, 9, 24])
def test_no_plan_has_more_parts_than_announced(count):
    system = ring_of(count)
    for missing in ((), (1,), (1, 2), (1, 3), tuple(range(1, count + 1))):
        lost = tuple(mu in missing for mu in range(1, count + 1))
        assert sum(len(groups) for groups in groupings(system, lost)) <= most_parts(system)


def test_six_units_close_in_one_place_or_in_two():
    system = load_system("hexagonal_6mu")
    across = Rotation.align_vectors([(1.0, 0.0, 0.0)], [(0.0, 0.0, 1.0)])[0]
    pairs = set()
    for rotation in (across, *Rotation.random(20, random_state=1)):
        plan = closing.plan(seen(system, rotation), system, RULES)
        groups = docking_groups(plan.points, system)
        assert plan.feasible, rotation.as_matrix()[:, 2]
        assert sum(max(len(group) - 1, 0) for group in groups) + (len(groups) == 1) == plan.pairs
        pairs.add(plan.pairs)
        pose = DebrisPose(system.debris, rotation.as_matrix())
        for group in groups:
            assert pose.distance(np.array(plan.points[group[0] - 1]) - CENTER) >= RULES.closing_clearance_m - 1e-6
    assert pairs <= {4, 6}
    assert len(pairs) == 2, "both happen"


def test_a_lost_unit_of_six_is_left_out():
    system = load_system("hexagonal_6mu")
    diagonal = Rotation.align_vectors([(1.0, 1.0, 0.0)], [(0.0, 0.0, 1.0)])[0]
    lost = tuple(mu == 2 for mu in range(1, 7))
    plan = closing.plan(seen(system, diagonal, lost=lost), system, RULES)
    assert np.allclose(np.array(plan.points[1]) - CENTER, [*system.aiming.offsets[1], 0.5])
    assert plan.pairs == 4
    assert all(2 not in group for group in docking_groups(plan.points, system))


def test_a_group_of_six_is_done_when_all_its_neighbours_have_docked():
    system = load_system("hexagonal_6mu")
    here, there = (0.0, 0.0, -53.0), (1.0, 0.0, -53.0)
    ring = system.closing_ring
    points = [here if ring.index(mu) < 3 else there for mu in range(1, 7)]
    done = docked_mus(system, [True, True, False, True, False, False], points)
    assert {mu for mu, so in enumerate(done, start=1) if so} == set(ring[:3])


@pytest.mark.parametrize("changes", [BOX, {"debris.shape": {"kind": "sphere", "radius_m": 2.0}, "debris.cqi": None}])
def test_every_attitude_of_another_convex_debris_has_a_plan_that_can_be_flown(changes):
    system = load_system("zenit_8mu", changes)
    for rotation in Rotation.random(10, random_state=3):
        plan = closing.plan(seen(system, rotation), system, RULES)
        assert plan.feasible
        assert plan.pairs >= 6


def test_the_section_of_a_box_is_the_rectangle():
    system = load_system("zenit_8mu", BOX)
    outline = DebrisPose(system.debris, np.eye(3)).outline(np.array((1.0, 0.0)))
    # From the front over the edge, 1.5 m to the side, and down its 9 m: half of the rectangle's circumference.
    assert outline.path_length(np.array([(1.5, 0.0, -4.5)]))[0] == pytest.approx(1.5 + 9.0, rel=0.02)
    assert outline.path_length(np.array([(0.0, 0.0, -4.5)]))[0] == pytest.approx(1.5 + 9.0 + 1.5, rel=0.02)
    sideways = DebrisPose(system.debris, np.eye(3)).outline(np.array((0.0, 1.0)))
    assert sideways.path_length(np.array([(0.0, 2.0, -4.5)]))[0] == pytest.approx(2.0 + 9.0, rel=0.02)


def test_a_string_round_a_compound_spans_its_hollows_and_reaches_its_farthest_part():
    system = load_system("envisat_8mu")
    pose = DebrisPose(system.debris, np.eye(3))
    for angle in np.linspace(0.0, 2.0 * np.pi, 9):
        side = np.array((np.cos(angle), np.sin(angle)))
        points = pose.outline(side).points
        hull = ConvexHull(np.concatenate([points, [[0.0, points[0, 1]], [0.0, points[-1, 1]]]]))
        assert hull.area == pytest.approx(  # every point of the curve is on its hull
            np.linalg.norm(np.diff(points, axis=0), axis=1).sum() + np.linalg.norm(points[0] - points[-1]), rel=1e-6
        )
        assert (points[:, 0] >= 0.0).all()
    # Along the approach: the solar array's tip is 20.75 m behind the bus' middle.
    tip = -20.75 - system.debris.center_of_mass[2]
    assert pose.outline(np.array((1.0, 0.0))).points[:, 1].min() == pytest.approx(tip, abs=0.05)
    inside = -np.asarray(system.debris.center_of_mass)
    assert pose.distance(inside) < 0.0
    assert pose.distance(inside - np.array((0.0, 0.0, 21.75))) == pytest.approx(1.0, abs=1e-6)


def test_what_a_debris_is_long_along():
    assert longest_axis(load_system("zenit_8mu").debris).tolist() == [0.0, 0.0, 1.0]
    assert abs(longest_axis(load_system("envisat_8mu").debris)[2]) > 0.95, "its array"


def test_each_unit_is_on_the_side_of_its_aiming_point_or_else_of_its_node():
    system = load_system("zenit_8mu")
    assert np.allclose(np.linalg.norm(sideways_directions(system), axis=1), 1.0)
    over_the_middle = load_system("zenit_8mu", {"aiming.offsets_m": [[0.0, 0.0]] * 8})
    assert np.allclose(sideways_directions(over_the_middle), sideways_directions(system))


@pytest.mark.parametrize(
    "inertia",
    [
        np.diag([9e4, 9e4, 1.7e4]), np.diag([1e4, 3e4, 3.5e4]),
        np.array([[3.0, 0.4, 0.1], [0.4, 5.0, -0.3], [0.1, -0.3, 6.0]]),
    ],
)  # fmt: skip
def test_a_free_body_turns_as_eulers_equations_say(inertia):
    start = Rotation.from_rotvec((0.4, -0.9, 0.3)).as_matrix()
    rate = np.array((0.09, -0.05, 0.12))

    def euler(_, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        turning = 0.5 * np.concatenate([q[3] * w + np.cross(q[:3], w), [-q[:3] @ w]])
        return np.concatenate([turning, np.linalg.solve(inertia, -np.cross(w, inertia @ w))])

    initial = np.concatenate([quaternion_of(start), start.T @ rate])
    end = solve_ivp(euler, (0.0, 15.0), initial, rtol=1e-11, atol=1e-13).y[:, -1]
    attitude, after = attitude_after(start, rate, inertia, 9000.0, 15.0)
    expected = matrix(end[:4] / np.linalg.norm(end[:4]))
    assert np.allclose(attitude, expected, atol=1e-5)
    assert np.allclose(after, expected @ end[4:], atol=1e-6)
    assert np.allclose(attitude @ attitude.T, np.eye(3), atol=1e-12)


def test_a_quaternion_and_its_matrix():
    for rotation in (
        *Rotation.random(50, random_state=2),
        Rotation.from_rotvec((np.pi, 0.0, 0.0)),
        Rotation.identity(),
    ):
        assert np.allclose(matrix(quaternion_of(rotation.as_matrix())), rotation.as_matrix(), atol=1e-12)
