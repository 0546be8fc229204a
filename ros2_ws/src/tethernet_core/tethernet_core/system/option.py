"""The options ``--system NAME|FILE`` and ``--mus N`` of every sub-command that flies or trains."""

from __future__ import annotations

import argparse

from ..errors import InputError
from ..short_names import FAMILY, units_of
from ..subcommand import whole_number
from .loading import load_system, shipped_systems
from .system import System

DEFAULT = "zenit_8mu"
"""The system that is taken where a command needs none to be named."""


def add_system(parser: argparse.ArgumentParser, *, required: bool = True, default: str = DEFAULT) -> None:
    """Add the options that choose one system.

    Args:
        parser: gets them.
        required: one of them must be given.
        default: what the help says is taken where none is.
    """
    group = parser.add_mutually_exclusive_group(required=required)
    group.add_argument(
        "--system", metavar="NAME|FILE",
        help="a shipped system (tethernet systems list) or a file" + ("" if required else f"; default {default}"),
    )  # fmt: skip
    group.add_argument(
        "--mus", type=whole_number(0), metavar="N", help=f"short for the shipped {FAMILY}* system with N units"
    )


def add_systems(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose one system or several; those that ``--mus`` chooses from are the default."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument(
        "--system", nargs="+", metavar="NAME|FILE",
        help=f"shipped systems (tethernet systems list) or files of some; default: the shipped {FAMILY}* systems",
    )  # fmt: skip
    group.add_argument(
        "--mus",
        type=whole_number(0),
        nargs="+",
        metavar="N",
        help=f"short for the shipped {FAMILY}* systems with N units",
    )


def chosen_system(options: argparse.Namespace, default: str = DEFAULT) -> System:
    """The system that the options name.

    Args:
        options: with ``system`` and ``mus`` as :func:`add_system` leaves them.
        default: name of the system where neither is given.

    Raises:
        InputError: when there is no such system.
        DescriptionError: when its description is wrong.
    """
    if options.mus is not None:
        return system_with_units(options.mus)
    return load_system(default if options.system is None else options.system)


def chosen_systems(options: argparse.Namespace) -> list[System]:
    """The systems that the options of :func:`add_systems` name, each once, those with fewer units first.

    Raises:
        InputError: when there is no such system.
        DescriptionError: when a description is wrong.
    """
    if options.mus is not None:
        systems = [system_with_units(units) for units in options.mus]
    elif options.system is not None:
        systems = [load_system(name) for name in options.system]
    else:
        systems = family()
    return sorted(dict.fromkeys(systems), key=lambda system: system.unit_count)


def system_with_units(units: int) -> System:
    """The shipped system that ``--mus`` means.

    Args:
        units: how many units it has.

    Raises:
        InputError: when none has so many.
    """
    by_units = {system.unit_count: system for system in family()}
    if units not in by_units:
        allowed = ", ".join(f"{count} ({system.name})" for count, system in by_units.items())
        raise InputError(f"--mus {units}: no shipped system for it; allowed: {allowed}; or --system NAME|FILE")
    return by_units[units]


def family() -> list[System]:
    """The systems that ``--mus`` chooses from, in the order of their units."""
    systems = [load_system(name) for name in shipped_systems() if units_of(name) is not None]
    return sorted(systems, key=lambda system: system.unit_count)
