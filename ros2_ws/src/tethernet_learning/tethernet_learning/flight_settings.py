"""Parameters of flights as words of a command line: ``physics.mesh_m=1``."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from tethernet_core.parameters import ParameterError
from tethernet_sim.fly import Settings

HELP = "parameters to replace, PART is physics, control, mission or quality: control.kp=12"
METAVAR = "PART.NAME=VALUE"


def settings_of(words: Sequence[str], printed: bool = False) -> Settings:
    """The default parameters, with some replaced.

    Args:
        words: each PART.NAME=VALUE.
        printed: begin with the paper's control as printed.

    Raises:
        ParameterError: for a word of another form, an unknown name, a wrong type or a value out of range.
    """
    import yaml

    parts = list(Settings.__dataclass_fields__)
    overrides: dict[str, dict[str, Any]] = {}
    for word in words:
        name, equals, value = word.partition("=")
        part, dot, key = name.partition(".")
        if not (equals and dot and part in parts):
            raise ParameterError(f"--set {word}: allowed: {METAVAR} with PART one of {', '.join(parts)}")
        try:
            overrides.setdefault(part, {})[key] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            raise ParameterError(f"--set {word}: {value!r} is no value: {error}") from error
    return Settings.paper(**overrides) if printed else Settings.load(**overrides)


def settings_fingerprint(settings: Settings) -> str:
    """Short hash of all parameters of the flights."""
    text = json.dumps(asdict(settings), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
