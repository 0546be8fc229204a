"""Nets of descriptions: what they are made of, and what follows from their graph."""

import math

import numpy as np
import pytest

from tethernet_core.system import DescriptionError, load_system


def net_of(**net):
    """A net of no matter what system."""
    launch = {"ejected": {"bodies": [0], "velocities_m_s": [[0, 0, 0]]}}
    return load_system("sag_hexagonal_1m", {"net": net, "launch": launch}).net


def hexagonal(**entries):
    return net_of(hexagonal={"rings": 3, "spacing_m": 0.5, "inner_rings": True, **entries}, springs_per_thread=1)


def flat_lengths(net):
    ends = net.nodes[net.threads]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


def degrees(net):
    return np.bincount(net.threads.ravel(), minlength=net.node_count)


def test_square_net_of_any_size_lies_round_the_middle():
    square = {"rows": 6, "columns": 9, "mesh_m": 0.25}
    changes = {"net.square": square, "units": NINE_BY_SIX, "closing.docking.docking_distance_m": 0.1}
    net = load_system("zenit_8mu", changes).net
    assert net.grid == (6, 9, 0.25)
    assert net.node_count == 54
    assert net.thread_count == 6 * 8 + 5 * 9
    np.testing.assert_allclose(net.nodes.mean(axis=0), 0.0, atol=1e-15)
    np.testing.assert_allclose(flat_lengths(net), 0.25, rtol=1e-12)
    assert net.nodes[1, 0] - net.nodes[0, 0] == 0.25, "columns run along x"


NINE_BY_SIX = [{"node": {"corner": k}, "thread_length_m": 0.5} for k in (0, 1, 3, 2)] + [
    {"node": {"side": k}, "thread_length_m": 0.5} for k in (0, 1, 3, 2)
]


def test_hexagonal_net_is_a_lattice_of_rings():
    net = hexagonal()
    assert net.node_count == 1 + 3 * 3 * 4
    assert net.thread_count == 9 * 3**2 + 3 * 3
    assert net.center_node == 0
    np.testing.assert_allclose(flat_lengths(net), 0.5, rtol=1e-12)
    assert sorted(np.bincount(degrees(net))[[3, 4, 6]]) == [6, 12, 19]
    # The outer ring begins at corner 0, on the x axis.
    np.testing.assert_allclose(net.nodes[19], [1.5, 0.0, 0.0])


def test_inner_rings_may_be_left_out():
    net = hexagonal(inner_rings=False)
    assert net.thread_count == hexagonal().thread_count - 6 * (1 + 2)
    along_rim = np.isin(net.threads, np.arange(19, 37)).all(axis=1)
    assert along_rim.sum() == 18


def test_triangular_net_has_three_sides():
    net = net_of(hexagonal=None, triangular={"rings": 2, "spacing_m": 1.0}, springs_per_thread=1)
    assert net.node_count == 7 * 8 // 2
    assert net.thread_count == 3 * 6 * 7 // 2
    np.testing.assert_allclose(flat_lengths(net), 1.0, rtol=1e-12)
    corners = net.nodes[degrees(net) == 2]
    assert len(corners) == 3
    np.testing.assert_allclose(np.linalg.norm(corners, axis=1), 2.0 * math.sqrt(3.0))


def test_sagging_net_of_the_validation():
    net = load_system("sag_hexagonal_1m").net
    assert (net.own_node_count, net.node_count, net.thread_count) == (91, 631, 720)
    assert net.mass_kg == pytest.approx(11.3097, rel=1e-5)
    np.testing.assert_allclose(net.rest_lengths, 0.05)
    # E A / l of a spring, and half of each spring at each of its ends.
    np.testing.assert_allclose(net.thread_stiffness, 1e6 * math.pi * 1e-4 / 0.05)
    between = net.node_masses[91:]
    np.testing.assert_allclose(between, 1000.0 * math.pi * 1e-4 * 0.05)


