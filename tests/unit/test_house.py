"""What may import what: layers go one way, nothing goes round, and a real mission's processes hold no simulator.

All imports count: at a module's head, inside functions, and those for type annotations only. An import inside a
function still ties two modules together, and what only the type checker reads still has to be understood together.
"""

from __future__ import annotations

import ast
import functools
import json
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import pytest

from bootstrap.places import PYTHON_PACKAGES, ROOT

SOURCES = ROOT / "ros2_ws" / "src"

LAYERS = (
    "tethernet_msgs", "tethernet_core", "tethernet_ros", "tethernet_control", "tethernet_planner", "tethernet_sim",
    "tethernet_learning", "tethernet_bringup",
)  # fmt: skip
"""Each may import the ones before it."""

NEVER = {
    "tethernet_core": {"rclpy", "numba", *LAYERS} - {"tethernet_core"},
    "tethernet_planner": {"tethernet_sim", "tethernet_learning", "torch", "sklearn"},
    "tethernet_control": {"tethernet_sim", "tethernet_planner", "tethernet_learning", "torch", "sklearn"},
}

REAL_MISSION = {
    "tethernet_planner.assessor_node": {"tethernet_sim", "tethernet_learning", "torch", "sklearn", "ray"},
    "tethernet_planner.planner_node": {"tethernet_sim", "tethernet_learning", "torch", "sklearn", "ray"},
    "tethernet_control.controller_node": {"tethernet_sim", "tethernet_planner", "tethernet_learning", "torch"},
}
"""Processes that fly with real hardware, and what they must not load."""

MOST_LINES = 400
LONGER: dict[str, str] = {}
"""Files that are longer, each with its reason."""

KNOWN_FILE_CIRCLES: dict[tuple[str, ...], str] = {}
KNOWN_FOLDER_CIRCLES: dict[tuple[str, ...], str] = {
    ("tethernet_core", "tethernet_core.shapes", "tethernet_core.system"): (
        "descriptions need parameters, and capture quality needs descriptions"
    ),
}
"""What remains to be undone. An entry that no longer holds fails the test, so that the list only shrinks."""

Graph = Mapping[str, set[str]]


@functools.cache
def modules() -> dict[str, Path]:
    """All modules of all packages with their files."""
    found = {}
    for package in PYTHON_PACKAGES:
        for path in sorted((SOURCES / package / package).rglob("*.py")):
            words = path.relative_to(SOURCES / package).with_suffix("").parts
            found[".".join(words[:-1] if words[-1] == "__init__" else words)] = path
    return found


def imports(name: str, path: Path, known: Iterable[str]) -> Iterator[str]:
    """Full names of all that a module imports: modules of ``known`` as far down as named, others as written.

    Of ``import a.b.c`` the packages a and a.b are no imports of their own, although Python loads them first.
    """
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*parents, *([node.module] if node.module else [])])
            yield from (f"{base}.{alias.name}" if f"{base}.{alias.name}" in known else base for alias in node.names)


@functools.cache
def everything() -> dict[str, set[str]]:
    """What each module imports, from anywhere."""
    known = modules()
    return {name: set(imports(name, path, known)) - {name} for name, path in known.items()}


def own_graph() -> dict[str, set[str]]:
    """The imports between own modules."""
    return {name: found & set(modules()) for name, found in everything().items()}


def circles(graph: Graph) -> list[tuple[str, ...]]:
    """The sets of nodes each of which leads to all the others (Tarjan's strongly connected components)."""
    number: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        number[node] = lowest[node] = len(number)
        stack.append(node)
        for other in graph.get(node, ()):
            if other not in number:
                visit(other)
                lowest[node] = min(lowest[node], lowest[other])
            elif other in stack:
                lowest[node] = min(lowest[node], number[other])
        if lowest[node] == number[node]:
            begin = stack.index(node)
            if len(stack) - begin > 1:
                found.append(tuple(sorted(stack[begin:])))
            del stack[begin:]

    for node in graph:
        if node not in number:
            visit(node)
    return sorted(found)


def folder_circles(graph: Graph, packages: Iterable[str]) -> list[tuple[str, ...]]:
    """Circles between the sub-packages of each package; its own modules count as one more, named as the package."""
    found = []
    for package in packages:
        inside = [name for name in graph if name == package or name.startswith(package + ".")]

        def room(name: str, package: str = package) -> str:
            child = ".".join(name.split(".")[: package.count(".") + 2])
            return child if modules().get(child, Path()).name == "__init__.py" else package

        rooms: dict[str, set[str]] = {}
        for name in inside:
            targets = {room(other) for other in graph[name] if other in inside}
            rooms.setdefault(room(name), set()).update(targets - {room(name)})
        found += circles(rooms)
    return found


def reachable(begin: str) -> set[str]:
    """What a process that starts with this module may ever load: its imports, theirs and so on."""
    seen, to_do = {begin}, [begin]
    while to_do:
        for name in everything().get(to_do.pop(), ()):
            if name not in seen:
                seen.add(name)
                to_do.append(name)
    return seen


def roots(names: Iterable[str]) -> set[str]:
    return {name.partition(".")[0] for name in names}


