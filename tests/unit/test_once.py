"""Rules that stood in several places once, and then differed: each has one place now."""

import ast
import re
from collections.abc import Callable, Iterator

import pytest

from bootstrap.places import ROOT

PACKAGES = ROOT / "ros2_ws" / "src"
SOURCES = sorted(
    path
    for folder in (PACKAGES, ROOT / "bootstrap", ROOT / "benchmarks", ROOT / "examples")
    for path in folder.rglob("*.py")
)


def renames(tree: ast.Module, _text: str) -> Iterator[int]:
    """A file that takes another's place: ``os.replace``, or ``replace`` and ``rename`` of something with one place to
    go (a text's ``replace`` has two arguments, that of a dataclass names fields).
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and not node.keywords:
            words, moves = ast.unparse(node.func), node.func.attr in ("replace", "rename")
            whole = words in ("os.replace", "os.rename", "shutil.move")
            if whole or (moves and len(node.args) == 1 and "dataclasses" not in words):
                yield node.lineno


def thresholds(tree: ast.Module, _text: str) -> Iterator[int]:
    """A comparison with the CQI or the number of pairs that a capture needs."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            names = {part.attr for part in ast.walk(node) if isinstance(part, ast.Attribute)}
            if names & {"cqi_threshold", "required_locked_pairs"}:
                yield node.lineno


def fallbacks(tree: ast.Module, _text: str) -> Iterator[int]:
    """The name of the nominal points where they stand in for a policy."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node.value == "nominal (fallback)":
            yield node.lineno


PRODUCT = re.compile(r"2(?:\.0)? \* \(\w+ \* \w+ [-+] \w+ \* \w+\)")


def rotations(_tree: ast.Module, text: str) -> Iterator[int]:
    """Twice the sum of two products: what rotation by a quaternion is made of."""
    for number, line in enumerate(text.splitlines(), 1):
        if PRODUCT.search(line):
            yield number


def unit_norms(_tree: ast.Module, text: str) -> Iterator[int]:
    """How far from 1 a norm may be."""
    for number, line in enumerate(text.splitlines(), 1):
        if re.search(r"abs\(norm - 1\.0\) *[<>]", line):
            yield number


CORE = "ros2_ws/src/tethernet_core/tethernet_core"
PLACES: dict[Callable[[ast.Module, str], Iterator[int]], dict[str, str]] = {
    renames: {
        f"{CORE}/atomic_file.py": "the rule",
        "bootstrap/state.py": "the set-up has the standard library only",
        "bootstrap/environment.py": "the set-up; a folder goes",
        "bootstrap/ros2cli.py": "the set-up; a folder comes whole",
        "ros2_ws/src/tethernet_learning/tethernet_learning/policies/checkpoint.py": "a folder, whose files come first",
    },
    thresholds: {
        f"{CORE}/capture_quality.py": "the rule",
        "ros2_ws/src/tethernet_bringup/tethernet_bringup/mission/outcome_text.py": "DOCKED, where no net is measured",
    },
    fallbacks: {f"{CORE}/aiming.py": "the name"},
    rotations: {f"{CORE}/rotation.py": "the rule"},
    unit_norms: {
        f"{CORE}/unit_norm.py": "of what a person gives",
        f"{CORE}/rotation.py": "of messages, which rounding has been through",
    },
}
"""Where each may be, and why."""


@pytest.mark.parametrize("rule", PLACES, ids=lambda rule: rule.__name__)
def test_a_rule_has_one_place(rule):
    found = {}
    for path in SOURCES:
        text = path.read_text()
        if lines := list(rule(ast.parse(text), text)):
            found[str(path.relative_to(ROOT))] = lines
    assert found.keys() == PLACES[rule].keys(), found
