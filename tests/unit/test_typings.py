"""The types of the messages that the type checker reads are those of the messages."""

from __future__ import annotations

import importlib
import re
import typing

import pytest

from bootstrap.places import PYTHON_PACKAGES, ROOT

pytest.importorskip("rosidl_adapter")  # comes with what builds messages

from typings.make_stubs import STUBS, stubs


def test_stubs_are_up_to_date():
    written = {path.relative_to(STUBS): path.read_text() for path in STUBS.rglob("*.pyi")}
    assert written == stubs(), "make stubs"


def test_stubs_name_the_fields_and_constants_of_the_classes():
    checked = 0
    for path, text in stubs().items():
        if path.parent.name not in ("msg", "srv"):
            continue
        module = importlib.import_module(".".join(path.parent.parts))
        for block in text.split("\nclass ")[1:]:
            name = block.partition(":")[0]
            cls = getattr(module, name)
            lines = [line.strip() for line in block.splitlines()[1:]]
            for line in lines:
                if ": ClassVar[" in line or ": TypeAlias" in line:
                    assert hasattr(cls, line.partition(":")[0]), f"{path}: {name}.{line}"
            if hasattr(cls, "get_fields_and_field_types"):
                arguments = [line.partition(":")[0] for line in lines if line.endswith("= ...,")]
                assert arguments == list(cls.get_fields_and_field_types()), f"{path}: {name}"
                checked += 1
    assert checked > 40


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_packages_say_that_they_have_types(package):
    folder = ROOT / "ros2_ws" / "src" / package
    assert (folder / package / "py.typed").exists()
    assert '"py.typed"' in (folder / "setup.py").read_text(), "installed too"


def test_whatever_the_type_checker_is_told_to_ignore_has_its_reason_beside_it():
    folders = [ROOT / name for name in ("ros2_ws/src", "bootstrap", "benchmarks", "examples", "typings")]
    wrong = []
    for path in (path for folder in folders for path in folder.rglob("*.py")):
        for number, line in enumerate(path.read_text().splitlines(), start=1):
            if "# type: ignore" in line and not re.search(r"# type: ignore\[[a-z, -]+\]  # \w", line):
                wrong.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()}")
    assert wrong == []


def test_numbers_read_and_write_as_rosidl_stores_them():
    """What the stubs say of arrays, tried out on the real classes."""
    from nav_msgs.msg import Odometry

    from tethernet_msgs.msg import NetState

    state = NetState(knot_positions=(1.0, 2.0, 3.0))
    assert type(state.knot_positions).__name__ == "array"
    assert type(Odometry().pose.covariance).__name__ == "ndarray"
    assert typing.get_type_hints(NetState) == {}, "the classes themselves have no annotations: hence the stubs"
