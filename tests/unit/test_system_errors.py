"""Descriptions of what cannot be built or flown: each an error that names the entry and what is allowed."""

import numpy as np
import pytest

from tethernet_core.parameters import ParameterError
from tethernet_core.system import DescriptionError, load_system, system_from_text

SQUARE = "0, 0\n1, 0\n1, 1\n0, 1\n"
SIDES = "0, 1\n1, 2\n2, 3\n3, 0\n"


def graph(nodes, threads):
    return {"net.graph": {"nodes": nodes, "threads": threads}}


# fmt: off
CASES = [
    # Entries
    ({"net.square.mesh": 1.0}, r"net\.square\.mesh: unknown entry \(did you mean mesh_m\?\); allowed: rows, columns"),
    ({"nett": {}}, r"nett: unknown entry \(did you mean net\?\)"),
    ({"net.square.mesh_m": "wide"}, r"net\.square\.mesh_m = 'wide': not a number; allowed: 0\.005 to 10 m"),
    ({"net.square.mesh_m": float("nan")}, r"net\.square\.mesh_m = nan: not finite"),
    ({"net.square.rows": 22.5}, r"net\.square\.rows = 22\.5: not a whole number"),
    ({"net.square.rows": None}, r"net\.square\.rows: is missing; allowed: 2 to"),
    ({"net.square": [1]}, r"net\.square = \[1\]: not a mapping"),
    ({"units": 8}, r"units = 8: not a list"),
    ({"units[3].mass_kg": -1.0}, r"units\[3\]\.mass_kg = -1\.0: out of range; allowed: 0\.01 to 10000 kg"),
    ({"unit.mass_kg": 0.0}, r"unit\.mass_kg = 0\.0: out of range"),
    ({"unit.node": 3}, r"unit\.node: unknown entry"),
    ({"unit.box_m": [0.1, 0.1]}, r"unit\.box_m = \[0\.1, 0\.1\]: has 2 numbers; allowed: 3 numbers, each"),
    ({"unit.propellant_kg": 2.5}, r"propellant_kg = 2\.5: not less than the unit's mass; allowed: below 2"),
    ({"units[8].mass_kg": 1.0}, r"units\[8\]: is no element; allowed: elements 0 to 7"),
    ({"parameters.fysics": {}}, r"parameters\.fysics: unknown subsystem \(did you mean physics\?\)"),
    ({"9": 1}, r"'9': no entry's path"),
    # Nodes and threads
    ({"units[3].node": 900}, r"units\[3\]\.node = 900: no such node; allowed: 0 to 528"),
    ({"units[3].node": {"row": 23, "column": 0}}, r"units\[3\]\.node\.row = 23: no such line of nodes"),
    ({"units[3].node": {"corner": 4}}, r"units\[3\]\.node\.corner = 4: no such one; allowed: 0 to 3"),
    ({"units[3].node": {"colum": 4}}, r"units\[3\]\.node = .*: not an address of a node"),
    ({"units[3].node": 0}, r"units\[3\]\.node = 0: node 0 already bears unit 1"),
    ({"net.thread.material": "kevlr"}, r"net\.thread\.material = 'kevlr': unknown material \(did you mean kevlar\?\)"),
    ({"net.thread.material": None}, r"net\.thread\.modulus_pa: is missing; allowed: a number, or material"),
    ({"net.hexagonal": {"rings": 2}, "net.square": None}, r"net\.hexagonal\.spacing_m: is missing"),
    ({"net": {"square": None}}, r"net: has no kind of net; allowed: exactly one of square"),
    (graph(SQUARE + "5, 5\n", SIDES), r"net\.graph: node 4 at \(5, 5\) m is loose: no thread ends there"),
    (graph(SQUARE + "5, 5\n6, 6\n", SIDES + "4, 5\n"), r"falls into 2 pieces of 4, 2 nodes; no thread joins node 4"),
    (graph(SQUARE + "0, 0\n", SIDES + "0, 4\n"), r"thread 4, from node 0 to node 4, has the length 0 m"),
    (graph(SQUARE, SIDES + "1, 0\n"), r"threads 0 and 4 both join nodes 0 and 1"),
    (graph(SQUARE, SIDES + "2, 2\n"), r"thread 4 leads from node 2 to itself"),
    (graph(SQUARE, SIDES + "2, 4\n"), r"net\.graph\.threads: thread 4 leads from and to nodes 2, 4"),
    (graph("a, b\nc, d\n", SIDES), r"net\.graph\.nodes: line 2 is 'c, d'"),
    (graph("0, 0\n1\n", SIDES), r"net\.graph\.nodes: line 2 has 1 numbers"),
    ({"net.file": {"nodes": "nodes.csv"}}, r"net\.file: names no net; allowed: path \(an npz\), or both"),
    ({"net.file": {"path": "none.npz"}}, r"net\.file\.path = .*none\.npz': cannot be read: No such file"),
    ({"net.square": {"rows": 110, "columns": 110, "mesh_m": 0.2}}, r"12100 nodes, too large: 12 MiB .* at most 10000"),
    ({"net.hexagonal": {"rings": 60, "spacing_m": 0.2}}, r"net\.hexagonal: 60 rings make .* 10981 nodes, too large"),
    ({"net.springs_per_thread": 20}, r"net: 529 nodes and 1012 threads of 20 springs make a net of 19757 nodes"),
    ({"net.masses": [{"node": 0, "mass_kg": 0.0}]}, r"net\.masses\[0\]\.mass_kg = 0\.0: out of range"),
    ({"net.masses": [{"node": 0, "mass_kg": 1}, {"node": 0, "mass_kg": 1}]}, r"node 0 already bears mass 0"),
    # Closing
    ({"closing.docking.ring": [1, 5, 2, 6, 4, 8, 3, 1]}, r"closing\.docking\.ring\[7\]: unit 1 is in the ring twice"),
    ({"closing.docking.ring": [1, 5]}, r"closing\.docking\.ring: 2 units are no ring; allowed: at least 3"),
    ({"closing.docking.ring": [1, 5, 9]}, r"closing\.docking\.ring\[2\] = 9: no such unit; allowed: 1 to 8"),
    ({"closing.docking.ring": [1, 2, 5, 6, 4, 8, 3, 7]}, r"closing\.docking\.ring: does not go round the mouth once"),
    ({"closing.docking.ring": [1, 5, 2]}, r"closing\.docking\.ring: does not go round the mouth once"),
    ({"closing.docking.docking_distance_m": 5.0, "net.square.mesh_m": 0.4},
     r"docking_distance_m = 5\.0: neighbours in the ring are 4\.4 m apart in the open net; allowed: less than 4\.4 m"),
    ({"closing": {"winches": {}}}, r"closing\.winches: unknown way \(did you mean winch\?\)"),
    ({"closing": "docking"}, r"closing = 'docking': not a way to close; allowed: none, \{docking"),
    ({"units": [], "launch": {"ejected": {"bodies": [0], "speed_m_s": 1, "opening_angle_deg": 9}}},
     r"closing\.docking: 0 units cannot close a mouth"),
    ({"capture.required_locked_pairs": 9}, r"capture\.required_locked_pairs = 9: only 8 pairs can lock"),
    # Launch and aiming
    ({"units": [], "closing": "none", "aiming": None, "capture": None}, r"launch = 'flown': there is no unit"),
    ({"launch": "thrown"}, r"launch = 'thrown': no way to launch; allowed: flown"),
    ({"launch": {"ejected": {"speed_m_s": 3.0}}}, r"launch\.ejected: lacks speed_m_s or opening_angle_deg"),
    ({"launch": {"ejected": {"velocities_m_s": [[0, 0, 1]]}}}, r"velocities_m_s = .*: not a velocity for each body"),
    ({"aiming.offsets_m": [[1, 2]]}, r"aiming\.offsets_m = .*: not one for each unit; allowed: 8 offsets"),
    # Debris
    ({"debris.mass_kg": 0}, r"debris\.mass_kg = 0: out of range"),
    ({"debris.shape": {"kind": "cylindre"}}, r"debris\.shape\.kind = 'cylindre': unknown; allowed: one of box"),
    ({"debris.shape.radius_m": -1.0}, r"debris\.shape\.radius_m = -1\.0: out of range"),
    ({"debris.shape.radius": 1.0}, r"debris\.shape: a cylinder has no entry 'radius'"),
    ({"debris.inertia_kg_m2": [1.0, 1.0, 3.0]}, r"inertia_kg_m2 = .*: no body has the principal moments 1, 1 and 3"),
    ({"debris.inertia_kg_m2": [1.0, 1.0, 0.0]}, r"debris\.inertia_kg_m2 = .*: has a principal moment of 0"),
    ({"debris.inertia_kg_m2": [[1, 2, 0], [0, 1, 0], [0, 0, 1]]}, r"debris\.inertia_kg_m2 = .*: not symmetric"),
    ({"debris.center_of_mass_m": [0, 0, 1]}, r"debris\.inertia_kg_m2: is missing: a body with a centre"),
]
# fmt: on


