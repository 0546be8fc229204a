"""The closed surface of a net, and whether the debris is inside."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tethernet_core.enclosure import axis_points, enclosed, winding_numbers
from tethernet_core.modified_quality import modified_quality
from tethernet_core.net_surface import net_surface
from tethernet_core.system import load_system

SYSTEMS = ("zenit_8mu", "zenit_4mu", "hexagonal_6mu", "passive_5m")
ALONG_X = (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))
STILL = (0.0, 0.0, 0.0, 1.0)


def wrapped(system, radius: float, most: float = np.pi):
    """The flat net rolled onto a ball, its middle at the top: angle from there by distance, the rim at ``most``; the
    units close by their nodes, a little nearer to the lower pole.
    """
    flat = system.net.nodes[:, :2] - system.net.nodes[system.net.center_node, :2]
    away = np.linalg.norm(flat, axis=1)
    around = np.arctan2(flat[:, 1], flat[:, 0])
    # The rim of a square net is not a circle: each direction is scaled to its own rim.
    rim = net_surface(system).rim
    ray = np.interp(around, *_sorted(around[rim], away[rim]), period=2.0 * np.pi)
    angle = most * away / ray
    knots = radius * np.stack(
        [np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle)], axis=1
    )  # fmt: skip
    mus = np.array([knots[unit.node] for unit in system.units]).reshape(-1, 3)
    return knots, mus


def _sorted(key, value):
    order = np.argsort(key)
    return key[order], value[order]


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_thread_is_passed_once_in_either_direction(name):
    system = load_system(name)
    surface = net_surface(system)
    edges = np.concatenate([surface.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    forth, back = (np.unique(e, axis=0, return_counts=True) for e in (edges, edges[:, ::-1]))
    plain = {tuple(e): n for e, n in zip(forth[0].tolist(), forth[1].tolist(), strict=True)}
    reversed_ = {tuple(e): n for e, n in zip(back[0].tolist(), back[1].tolist(), strict=True)}
    # The line between two units is divided by its middle in the panel, and whole in the polygon of all.
    units = range(system.net.node_count, system.particle_count)
    loose = {edge for edge in plain if plain[edge] != reversed_.get(edge, 0)}
    means = set(range(system.particle_count, surface.triangles.max() + 1))
    assert all(set(edge) <= {*units, *means} for edge in loose)
    threads = {tuple(thread) for thread in system.net.threads.tolist()}
    assert all(plain[thread] == reversed_[thread] == 1 for thread in threads)


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_net_folded_at_random_is_a_closed_surface(name):
    """Whole numbers, whatever is crossed and folded; and none far away."""
    system = load_system(name)
    random = np.random.default_rng(3)
    knots = random.normal(size=(system.net.node_count, 3))
    mus = random.normal(size=(system.unit_count, 3))
    points = np.vstack([random.normal(0.0, 0.4, (20, 3)), [[50.0, 0.0, 0.0]]])
    numbers = winding_numbers(knots, mus, points, system)
    assert np.allclose(numbers, np.round(numbers), atol=1e-9)
    assert len(set(np.round(numbers[:-1]))) > 2, "it must be crossed, or the test shows nothing"
    assert numbers[-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["zenit_8mu", "zenit_4mu", "hexagonal_6mu"])
def test_a_wrapped_ball_is_enclosed_and_a_net_beside_is_not(name):
    system = load_system(name)
    knots, mus = wrapped(system, 9.0, 0.95 * np.pi)
    center = np.zeros(3)
    for attitude in (STILL, ALONG_X):
        assert enclosed(knots, mus, center, attitude, system)
        aside = np.array([25.0, 0.0, 0.0])
        assert not enclosed(knots + aside, mus + aside, center, attitude, system)
        mirrored = np.array([1.0, 1.0, -1.0])
        assert enclosed(knots * mirrored, mus * mirrored, center, attitude, system), "inside out is closed too"


def test_debris_whose_end_sticks_out_of_the_mouth_is_not_enclosed():
    """Half a ball, its mouth at the level of the centre: what lies across is at the cap, what hangs out is not in."""
    system = load_system("zenit_8mu")
    knots, mus = wrapped(system, 9.0, 0.5 * np.pi)
    assert not enclosed(knots, mus, np.zeros(3), STILL, system), "long axis through the mouth"
    assert enclosed(knots, mus, np.array([0.0, 0.0, 2.0]), ALONG_X, system), "lying in it"
    assert not enclosed(knots, mus, np.array([0.0, 0.0, -2.0]), ALONG_X, system), "lying before the mouth"


def test_a_fold_in_the_net_changes_nothing():
    """A patch pulled out and laid back over itself: a way out passes it three times."""
    system = load_system("zenit_8mu")
    knots, mus = wrapped(system, 9.0, 0.95 * np.pi)
    polar = np.arccos(knots[:, 2] / 9.0)
    fold = (polar > 1.0) & (polar < 1.6)
    turned = polar + np.where(fold, 1.6 * np.sin((polar - 1.0) / 0.6 * np.pi), 0.0)
    around = np.arctan2(knots[:, 1], knots[:, 0])
    radius = 9.0 + 0.3 * fold
    knots = np.stack(
        [radius * np.sin(turned) * np.cos(around), radius * np.sin(turned) * np.sin(around), radius * np.cos(turned)],
        axis=1,
    )
    assert enclosed(knots, mus, np.zeros(3), ALONG_X, system)
    assert enclosed(knots, mus, np.zeros(3), STILL, system)


def test_a_slit_between_two_bunches_that_lies_round_the_body_does_not_open_the_net():
    """The line between two bunches of units may lead through the body; threads cannot."""
    system = load_system("zenit_8mu")
    knots, mus = wrapped(system, 9.0, 0.95 * np.pi)
    mus = mus.copy()
    mus[:, :] = np.where(np.arange(8)[:, None] < 4, [0.0, -6.0, -3.0], [0.0, 6.0, -3.0])
    assert enclosed(knots, mus, np.zeros(3), ALONG_X, system)


def test_a_net_that_is_no_number_encloses_nothing():
    system = load_system("zenit_8mu")
    knots, mus = wrapped(system, 9.0, 0.95 * np.pi)
    knots[17] = np.nan
    assert not enclosed(knots, mus, np.zeros(3), STILL, system)


def test_the_long_axis_is_that_of_least_inertia():
    points = axis_points(load_system("zenit_8mu"))
    assert np.allclose(np.abs(points), [[0.0, 0.0, 4.995]] * 2)
    assert points[0] == pytest.approx(-points[1])
    envisat = load_system("envisat_8mu")
    ends = axis_points(envisat) + envisat.debris.center_of_mass
    assert np.linalg.norm(ends[1] - ends[0]) > 10.0


def test_the_modified_index_is_worse_for_an_open_net_and_a_loose_one():
    system = load_system("zenit_8mu")
    center = np.zeros(3)
    closed, half, loose = (wrapped(system, r, most * np.pi) for r, most in ((6.5, 1.0), (6.5, 0.5), (9.0, 1.0)))
    value = {k: modified_quality(*net, center, STILL, system) for k, net in enumerate((closed, half, loose))}
    assert 0.0 < value[0] < value[2], "a loose net lies less close"
    assert value[1] > value[0] + 0.25, "half a ball leaves half of the debris out, and its mouth is open"


def test_the_modified_index_of_a_flat_net_is_not_known():
    system = load_system("zenit_8mu")
    flat = np.array([unit.node for unit in system.units])
    assert np.isnan(modified_quality(system.net.nodes, system.net.nodes[flat], np.zeros(3), STILL, system))


def test_the_opening_is_that_of_the_flat_net_and_none_where_the_rim_is_drawn_together():
    for name in SYSTEMS:
        system = load_system(name)
        surface = net_surface(system)
        particles = np.vstack([system.net.nodes, np.zeros((system.unit_count, 3))])
        assert surface.opening_m2(particles) == pytest.approx(surface.flat_opening_m2)
        corners = system.net.nodes[surface.rim, :2]
        assert len(set(map(tuple, corners.tolist()))) == len(surface.rim)
        drawn = particles.copy()
        drawn[surface.rim] = (1.0, 2.0, 3.0)
        assert surface.opening_m2(drawn) == pytest.approx(0.0, abs=1e-9)


def test_meshes_fill_the_flat_net():
    for name in SYSTEMS:
        system = load_system(name)
        surface = net_surface(system)
        mesh = surface.triangles[(surface.triangles < system.net.node_count).all(axis=1)]
        a, b, c = (system.net.nodes[mesh[:, i], :2] for i in range(3))
        areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        assert (areas > 0.0).all()
        assert areas.sum() == pytest.approx(surface.flat_opening_m2)
        sides = itertools.pairwise([*mesh[0], mesh[0][0]])
        assert all(x != y for x, y in sides)
