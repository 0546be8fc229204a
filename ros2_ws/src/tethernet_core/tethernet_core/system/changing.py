"""A system with some entries of its description replaced."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .errors import Place
from .loading import system_from_text
from .merging import overridden
from .system import System
from .writing import description_text


def changed(system: System, overrides: Mapping[str, Any]) -> System:
    """A system with some entries of its description replaced; its name stays, its digest does not.

    Args:
        system: any.
        overrides: as of :func:`.loading.load_system`: nested mappings, or dotted keys such as ``net.square.mesh_m``.

    Raises:
        DescriptionError: which entry, what it holds and what is allowed.
    """
    if not overrides:
        return system
    content = overridden(system.content, overrides, Place(system.name))
    return system_from_text(description_text(content), source=system.name)
