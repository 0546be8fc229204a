"""What decides how a shipped model does, in one number: the code and the default parameters of flights."""

from __future__ import annotations

import ast
import functools
import importlib.util
import json
from collections.abc import Iterator
from pathlib import Path

from tethernet_core.parameters import defaults
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_learning.source_digest import digest
from tethernet_sim.settings import PhysicsParameters, ScenarioParameters

ROOTS = (
    "tethernet_sim.fly",
    "tethernet_planner.inference.policy_file",
    "tethernet_planner.inference.surrogate_file",
    "tethernet_learning.data.trigger",
)
"""Modules that fly a mission, aim and predict; counted with all that they import of this project."""

LEFT_OUT = (
    "tethernet_core.parameters",
    "tethernet_core.atomic_file",
    "tethernet_planner.inference.model_file",
)
"""Modules that read and write files: the values of parameters and the model itself count instead."""

_ANNOTATIONS = ("annotation", "returns")

_PARAMETERS = (PhysicsParameters, ControlParameters, MissionParameters, ScenarioParameters)
_PACKAGES = ("tethernet_core", "tethernet_control", "tethernet_planner", "tethernet_sim", "tethernet_learning")


@functools.cache
def flight_digest() -> str:
    """Short hash of the code that flies, aims and predicts, and of the default parameters of flights and scenario.

    Comments, docstrings, annotations, layout and texts for people do not count.
    """
    parts = [f"{name}\n{meaning(_file(name).read_text(encoding='utf-8'))}".encode() for name in modules()]
    values = {kind.__name__: defaults(kind) for kind in _PARAMETERS}
    return digest([*parts, json.dumps(values, sort_keys=True).encode()])[:16]


@functools.cache
def modules() -> tuple[str, ...]:
    """Names of all modules that count, sorted."""
    found, waiting = set(), list(ROOTS)
    while waiting:
        name = waiting.pop()
        if name not in found and name not in LEFT_OUT:
            found.add(name)
            waiting += _imported(name)
    return tuple(sorted(found))


def meaning(source: str) -> str:
    """What a module's source does, as text: its syntax tree without comments, docstrings and prose."""
    return "\n".join(_described(ast.parse(source)))


def _described(node: object) -> Iterator[str]:
    """A tree, one line for each part; empty fields are left out, because Python versions differ in them."""
    if isinstance(node, ast.AST):
        yield type(node).__name__
        for name, content in ast.iter_fields(node):
            value = [item for item in content if not _is_text(item)] if isinstance(content, list) else content
            if value is not None and value != [] and name not in _ANNOTATIONS:
                yield f".{name}"
                yield from _described(value)
    elif isinstance(node, list):
        for item in node:
            yield from _described(item)
        yield "]"
    else:
        prose = isinstance(node, str) and " " in node
        yield "prose" if prose else repr(node)


def _is_text(statement: object) -> bool:
    """Whether it is a docstring or a text beside a field."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )


def _imported(name: str) -> list[str]:
    """Modules of this project that a module imports, anywhere in it."""
    file = _file(name)
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    candidates: list[str] = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            candidates += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - (node.level - 1)] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            candidates += [base, *(f"{base}.{alias.name}" for alias in node.names)]
    ours = (candidate for candidate in candidates if candidate.partition(".")[0] in _PACKAGES)
    return [candidate for candidate in ours if _find(candidate) is not None]


def _file(name: str) -> Path:
    file = _find(name)
    if file is None:
        raise ModuleNotFoundError(f"no module {name}")
    return file


@functools.cache
def _find(name: str) -> Path | None:
    package, *rest = name.split(".")
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        return None
    place = Path(spec.submodule_search_locations[0]).joinpath(*rest)
    for file in (place / "__init__.py", place.with_name(place.name + ".py")):
        if file.is_file():
            return file
    return None
