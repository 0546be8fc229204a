"""What a campaign's outcomes depend on, so that a file is only ever continued by the same campaign."""

from __future__ import annotations

import importlib.metadata
import json
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from tethernet_core.shown import SHORT, shown
from tethernet_core.system import System
from tethernet_learning.campaigns.cases import Case, most_units
from tethernet_learning.campaigns.flown_systems import descriptions
from tethernet_learning.source_digest import digest, source_digest
from tethernet_sim.fly import Settings

FORMAT = 2
"""2: systems by name and description; 1 knew them by their number of units."""
SHOWN_DIFFERENCES = 8


def describe(source: Mapping[str, Any], cases: Sequence[Case], settings: Mapping[System, Settings]) -> dict[str, Any]:
    """Describe a campaign, ready for JSON.

    Args:
        source: the options that made the scenarios.
        cases: all of them.
        settings: parameters of the flights, by system.
    """
    description = {
        "format": FORMAT,
        "source": dict(source),
        "scenarios": len(cases),
        "scenarios_sha256": digest(_text_of(case).encode() for case in cases),
        "units": most_units(cases),
        "systems": descriptions(list(settings)),
        "system_digests": {system.name: system.digest for system in settings},
        "settings": {system.name: asdict(one) for system, one in settings.items()},
        "code_sha256": source_digest(),
        "versions": {
            "python": ".".join(platform.python_version_tuple()[:2]),
            **{name: importlib.metadata.version(name) for name in ("numpy", "numba")},
        },
    }
    return json.loads(json.dumps(description))  # tuples become lists, as after reading


def _text_of(case: Case) -> str:
    return repr((case.scenario.record(), case.group, case.policy, case.error))


def differences(made_by: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Where two descriptions differ, one line each; empty when they do not.

    Args:
        made_by: of the campaign that made a file.
        now: of the one at hand.
    """
    before, after = dict(_leaves(made_by)), dict(_leaves(now))
    changed = [key for key in {**before, **after} if before.get(key) != after.get(key)]
    lines = [f"{key}: {_text(key, before)} in the file, {_text(key, after)} now" for key in changed]
    more = len(lines) - SHOWN_DIFFERENCES
    return [*lines[:SHOWN_DIFFERENCES], f"and {more} more"] if more > 0 else lines


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(item, f"{path}.{key}" if path else key)
    else:
        yield path, value


def _text(key: str, values: Mapping[str, Any]) -> str:
    value = values.get(key, "nothing")
    return str(value)[:12] if key.endswith("sha256") else shown(value, SHORT)  # a whole description among them
