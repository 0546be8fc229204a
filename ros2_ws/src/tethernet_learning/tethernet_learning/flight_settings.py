"""Parameters of flights as words of a command line: ``control.kp=4``."""

from __future__ import annotations

import argparse
import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from tethernet_core.parameters import ParameterError
from tethernet_core.system import System
from tethernet_planner import policies
from tethernet_sim.fly import Settings

HELP = "parameters to replace, PART is physics, control or mission: control.kp=12"
METAVAR = "PART.NAME=VALUE"


def add_flight(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how scenarios are flown: ``policy``, ``control`` and ``set``."""
    add = parser.add_argument
    add("--policy", default=policies.default(), metavar="POLICY", help=f"what aims: {policies.HELP}")
    add("--control", choices=("default", "paper"), default="default", help="paper: its law as printed")
    add_parameters(parser)


def add_parameters(parser: argparse.ArgumentParser, more: str = "") -> None:
    """Add the option ``set``.

    Args:
        parser: gets it.
        more: to be said in its help.
    """
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar=METAVAR, help=HELP + more)


def settings_of(words: Sequence[str], printed: bool = False, system: System | None = None) -> Settings:
    """The default parameters, with some replaced.

    Args:
        words: each PART.NAME=VALUE.
        printed: begin with the paper's control as printed.
        system: that is flown; None: the default one.

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
    return Settings.paper(system, **overrides) if printed else Settings.load(system, **overrides)


def settings_fingerprint(settings: Settings) -> str:
    """Short hash of all parameters of the flights."""
    text = json.dumps(asdict(settings), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
