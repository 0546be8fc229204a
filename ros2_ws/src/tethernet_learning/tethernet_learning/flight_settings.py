"""Parameters of flights as words of a command line: ``control.kp=4``."""

from __future__ import annotations

import argparse
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tethernet_core.parameters import ParameterError
from tethernet_core.settings import HARDEST_TOW_N, LONGEST_HOLD_S
from tethernet_core.subcommand import number
from tethernet_core.system import System
from tethernet_core.system.changing import changed
from tethernet_planner import policies
from tethernet_sim.fly import Settings

HELP = (
    "parameters to replace, PART is physics, control or mission: control.kp=12; or entries of the description: "
    "system.net.thread.damping_ratio=0.05"
)
SYSTEM = "system"
"""The part whose names are entries of a description."""
METAVAR = "PART.NAME=VALUE"


def add_flight(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how scenarios are flown: ``policy``, ``control`` and ``set``."""
    add = parser.add_argument
    add("--policy", metavar="POLICY", help=f"what aims: {policies.HELP}")
    add("--control", choices=("default", "paper"), default="default", help="paper: its law as printed")
    add_parameters(parser)


def add_parameters(parser: argparse.ArgumentParser, more: str = "") -> None:
    """Add the option ``set``, and those of the hold test.

    Args:
        parser: gets it.
        more: to be said in its help.
    """
    add_set(parser, more)
    add_hold(parser)


def add_set(parser: argparse.ArgumentParser, more: str = "") -> None:
    """Add the option ``set`` alone; arguments as of :func:`add_parameters`."""
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar=METAVAR, help=HELP + more)


def add_hold(parser: argparse.ArgumentParser) -> None:
    """Add the options of the hold test: ``hold`` and ``tow``, None where they are not given."""
    parser.add_argument(
        "--hold", type=number(0.0, LONGEST_HOLD_S, "s"), metavar="S",
        help="go on so long after the verdict and say whether the debris is held [s] (mission.hold_s); default 0: no",
    )  # fmt: skip
    parser.add_argument(
        "--tow", type=number(0.0, HARDEST_TOW_N, "N"), metavar="N",
        help="meanwhile the chaser tows with this steady tension of the main tether [N] (mission.tow_n); default 0: no",
    )  # fmt: skip


def replaced(options: argparse.Namespace) -> list[str]:
    """Everything that the options of :func:`add_parameters` replace, as words for :func:`flights_of`."""
    given = {"mission.hold_s": options.hold, "mission.tow_n": options.tow}
    return [*options.set, *(f"{name}={value}" for name, value in given.items() if value is not None)]


@dataclass(frozen=True)
class Flight:
    """How a system is flown."""

    system: System
    """With the entries of its description replaced that are to be."""
    settings: Settings
    """Its parameters, likewise."""


Flights = dict[System, Flight]
"""By the system as it is described: that is what policies aim and places are drawn for, whatever is replaced."""


def flights_of(words: Sequence[str], systems: Iterable[System], printed: bool = False) -> Flights:
    """How systems are flown, with some entries of their descriptions and some parameters replaced.

    Args:
        words: each PART.NAME=VALUE; where PART is ``system``, NAME is an entry of the description.
        systems: as they are described.
        printed: begin with the paper's control as printed.

    Returns:
        One for each system, in their order.

    Raises:
        ParameterError: for a word of another form, an unknown name, a wrong type or a value out of range.
        DescriptionError: for an entry of a description that is not there or wrong.
    """
    overrides = _values(words)
    entries = overrides.pop(SYSTEM, {})
    load = Settings.paper if printed else Settings.load
    flown = {described: changed(described, entries) for described in systems}
    for described, system in flown.items():
        if system.unit_count != described.unit_count:
            raise ParameterError(
                f"--set system...: {system.name} would have {system.unit_count} units in the place of "
                f"{described.unit_count}; allowed: entries that leave their number, or a description of its own"
            )
    return {described: Flight(system, load(system, **overrides)) for described, system in flown.items()}


def settings_by_system(flights: Flights) -> dict[System, Settings]:
    """Parameters by the systems that are flown."""
    return {flight.system: flight.settings for flight in flights.values()}


def changed_system(words: Sequence[str], system: System) -> System:
    """A system with the entries of its description replaced that words name; see :func:`flights_of`."""
    return changed(system, _values(words).get(SYSTEM, {}))


def _values(words: Sequence[str]) -> dict[str, dict[str, Any]]:
    """What replaces what, by part and name."""
    import yaml

    parts = [*Settings.__dataclass_fields__, SYSTEM]
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
    return overrides


def fingerprints(settings: Mapping[System, Settings]) -> dict[str, str]:
    """Short hash of all parameters of each system's flights, by its name."""
    return {system.name: settings_fingerprint(one) for system, one in settings.items()}


def settings_fingerprint(settings: Settings) -> str:
    """Short hash of all parameters of the flights."""
    text = json.dumps(asdict(settings), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
