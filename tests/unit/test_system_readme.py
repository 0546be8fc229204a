"""The README's section on descriptions: its example flies through the checks, its table is that of the code."""

import re
from pathlib import Path

import pytest

from tethernet_core.system import shipped_systems, system_from_text
from tethernet_core.system.reference import entries_table

README = Path(__file__).parents[2] / "ros2_ws/src/tethernet_core/README.md"


def test_table_of_entries_is_that_of_the_code():
    assert entries_table() in README.read_text(), "put the output of entries_table() into the README"


def test_example_is_a_system():
    (text,) = re.findall(r"```yaml\n(.*?)```", README.read_text(), re.DOTALL)
    system = system_from_text(text, source="box_6mu")
    assert system.name == "box_6mu"
    assert system.unit_count == 6
    assert system.net.mesh_m == 1.5
    assert system.debris.shape.kind == "box"
    assert system.debris.cqi_length_m == pytest.approx(1.5)
    assert {unit.mass_kg for unit in system.units} == {3.0}


def test_all_shipped_systems_are_listed():
    text = README.read_text()
    for name in shipped_systems():
        assert f"| `{name}` |" in text