@pytest.mark.parametrize(
    ("overrides", "message"), CASES, ids=[next(iter(case[0])) + f"-{i}" for i, case in enumerate(CASES)]
)
def test_error_names_entry_and_what_is_allowed(overrides, message):
    with pytest.raises(DescriptionError, match=message) as raised:
        load_system("zenit_8mu", overrides)
    text = str(raised.value)
    assert "allowed: " in text or "it has: " in text
    assert "\n" not in text
    assert text.startswith("system zenit_8mu: ")


def test_winch_ring_needs_somewhere_to_have_winches():
    with pytest.raises(DescriptionError, match=r"closing\.winch\.winches: no node of the ring bears a unit or a mass"):
        load_system("zenit_4mu", {"closing.winch.ring": [24, 44, 504, 484]})
    with pytest.raises(DescriptionError, match=r"closing\.winch\.winches\[0\] = 0: node 0 is not in the ring"):
        load_system("zenit_4mu", {"closing.winch.ring": [24, 44, 504, 484], "closing.winch.winches": [0]})


def test_it_is_an_error_of_parameters():
    assert issubclass(DescriptionError, ParameterError)


def test_unknown_system_names_those_there_are():
    with pytest.raises(
        DescriptionError, match=r"no system 'zenit_8nu' \(did you mean zenit_8mu\?\); allowed: envisat_8mu"
    ):
        load_system("zenit_8nu")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("net: [", "own is not YAML"),
        ("", "own holds nothing; allowed: a mapping"),
        ("- net", "own holds list"),
        ("net: &a {}\ncloses: *a", "aliases are not allowed"),
        ("net: {}\nnet: {}", "net is given twice"),
        ("net: " + "[" * 50, "nested in more than"),
        ("net: !!python/object:os.system {}", "own is not YAML"),
        ("based_on: 3", r"based_on = 3: not a name"),
        ("based_on: nothing.yaml", r"based_on = 'nothing.yaml': no such system"),
        ("name: own", r"system own: net: is missing"),
    ],
)
def test_text_that_is_no_description(text, message):
    with pytest.raises(DescriptionError, match=message):
        system_from_text(text, source="own")


def test_descriptions_that_are_based_on_each_other(tmp_path):
    (tmp_path / "one.yaml").write_text("based_on: two.yaml\n")
    (tmp_path / "two.yaml").write_text("based_on: one.yaml\n")
    with pytest.raises(
        DescriptionError, match=r"based_on = .*: leads round in a circle: one\.yaml -> two\.yaml -> one\.yaml"
    ):
        load_system(tmp_path / "one.yaml")


def test_files_that_hold_no_net(tmp_path):
    (tmp_path / "text.npz").write_text("no archive")
    np.savez(tmp_path / "half.npz", nodes=np.zeros((3, 2)))
    np.savez(tmp_path / "odd.npz", nodes=np.zeros((3, 5)), threads=np.zeros((2, 2), int))
    for name, message in (
        ("text.npz", r"net\.file\.path = .*: not an npz file"),
        ("half.npz", r"net\.file\.path = .*: has no array threads"),
        ("odd.npz", r"net\.file: has shape \(3, 5\)|net\.file\.path: has shape \(3, 5\)"),
    ):
        with pytest.raises(DescriptionError, match=message):
            load_system("zenit_8mu", {"net.file": {"path": str(tmp_path / name)}})