@pytest.mark.parametrize("springs", [2, 3, 7])
def test_springs_in_a_row_keep_length_mass_and_the_thread_as_stiff(springs):
    parted = net_of(springs_per_thread=springs)
    whole = net_of(springs_per_thread=1)
    assert parted.node_count == whole.node_count + (springs - 1) * whole.thread_count
    assert parted.mass_kg == pytest.approx(whole.mass_kg, rel=1e-12)
    np.testing.assert_allclose(flat_lengths(parted), parted.rest_lengths, rtol=1e-9)
    np.testing.assert_allclose(parted.thread_stiffness / springs, whole.thread_stiffness[0], rtol=1e-12)
    np.testing.assert_array_equal(parted.nodes[: whole.node_count], whole.nodes)


def test_a_square_net_of_parted_threads_is_no_grid():
    system = load_system("zenit_8mu", {"net.springs_per_thread": 2})
    assert system.net.grid is None
    assert [unit.node for unit in system.units] == [unit.node for unit in load_system("zenit_8mu").units]
    assert system.unit_tethers[0] == (0, 1, pytest.approx(22.0 + 2.0 * math.sqrt(2.0)))


def test_materials_by_name_and_by_numbers():
    kevlar = net_of(thread={"material": "Kevlar", "radius_m": 0.001, "modulus_pa": None, "density_kg_m3": None})
    assert (kevlar.material.modulus_pa, kevlar.material.density_kg_m3) == (7.05e10, 1440.0)
    assert kevlar.material.strength_n == pytest.approx(2.92e9 * math.pi * 1e-6)
    softer = net_of(thread={"material": "kevlar", "radius_m": 0.001, "modulus_pa": 1e9, "density_kg_m3": None})
    assert (softer.material.modulus_pa, softer.material.density_kg_m3) == (1e9, 1440.0)


def test_masses_at_nodes_are_added_to_those_of_threads():
    bare = hexagonal()
    laden = net_of(
        hexagonal={"rings": 3, "spacing_m": 0.5, "inner_rings": True},
        springs_per_thread=1,
        masses=[{"node": {"corner": 0}, "mass_kg": 0.3}, {"node": 0, "mass_kg": 0.1}],
    )
    added = laden.node_masses - bare.node_masses
    assert np.flatnonzero(added).tolist() == [0, 19]
    np.testing.assert_allclose(added[[0, 19]], [0.1, 0.3])


def write_net(folder):
    nodes = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]])
    threads = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]])
    np.savez(folder / "net.npz", nodes=nodes, threads=threads)
    rows = "\n".join(f"{x}, {y}" for x, y in nodes)
    (folder / "nodes.csv").write_text(f"x, y\n{rows}\n")
    rows = "\n".join(f"{a},{b}" for a, b in threads)
    (folder / "threads.csv").write_text(f"# first, second\n{rows}\n")
    return nodes, threads


OWN = """
based_on: sag_hexagonal_1m
net:
  file: {files}
  springs_per_thread: 1
launch: {{ejected: {{bodies: [0, 1, 2, 3], velocities_m_s: null, speed_m_s: 1.0, opening_angle_deg: 30.0}}}}
"""


@pytest.mark.parametrize("files", ["{path: net.npz}", "{nodes: nodes.csv, threads: threads.csv}"])
def test_nets_from_files(tmp_path, files):
    nodes, threads = write_net(tmp_path)
    path = tmp_path / "own.yaml"
    path.write_text(OWN.format(files=files))
    system = load_system(path)
    assert system.name == "own"
    np.testing.assert_array_equal(system.net.nodes[:, :2], nodes)
    np.testing.assert_array_equal(system.net.threads, threads)
    np.testing.assert_allclose(system.net.rest_lengths, [1.0] * 4 + [math.sqrt(0.5)] * 4)
    assert system.net.center_node == 4
    # Outwards from the middle at 30 degrees to -z.
    np.testing.assert_allclose(
        system.launch.velocities[2], [0.5 * math.sqrt(0.5), 0.5 * math.sqrt(0.5), -math.sqrt(0.75)]
    )