def test_circles_are_found():
    graph = {"a": {"b"}, "b": {"c", "d"}, "c": {"a"}, "d": {"e"}, "e": {"d"}, "f": {"a"}}
    assert circles(graph) == [("a", "b", "c"), ("d", "e")]
    assert circles({"a": {"b"}, "b": {"c"}, "c": set()}) == []


def test_no_circle_between_files():
    assert circles(own_graph()) == sorted(KNOWN_FILE_CIRCLES)


def test_no_circle_between_sub_packages():
    packages = [name for name, path in modules().items() if path.name == "__init__.py"]
    assert folder_circles(own_graph(), packages) == sorted(KNOWN_FOLDER_CIRCLES)


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_packages_import_only_those_below(package):
    above = set(LAYERS[LAYERS.index(package) + 1 :])
    wrong = {name: roots(found) & above for name, found in everything().items() if name.split(".")[0] == package}
    assert {name: found for name, found in wrong.items() if found} == {}


@pytest.mark.parametrize("package", NEVER)
def test_what_a_package_never_imports(package):
    inside = [name for name in modules() if name.partition(".")[0] == package]
    wrong = {name: roots(reachable(name)) & NEVER[package] for name in inside}
    assert {name: found for name, found in wrong.items() if found} == {}


def test_the_core_knows_no_message():
    names = roots(
        name for module, found in everything().items() if module.startswith("tethernet_core") for name in found
    )
    assert {name for name in names if name.endswith(("_msgs", "_interfaces")) or name.startswith("rosidl")} == set()


@pytest.mark.parametrize("node", REAL_MISSION)
def test_a_real_mission_holds_no_simulator_and_no_training(node):
    code = f"import json, sys, {node}; print(json.dumps(sorted(sys.modules)))"
    command = [sys.executable, "-P", "-c", code]
    loaded = json.loads(subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout)
    assert node in loaded
    assert roots(loaded) & REAL_MISSION[node] == set()
    assert roots(reachable(node)) & REAL_MISSION[node] == set(), "nor later"


def test_files_are_short():
    folders = [SOURCES, *(ROOT / name for name in ("bootstrap", "benchmarks", "examples", "tests"))]
    files = [path for folder in folders for path in folder.rglob("*.py")]
    lines = {str(path.relative_to(ROOT)): path.read_text().count("\n") for path in files}
    assert {name: count for name, count in lines.items() if count > MOST_LINES and name not in LONGER} == {}
    assert {name for name in LONGER if lines.get(name, 0) <= MOST_LINES} == set(), "needs no reason any more"


NAMED_FILE = re.compile(r"`((?:[\w-]+/)*\w+\.py)`")
NAMED_CLASS = re.compile(r"`(\w+Parameters)`")
TABLE_OF_MODULES = re.compile(r"^\| module \|.*\n\|[-|]+\n((?:\|.*\n)+)", re.MULTILINE)


def documents() -> list[Path]:
    """The README, those of the packages, and the pages of the documentation."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted(SOURCES.glob("*/README.md"))]


def test_files_and_parameters_that_documents_name_are_there():
    own = ("bootstrap", "benchmarks", "examples", "docs", "tests")
    folders = [*SOURCES.glob("*/*"), *(ROOT / name for name in own)]
    files = {f"/{path.relative_to(ROOT)}" for folder in folders for path in folder.rglob("*.py")}
    files |= {f"/{path.name}" for path in ROOT.glob("*.py")}
    classes = set(re.findall(r"^class (\w+Parameters)\b", "".join(p.read_text() for p in modules().values()), re.M))
    wrong = set()
    for document in documents():
        text = document.read_text(encoding="utf-8")
        wrong |= {(document.parent.name, name) for name in set(NAMED_CLASS.findall(text)) - classes}
        for name in NAMED_FILE.findall(text):
            if not any(path.endswith(f"/{name}") for path in files):
                wrong.add((document.parent.name, name))
    assert wrong == set()


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_a_package_lists_modules_of_its_own(package):
    tables = TABLE_OF_MODULES.findall((SOURCES / package / "README.md").read_text(encoding="utf-8"))
    cells = [row.split("|")[1] for table in tables for row in table.splitlines()]
    listed = [name for cell in cells for name in re.findall("`([^`]+)`", cell)]
    assert [name for name in listed if not (SOURCES / package / package / name).exists()] == []


STARTED = re.compile(r"-m[\s\"',]+(tethernet_\w+(?:\.\w+)*)")


def test_what_is_named_to_be_started_can_be_started():
    """Documents, scripts and the sources themselves name no module after ``-m`` that is no program (any more)."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("these sources are not in a git repository")
    wrong = set()
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if path.suffix in (".py", ".md", ".yaml", ".toml", ".Dockerfile", "") and path.is_file():
            for module in STARTED.findall(path.read_text(errors="replace")):
                main = modules().get(f"{module}.__main__") or modules().get(module)
                if main is None or (main.name != "__main__.py" and '__name__ == "__main__"' not in main.read_text()):
                    wrong.add((name, module))
    assert wrong == set()
