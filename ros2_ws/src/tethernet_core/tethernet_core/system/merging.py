"""One description changed by another: ``based_on`` and overrides."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from typing import Any

from .described_closing import CLOSING_KINDS
from .described_net import NET_KINDS
from .errors import Place

_ONE_OF: dict[tuple[str, ...], tuple[str, ...]] = {("net",): NET_KINDS, ("closing",): CLOSING_KINDS}
"""Sections of which exactly one may be there: giving another one replaces the first."""


def merged(base: Any, changes: Any, path: tuple[str, ...] = ()) -> Any:
    """``base`` with ``changes``: mappings are merged entry by entry, anything else is replaced.

    A net of another kind, another way to close and a shape of another kind replace what was there.
    """
    if not isinstance(base, Mapping) or not isinstance(changes, Mapping):
        return copy.deepcopy(changes)
    if path == ("debris", "shape") and base.get("kind") != changes.get("kind", base.get("kind")):
        return copy.deepcopy(dict(changes))
    result = dict(base)
    one_of = _ONE_OF.get(path, ())
    if any(key in one_of and value is not None for key, value in changes.items()):
        result = {key: value for key, value in result.items() if key not in one_of or key in changes}
    for key, value in changes.items():
        here = (*path, str(key))
        result[key] = merged(result[key], value, here) if key in result else copy.deepcopy(value)
    return result


_KEY = re.compile(r"^[A-Za-z_]\w*(\[\d+\]|\.\d+)*(\.[A-Za-z_]\w*(\[\d+\]|\.\d+)*)*$")


def overridden(content: Mapping[str, Any], overrides: Mapping[str, Any], place: Place) -> dict[str, Any]:
    """A description with some of its entries replaced.

    Args:
        content: the description.
        overrides: nested mappings, or dotted keys: ``net.square.mesh_m``, ``units[3].thread_length_m``.
        place: for errors.

    Raises:
        DescriptionError: for a key that leads nowhere.
    """
    result: dict[str, Any] = copy.deepcopy(dict(content))
    for key, value in overrides.items():
        if not isinstance(key, str) or not _KEY.match(key):
            raise place.error(key, "no entry's path", "a dotted path such as net.square.mesh_m or units[3].mass_kg")
        steps = [int(step) if step.isdigit() else step for step in re.findall(r"[^.\[\]]+", key)]
        if any(isinstance(step, int) for step in steps):
            _set_in_list(result, steps, value, place)
            continue
        nested: Any = value
        for step in reversed(steps):
            nested = {step: nested}
        result = merged(result, nested)
    return result


def _set_in_list(content: Any, steps: list[Any], value: Any, place: Place) -> None:
    """Set an entry on a way that leads through lists."""
    for i, step in enumerate(steps):
        here = place[step] if isinstance(step, int) else place / step
        last = i == len(steps) - 1
        if isinstance(step, int):
            if not isinstance(content, list):
                raise here.problem("is no element: there is no list", "an entry that the description has")
            if step >= len(content):
                raise here.problem(
                    "is no element", f"elements 0 to {len(content) - 1}" if content else "none: the list is empty"
                )
        elif not isinstance(content, dict) or (not last and step not in content):
            raise here.problem("is no entry of this description", "an entry that the description has")
        if last:
            content[step] = value
        else:
            content, place = content[step], here