def test_rest_lengths_from_a_file_are_kept(tmp_path):
    nodes, threads = write_net(tmp_path)
    np.savez(tmp_path / "net.npz", nodes=nodes, threads=threads, rest_lengths=np.full(8, 1.25))
    path = tmp_path / "own.yaml"
    path.write_text(OWN.format(files="{path: net.npz}"))
    assert set(load_system(path).net.rest_lengths) == {1.25}


@pytest.mark.parametrize(
    ("address", "node"),
    [
        (7, 7),
        ({"row": 1, "column": 2}, 25),
        ({"row": -1, "column": "middle"}, 517),
        ({"row": "last", "column": "first"}, 506),
        ({"corner": ["last", "first"]}, 506),
        ({"corner": 2}, 528),
        ({"side": 1}, 275),
        ({"near": [-10.6, -11.3]}, 0),
        ("center", 264),
    ],
)
def test_addresses_of_nodes(address, node):
    system = load_system("zenit_8mu", {"net.masses": [{"node": address, "mass_kg": 1.0}]})
    assert system.net.point_masses == ((node, 1.0),)


def test_reach_and_tethers_of_a_hexagonal_net():
    system = load_system("hexagonal_6mu")
    np.testing.assert_allclose(system.unit_reach_m, 15.0, rtol=1e-12)
    lengths = {(a, b): length for a, b, length in system.unit_tethers}
    assert lengths[0, 1] == pytest.approx(14.0 + 2.0)
    assert lengths[0, 2] == pytest.approx(28.0 + 2.0), "round the corner as long as straight through the lattice"
    assert lengths[0, 3] == pytest.approx(28.0 + 2.0)
    assert system.mouth_order == (1, 2, 3, 4, 5, 6)


def test_units_dock_in_their_order_round_the_mouth_whatever_their_numbers():
    corners = [3, 0, 5, 1, 4, 2]
    units = [{"node": {"corner": k}, "thread_length_m": 1.0} for k in corners]
    system = load_system("hexagonal_6mu", {"units": units})
    around = [corners[unit - 1] for unit in system.closing_ring]
    assert around == [3, 4, 5, 0, 1, 2]


def test_largest_net_is_allowed_and_quick_to_derive():
    system = load_system(
        "zenit_4mu", {"net.square": {"rows": 100, "columns": 100, "mesh_m": 0.5}, "closing": "none", "capture": None}
    )
    assert system.net.node_count == 10_000
    assert system.net.node_masses.sum() == pytest.approx(2 * 100 * 99 * 0.5 * 1390 * math.pi * 0.0005**2)
    assert system.unit_tethers[0][2] == pytest.approx(99 * 0.5 + 2 * math.sqrt(2.0))


def test_a_net_like_a_chain_is_found_connected():
    nodes = "".join(f"{i}, {i % 2}\n" for i in range(3000))
    threads = "".join(f"{i}, {i + 1}\n" for i in range(2999))
    assert (
        net_of(hexagonal=None, graph={"nodes": nodes, "threads": threads}, springs_per_thread=1, center=0).node_count
        == 3000
    )


def test_twenty_four_units_and_no_more():
    nodes = [0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22] + [506 + k for k in range(0, 23, 2)]
    units = [{"node": node, "thread_length_m": 1.0} for node in nodes]
    changes = {"closing": "none", "capture": None, "aiming": None}
    assert load_system("zenit_8mu", {**changes, "units": units}).unit_count == 24
    more = [*units, {"node": 264, "thread_length_m": 1.0}]
    with pytest.raises(DescriptionError, match=r"units: 25 units; allowed: 0 to 24"):
        load_system("zenit_8mu", {**changes, "units": more})
