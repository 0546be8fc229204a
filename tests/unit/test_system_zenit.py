"""The paper's two systems as described: the same numbers as ever, to the last bit."""

import math

import numpy as np
import pytest

from tethernet_core.system import load_system, shipped_systems


@pytest.fixture(params=[8, 4])
def count(request):
    return request.param


@pytest.fixture
def zenit(count):
    return load_system(f"zenit_{count}mu")


def test_both_are_shipped():
    assert {"zenit_4mu", "zenit_8mu"} <= set(shipped_systems())


def test_net(zenit):
    net = zenit.net
    assert net.grid == (23, 23, 1.0)
    assert net.node_count == 529
    assert net.thread_count == 1012
    assert net.center_node == 264
    assert net.nodes[[0, 22, 506, 264]].tolist() == [[-11, -11, 0], [11, -11, 0], [-11, 11, 0], [0, 0, 0]]
    assert set(net.rest_lengths) == {1.0}
    assert net.threads[[0, 505, 506, 1011]].tolist() == [[0, 1], [527, 528], [0, 23], [505, 528]]
    corner, border, inner = 0.001091703447122453, 0.0016375551706836796, 0.002183406894244906
    assert net.node_masses[[0, 1, 24]].tolist() == [corner, border, inner]
    assert sorted(set(net.node_masses)) == [corner, border, inner]
    assert set(net.thread_stiffness) == {54977.87143782138}
    assert set(net.thread_damping) == {1.6424122002733716}


def test_units(zenit, count):
    assert [unit.node for unit in zenit.units] == [0, 22, 506, 528, 11, 275, 253, 517][:count]
    assert [unit.thread_length_m for unit in zenit.units] == ([math.sqrt(2.0)] * 4 + [0.71] * 4)[:count]
    for unit in zenit.units:
        assert (unit.mass_kg, unit.radius_m, unit.thrust_limit_n) == (2.5, 0.1, 5.1)
        assert (unit.specific_impulse_s, unit.propellant_kg) == (60.0, 0.5)
        assert (unit.thread_stiffness_n_m, unit.thread_damping_n_s_m) == (54977.87143782138, 1.6424122002733716)


def test_reach_and_mouth(zenit, count):
    assert zenit.unit_reach_m.tolist() == ([16.970562748477143] * 4 + [11.71] * 4)[:count]
    assert zenit.mouth_order == {8: (1, 5, 2, 6, 4, 8, 3, 7), 4: (1, 2, 4, 3)}[count]
    tethers = {(a, b): length for a, b, length in zenit.unit_tethers}
    assert len(tethers) == count * (count - 1) // 2
    assert tethers[0, 1] == tethers[0, 2] == 24.82842712474619
    assert tethers[0, 3] == tethers[1, 2] == 46.828427124746185
    if count == 8:
        assert tethers[0, 4] == 13.124213562373097
        assert tethers[0, 5] == 35.12421356237309
        assert tethers[4, 7] == 22.0 + 0.71 + 0.71


def test_docking_of_8():
    system = load_system("zenit_8mu")
    closing = system.closing
    assert closing.kind == "docking"
    assert system.closing_ring == (1, 5, 2, 6, 4, 8, 3, 7)
    assert system.ring_neighbours == ((1, 5), (5, 2), (2, 6), (6, 4), (4, 8), (8, 3), (3, 7), (7, 1))
    assert closing.pairs.tolist() == [[528 + a, 528 + b] for a, b in system.ring_neighbours]
    assert (closing.docking_distance_m, closing.draw_in_m_s, closing.pull_n) == (0.5, 1.0, 2.0)
    assert (closing.max_locked_pairs, system.capture.required_locked_pairs) == (8, 6)
    assert closing.winch_thread_count == 0


def test_winches_of_4():
    system = load_system("zenit_4mu")
    closing = system.closing
    assert closing.kind == "winch"
    assert closing.ring == (0, 7, 15, 22, 183, 367, 528, 521, 513, 506, 345, 161)
    assert closing.winches == (0, 22, 528, 506)
    assert closing.winch_thread_of_pair.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert (closing.winch_speed_m_s, closing.winch_tension_n, closing.winch_stiffness_n_m) == (1.5, 30.0, 2000.0)
    assert (closing.max_locked_pairs, system.capture.required_locked_pairs) == (12, 8)
    assert system.closing_ring == system.ring_neighbours == ()


def test_debris_chaser_and_tether(zenit):
    debris = zenit.debris
    assert debris.shape.kind == "cylinder"
    assert (debris.shape.radius_m, debris.shape.length_m, debris.mass_kg) == (1.95, 11.1, 9000.0)
    assert debris.inertia.tolist() == np.diag([100963.125, 100963.125, 17111.25]).tolist()
    assert (debris.cqi_volume_m3, debris.cqi_area_m2, debris.cqi_length_m) == (159.9, 59.9, 1.95)
    assert (zenit.chaser.inertia_kg_m2, zenit.chaser.anchor_m) == (600.0, -0.75)
    assert (zenit.tether.stiffness_n_m, zenit.tether.damping_n_s_m) == (1000.0, 2.0)
    assert (zenit.capture.cqi_threshold, zenit.capture.center_of_mass) == (2.5, "knots")


def test_nominal_aiming_points_are_those_of_table_ii(zenit, count):
    corners = [[-12.0, -12.0], [12.0, -12.0], [-12.0, 12.0], [12.0, 12.0]]
    sides = [[0.0, -11.71], [11.71, 0.0], [-11.71, 0.0], [0.0, 11.71]]
    assert zenit.aiming.offsets.tolist() == (corners + sides)[:count]


def test_aiming_points_that_are_derived_are_those_of_table_ii(count):
    derived = load_system(f"zenit_{count}mu", {"aiming": None})
    np.testing.assert_allclose(derived.aiming.offsets, load_system(f"zenit_{count}mu").aiming.offsets, atol=1e-12)


def test_digests_stay():
    assert load_system("zenit_8mu").digest == "6a0eea8b0c389e1cc5da1032f61fed0f5ef59f5fca4d705e0e9dfb5df9c2839d"
    assert load_system("zenit_4mu").digest == "13802eb1776d70642ba4b3c94752e39ff8fa5eb533dcc86ac962e03438cf0fcd"
