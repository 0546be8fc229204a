"""Which shapes there are, found by their files, and how a description becomes one."""

from __future__ import annotations

import functools
import importlib
import inspect
import pkgutil
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from .shape import Shape, ShapeError, entry_error


@functools.cache
def shape_kinds() -> Mapping[str, type[Shape]]:
    """Every shape by its kind, in the order of the kinds' names."""
    package = importlib.import_module(__package__)
    found: dict[str, type[Shape]] = {}
    for module_info in pkgutil.iter_modules(package.__path__):
        module = importlib.import_module(f"{__package__}.{module_info.name}")
        for _, cls in inspect.getmembers(module, inspect.isclass):
            if cls.__module__ == module.__name__ and issubclass(cls, Shape) and not inspect.isabstract(cls):
                found[cls.kind] = cls
    return MappingProxyType(dict(sorted(found.items())))


@functools.cache
def surface_functions() -> Mapping[str, Callable[..., tuple[Any, Any, Any, Any]]]:
    """``surface`` of every kind that has a distance function of its own, in the order of the kinds' names."""
    modules = {kind: importlib.import_module(cls.__module__) for kind, cls in shape_kinds().items()}
    return MappingProxyType({k: m.surface for k, m in modules.items() if hasattr(m, "surface")})


def shape_from(entries: Mapping[str, Any], *, folder: Path | None = None, where: str = "shape") -> Shape:
    """Make a shape from its description.

    Args:
        entries: ``kind`` and what that kind has, for instance ``{"kind": "box", "size_m": [1, 2, 3]}``.
        folder: where files that it names are, if their names are relative; None: the working directory.
        where: the name of the description's place, for errors.

    Raises:
        ShapeError: naming the entry, what it holds and what is allowed.
    """
    kinds = ", ".join(shape_kinds())
    if not isinstance(entries, Mapping):
        raise entry_error(where, entries, "no description of a shape", f"kind, one of {kinds}, and what it has")
    if "kind" not in entries:
        raise ShapeError(f"{where} lacks kind; allowed: one of {kinds}")
    kind = entries["kind"]
    if not isinstance(kind, str) or kind not in shape_kinds():
        raise entry_error(f"{where}.kind", kind, "unknown", f"one of {kinds}")
    try:
        return shape_kinds()[kind].from_entries({k: v for k, v in entries.items() if k != "kind"}, folder)
    except ShapeError as error:
        text = str(error)
        raise ShapeError(f"{where}: {text}" if text.startswith("a ") else f"{where}.{text}") from error
