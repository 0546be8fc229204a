"""``tethernet systems``: what is shipped, what a description comes to, what is wrong with it, how it looks."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tethernet_core.errors import InputError
from tethernet_core.subcommand import Parser, Subcommand

if TYPE_CHECKING:
    from tethernet_core.system import System

SUFFIXES = (".png", ".svg", ".pdf")
_HEAD = ("name", "units", "net", "debris", "closing")


def list_systems(options: argparse.Namespace) -> None:
    """A line for each shipped system."""
    from tethernet_core.system import load_system, shipped_systems

    rows = [_HEAD, *(_row(load_system(name)) for name in shipped_systems())]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip())


def _row(system: System) -> tuple[str, ...]:
    net, closing = system.net, system.closing
    across = net.nodes.max(axis=0) - net.nodes.min(axis=0)
    size = " x ".join(f"{side:.3g}" for side in across[:2])
    pairs = f", {closing.max_locked_pairs} pairs" if closing.max_locked_pairs else ""
    return (
        system.name,
        str(system.unit_count),
        f"{net.kind}, {size} m, {net.node_count} nodes",
        f"{system.debris.shape.kind}, {system.debris.mass_kg:g} kg, {system.debris.shape.extent_m:.3g} m",
        f"{closing.kind}{pairs}",
    )


def show(options: argparse.Namespace) -> None:
    """What a description comes to."""
    from tethernet_core.system import load_system

    system = load_system(options.system)
    print(system.to_yaml() if options.yaml else "\n".join(system.summary()), end="" if options.yaml else "\n")


def check(options: argparse.Namespace) -> int:
    """What is wrong with descriptions: every mistake on a line of its own."""
    from tethernet_core.parameters import ParameterError
    from tethernet_core.system import DescriptionError, check_system

    status = 0
    for name in options.systems:
        try:
            system = check_system(name)
            step_s, needed = _checked(system)
        except DescriptionError as error:
            print("\n".join(error.sentences))
            status = 1
        except ParameterError as error:
            print(f"{name}: parameters: {error}")
            status = 1
        else:
            size = f"{system.unit_count} units, {system.net.node_count} nodes, stable with its step of {step_s:g} s"
            memory = f"a flight takes {needed / 1e6:.1f} MB beside the program"
            print(f"{name}: no mistakes; {size}; {memory}; digest {system.digest}")
    return status


def _checked(system: System) -> tuple[float, int]:
    """The time step that a system is flown with [s], and the memory that one flight takes [bytes].

    Raises:
        ParameterError: where its own parameters are wrong, the step is unstable, or the memory does not suffice.
    """
    from tethernet_sim.fly import Settings
    from tethernet_sim.memory import check_memory, flight_bytes
    from tethernet_sim.model import build_model

    physics = Settings.load(system).physics
    model = build_model(system, physics)
    check_memory(model, 1, system.name)
    return physics.time_step_s, flight_bytes(model, 1)


def draw(options: argparse.Namespace) -> None:
    """A picture."""
    from tethernet_core.system import load_system
    from tethernet_core.system.drawing import draw as draw_system

    if options.output.suffix not in SUFFIXES:
        raise InputError(f"--output {options.output}: allowed: names that end in {', '.join(SUFFIXES)}")
    print(draw_system(load_system(options.system), options.output))


def _add_system(parser: Parser) -> None:
    parser.add_argument("system", metavar="NAME|FILE", help="a shipped system, or the file of a description")


def _add_shown(parser: Parser) -> None:
    _add_system(parser)
    parser.add_argument("--yaml", action="store_true", help="the whole description, to begin an own one with")


def _add_checked(parser: Parser) -> None:
    parser.add_argument("systems", nargs="+", metavar="NAME|FILE", help="files of descriptions, or shipped systems")


def _add_drawn(parser: Parser) -> None:
    _add_system(parser)
    parser.add_argument(
        "--output", type=Path, required=True, metavar="PICTURE", help=f"ends in {', '.join(SUFFIXES)}"
    )  # fmt: skip


LIST = Subcommand("Name, units, net, debris and closing of every shipped system.", ("",), list_systems)
SHOW = Subcommand(
    "Show what a description comes to: its parts, the numbers derived from them, and the digest that results and "
    "trained models carry. All errors of a description that cannot be read: tethernet systems check.",
    ("zenit_8mu", "zenit_4mu --yaml"), show, _add_shown,
)  # fmt: skip
CHECK = Subcommand(
    "Check descriptions, and print every mistake with the entry that it is in and what is allowed there; then whether "
    "the time step is stable, and what memory a flight takes.",
    ("zenit_8mu", "mine.yaml theirs.yaml"), check, _add_checked,
    exit_status="exit status: 0 no mistakes, 1 some, 2 bad usage, 130 interrupted",
)  # fmt: skip
DRAW = Subcommand(
    "Draw net, units, closing ring, aiming points and debris to scale, from the front, from the side and from above.",
    ("zenit_8mu --output zenit.png",), draw, _add_drawn,
)  # fmt: skip
