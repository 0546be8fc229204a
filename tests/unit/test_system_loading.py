"""Reading, changing, writing and comparing descriptions."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from tethernet_core.parameters import read_yaml
from tethernet_core.system import DescriptionError, load_system, shipped_systems, system_from_text
from tethernet_core.system.drawing import draw

SOURCES = Path(__file__).parents[2] / "ros2_ws" / "src"

OWN = """
# Six units, another mesh, a box.
name: box_6mu
based_on: hexagonal_6mu
net:
  hexagonal: {rings: 10, spacing_m: 0.8}
debris:
  shape: {kind: box, size_m: [2, 3, 6]}
  mass_kg: 3e3
  cqi: null
"""


@pytest.mark.parametrize("name", shipped_systems())
def test_shipped_systems_are_whole(name):
    system = load_system(name)
    assert system.name == name
    assert system.description
    assert (system.net.node_masses > 0.0).all()
    assert system.unit_reach_m.shape == (system.unit_count,)
    assert system.aiming.offsets.shape == (system.unit_count, 2)
    assert len(system.unit_tethers) == system.unit_count * (system.unit_count - 1) // 2
    assert system.closing.pairs.shape == (system.closing.max_locked_pairs, 2)
    assert system.capture.required_locked_pairs <= system.closing.max_locked_pairs
    assert np.linalg.eigvalsh(system.debris.inertia)[0] > 0.0


@pytest.mark.parametrize("name", shipped_systems())
def test_a_system_is_written_and_read_again(name):
    system = load_system(name)
    again = system_from_text(system.to_yaml())
    assert again == system
    assert again.digest == system.digest
    assert again.to_yaml() == system.to_yaml()
    np.testing.assert_array_equal(again.net.nodes, system.net.nodes)


@pytest.mark.parametrize("name", shipped_systems())
def test_a_system_survives_pickling(name):
    system = load_system(name)
    assert pickle.loads(pickle.dumps(system)) == system


def test_a_shipped_system_is_made_once():
    assert load_system("zenit_8mu") is load_system("zenit_8mu")


def test_arrays_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        load_system("zenit_8mu").net.nodes[0] = 1.0


def test_own_system_changes_what_it_says_and_keeps_the_rest(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text(OWN)
    system, base = load_system(path), load_system("hexagonal_6mu")
    assert system.name == "box_6mu"
    assert system.net.node_count == 331
    assert system.net.mesh_m == 0.8
    assert system.unit_count == 6
    assert system.debris.shape.kind == "box"
    np.testing.assert_allclose(system.debris.inertia, np.diag([9 + 36, 4 + 36, 4 + 9]) * 3000.0 / 12.0)
    assert (system.debris.cqi_volume_m3, system.debris.cqi_area_m2, system.debris.cqi_length_m) == (36.0, 72.0, 1.0)
    assert system.chaser == base.chaser
    assert system.units[0].mass_kg == base.units[0].mass_kg
    np.testing.assert_allclose(system.unit_reach_m, 9.0)


def test_based_on_another_file_beside_it(tmp_path):
    (tmp_path / "own.yaml").write_text(OWN)
    (tmp_path / "heavier.yaml").write_text("based_on: own.yaml\nunit: {mass_kg: 4.0}\n")
    system = load_system(tmp_path / "heavier.yaml")
    assert system.name == "heavier"
    assert {unit.mass_kg for unit in system.units} == {4.0}
    assert {unit.propellant_kg for unit in system.units} == {0.5}
    assert system.debris.shape.kind == "box"


def test_overrides_dotted_nested_and_in_lists():
    dotted = load_system(
        "zenit_8mu", {"net.square.mesh_m": 0.5, "units[3].thread_length_m": 2.0, "units.0.mass_kg": 3.0}
    )
    assert dotted.net.grid == (23, 23, 0.5)
    assert dotted.units[3].thread_length_m == 2.0
    assert [dotted.units[0].mass_kg, dotted.units[1].mass_kg] == [3.0, 2.5]
    nested = load_system("zenit_8mu", {"net": {"square": {"mesh_m": 0.5}}})
    assert nested.net.grid == dotted.net.grid
    assert load_system("zenit_8mu").net.grid == (23, 23, 1.0)


def test_another_kind_replaces_what_was_there():
    system = load_system("zenit_8mu", {"closing": {"winch": {
        "ring": {"perimeter": 16}, "docking_distance_m": 0.3, "speed_m_s": 1.0, "tension_n": 10.0}},
        "debris.shape": {"kind": "sphere", "radius_m": 2.0}})  # fmt: skip
    assert system.closing.kind == "winch"
    assert len(system.closing.ring) == 16
    assert system.closing.ring[0] == system.units[0].node
    assert system.closing.winches == (0, 22, 528, 506) or set(system.closing.winches) >= {0, 22, 528, 506}
    assert system.debris.shape.kind == "sphere"


def test_ring_begins_at_a_winch_and_each_thread_leads_to_the_next():
    closing = load_system("zenit_4mu", {"closing.winch.ring": [7, 15, 22, 183, 528, 506, 161], "capture": None}).closing
    assert closing.ring == (22, 183, 528, 506, 161, 7, 15)
    assert closing.winches == (22, 528, 506)
    assert closing.winch_thread_of_pair.tolist() == [0, 0, 1, 2, 2, 2, 2]


DIGEST = load_system("zenit_8mu").digest


@pytest.mark.parametrize(
    "overrides",
    [
        {"net.square.mesh_m": 1.001},
        {"net.thread.radius_m": 0.0006},
        {"units[2].thread_length_m": 1.5},
        {"closing.docking.pull_n": 2.5},
        {"debris.mass_kg": 9001.0},
        {"debris.shape.length_m": 11.2},
        {"debris.cqi.volume_m3": 160.0},
        {"capture.center_of_mass": "all"},
        {"aiming.offsets_m": [[-12, -12], [12, -12], [-12, 12], [12, 12], [0, -11], [11, 0], [-11, 0], [0, 11]]},
        {"chaser.mass_kg": 1601.0},
        {"tether.stiffness_n_m": 999.0},
    ],
)
def test_digest_changes_with_the_hardware(overrides):
    assert load_system("zenit_8mu", overrides).digest != DIGEST


@pytest.mark.parametrize(
    "overrides",
    [
        {"name": "other", "description": "other words"},
        {"units[0].node": 0, "units[5].node": {"side": 1}},
        {"closing.docking.ring": None},
        {"net.thread": {"material": None, "modulus_pa": 70e9, "density_kg_m3": 1390, "strength_pa": 3.4e9}},
        {"unit.radius_m": 0.1},
        {"net.springs_per_thread": 1, "net.center": 264},
        {"parameters.physics.time_step_s": 5e-5},
    ],
)
def test_digest_does_not_depend_on_how_the_hardware_is_described(overrides):
    assert load_system("zenit_8mu", overrides).digest == DIGEST


def test_digest_of_a_net_from_a_file_is_that_of_the_same_net(tmp_path):
    net = load_system("hexagonal_6mu").net
    np.savez(tmp_path / "net.npz", nodes=net.nodes, threads=net.threads)
    (tmp_path / "own.yaml").write_text(
        "based_on: hexagonal_6mu\nnet: {file: {path: net.npz}, center: 0}\nunits:\n"
        + "".join(f"- {{node: {unit.node}, thread_length_m: 1.0}}\n" for unit in load_system("hexagonal_6mu").units)
    )
    system = load_system(tmp_path / "own.yaml")
    assert system.net.kind == "file"
    assert system.digest == load_system("hexagonal_6mu").digest
    # Written out, it needs the file no more.
    (tmp_path / "net.npz").unlink()
    assert system_from_text(system.to_yaml()) == system


def test_length_for_the_cqi_where_the_centroid_lies_outside():
    ball = {"kind": "sphere", "radius_m": 1.0}
    parts = [{"shape": ball, "position_m": [0, 0, z]} for z in (-3.0, 3.0)]
    debris = load_system("zenit_8mu", {"debris.shape": {"kind": "compound", "parts": parts}, "debris.cqi": None}).debris
    assert debris.cqi_length_m == pytest.approx(2.0 ** (1.0 / 3.0))


def test_numbers_of_yaml_1_2():
    system = system_from_text(OWN.replace("mass_kg: 3e3", "mass_kg: 0300"))
    assert system.debris.mass_kg == 300.0


def test_text_that_looks_like_a_number_stays_text():
    system = load_system("zenit_8mu", {"name": "1e3", "description": "no", "chaser.mass_kg": 1e-1})
    again = system_from_text(system.to_yaml())
    assert (again.name, again.description, again.chaser.mass_kg) == ("1e3", "no", 0.1)
    assert again == system


def test_parameters_go_with_the_system():
    system = load_system("passive_5m", {"parameters.mission.give_up_s": 5.0})
    assert system.parameters["mission"]["give_up_s"] == 5.0
    assert system.parameters["physics"]["time_step_s"] == 2.5e-5


def test_passive_net_is_ejected_and_has_no_units():
    system = load_system("passive_5m")
    assert system.unit_count == 0
    assert system.mouth_order == system.unit_tethers == system.closing_ring == ()
    assert system.launch.particles == tuple(point.node for point in system.net.point_masses)
    np.testing.assert_allclose(np.linalg.norm(system.launch.velocities, axis=1), 2.5)
    np.testing.assert_allclose(system.launch.velocities.sum(axis=0)[:2], 0.0, atol=1e-12)
    assert (system.launch.velocities[:, 2] < 0.0).all()
    assert system.closing.winch_thread_of_pair.tolist() == sorted(list(range(6)) * 5)


def test_units_may_be_ejected():
    system = load_system("zenit_4mu", {"launch": {"ejected": {"speed_m_s": 2.0, "opening_angle_deg": 45.0}}})
    assert system.launch.particles == (529, 530, 531, 532)
    np.testing.assert_allclose(system.launch.velocities[0], [-1.0, -1.0, -np.sqrt(2.0)])


def test_all_units_of_envisat_can_meet_behind_it():
    system = load_system("envisat_8mu")
    vertices, _ = system.debris.shape.triangles()
    z = vertices[:, 2] - system.debris.center_of_mass[2]
    # Long axis along a row, centre of mass in the net's middle: both units of that row share the way round.
    around = 2.0 * (z.max() - z.min()) + 4.57
    assert system.unit_reach_m[5] + system.unit_reach_m[6] > around + 2.0
    # Long axis along the approach.
    assert system.unit_reach_m.min() > z.max() - z.min() + 1.0


@pytest.mark.parametrize("name", shipped_systems())
def test_summary_and_drawing(name, tmp_path):
    system = load_system(name)
    lines = system.summary()
    assert lines[0].startswith(name)
    assert any(str(system.net.node_count) in line for line in lines)
    assert lines[-1].split() == ["digest", system.digest]
    picture = draw(system, tmp_path / "system.png")
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", shipped_systems())
def test_parameters_that_shipped_systems_give_are_known(name):
    files = {path.stem: path for path in SOURCES.glob("*/*/config/*.yaml")}
    for section, values in load_system(name).parameters.items():
        known = next(iter(read_yaml(files[section]).values()))
        assert values.keys() <= known.keys()


def test_debris_from_a_mesh_file_beside_the_description(tmp_path):
    pytest.importorskip("tethernet_core.shapes.mesh")
    pytest.importorskip("trimesh")
    corners = [(x, y, z) for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
    faces = [f"f {a + 1} {b + 1} {c + 1}\nf {a + 1} {c + 1} {d + 1}\n" for a, b, c, d in sides]
    (tmp_path / "closed.obj").write_text(vertices + "".join(faces))
    (tmp_path / "open.obj").write_text(vertices + "".join(faces[1:]))
    text = "based_on: zenit_8mu\ndebris: {shape: {kind: mesh, file: FILE}, cqi: null}\n"
    (tmp_path / "own.yaml").write_text(text.replace("FILE", "closed.obj"))
    system = load_system(tmp_path / "own.yaml")
    np.testing.assert_allclose(system.debris.inertia, np.diag([39000.0, 30000.0, 15000.0]), atol=1e-6)
    assert system_from_text(system.to_yaml()) == system
    (tmp_path / "own.yaml").write_text(text.replace("FILE", "open.obj"))
    with pytest.raises(DescriptionError, match=r"system own: debris\.shape\.file is open: .*allowed: a closed surface"):
        load_system(tmp_path / "own.yaml")
