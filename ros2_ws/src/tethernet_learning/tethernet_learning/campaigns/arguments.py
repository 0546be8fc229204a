"""The campaign command's options."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

from tethernet_learning import flight_settings, workers
from tethernet_planner import policies
from tethernet_sim.fly import CHUNK
from tethernet_sim.scenario import FAILURES

PROGRAM = "python -m tethernet_learning.campaigns"
DESCRIPTION = """\
Fly many missions in full, in process, on all cores; the outcomes become one row each of a Parquet or CSV file.

Give the same command again to go on after an interruption: at most the missions in flight are lost. A file that was
begun with other scenarios, settings or code is refused. A mission that ends in error is counted as not captured."""
EPILOG = f"""\
examples:
  {PROGRAM} random --scenarios 1000 --seed 7 --output random.parquet
  {PROGRAM} attitude --directions 200 --each 5 --output attitude.parquet
  {PROGRAM} tumble --rates 0 1 2 3 4 5 --mus 8 --output tumble.csv
  {PROGRAM} loss --scenarios 300 --output loss.parquet
  {PROGRAM} file --scenarios scenarios.csv --output again.parquet
  {PROGRAM} table loss.parquet --by mus failure_kind
  {PROGRAM} plot attitude attitude.parquet --output attitude.png

NUMBA_NUM_THREADS limits the cores.
exit status: 0 done, 1 a fault, 2 bad usage, 130 interrupted (the same command goes on)"""


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line.

    Args:
        argv: the words after the program's name; None for those of this process.

    Returns:
        The options; ``command`` names what to do.

    Raises:
        SystemExit: status 2 for bad usage, with what was given and what is allowed on standard error.
    """
    return _parser().parse_args(argv)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROGRAM, description=DESCRIPTION, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def flight(name: str, text: str) -> argparse.ArgumentParser:
        command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        _add_flight_options(command)
        return command

    def seeded(name: str, text: str) -> argparse.ArgumentParser:
        command = flight(name, text)
        command.add_argument(
            "--mus", type=int, nargs="+", choices=(4, 8), default=[4, 8], help="designs to fly; default both"
        )
        command.add_argument("--seed", type=_not_negative, default=0, help="of all that is random; default 0")
        return command

    def count(command: argparse.ArgumentParser, name: str, default: int, text: str) -> None:
        command.add_argument(name, type=_positive, default=default, metavar="N", help=f"{text}; default {default}")

    command = seeded("random", "the debris anywhere within the mission's bounds")
    count(command, "--scenarios", 100, "how many for each design")

    command = seeded("attitude", "the debris' long axis over the whole sphere, at random places")
    count(command, "--directions", 200, "directions of the long axis, evenly spread over the hemisphere")
    count(command, "--each", 5, "missions for each direction")

    command = seeded("tumble", "the debris tumbles about axes over the whole sphere, at random places")
    command.add_argument(
        "--rates", type=_rate, nargs="+", default=[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], metavar="DEG_S",
        help="tumble rates [deg/s]; default 0 1 2 3 4 5",
    )  # fmt: skip
    count(command, "--axes", 20, "axes, evenly spread over the sphere")
    count(command, "--each", 3, "missions for each rate and axis")
    command.add_argument(
        "--attitude", choices=("default", "random"), default="default",
        help="at launch: default (long axis along the net's diagonal) or random",
    )  # fmt: skip

    command = seeded("loss", "one MU is lost in flight: any of them, at any time")
    count(command, "--scenarios", 100, "how many for each design")
    command.add_argument(
        "--latest", type=_duration, default=32.0, metavar="S",
        help="the loss comes at a random time from launch to this [s]; default 32, some 8 s after the trigger",
    )  # fmt: skip
    command.add_argument("--kinds", nargs="+", choices=FAILURES, default=list(FAILURES), help="default all")

    command = flight("file", "scenarios from a file with the columns of an outcomes file; the default where one lacks")
    command.add_argument("--scenarios", type=Path, required=True, metavar="FILE", help=".csv or .parquet")

    command = commands.add_parser("table", help="statistics of outcomes files", description="Statistics of outcomes.")
    command.add_argument("files", type=Path, nargs="+", metavar="FILE", help="outcomes, .parquet or .csv")
    command.add_argument("--by", nargs="+", metavar="COLUMN", help="columns to group by; default mus policy group")

    command = commands.add_parser("plot", help="a map of outcomes files", description="Draw a map of outcomes.")
    command.add_argument(
        "map", choices=("attitude", "tumble"),
        help="attitude: over the direction of the long axis; tumble: over rate and axis of the tumble",
    )  # fmt: skip
    command.add_argument("files", type=Path, nargs="+", metavar="FILE", help="outcomes, .parquet or .csv")
    command.add_argument("--output", type=Path, required=True, metavar="PICTURE", help=".png, .svg or .pdf")
    return parser


def _add_flight_options(command: argparse.ArgumentParser) -> None:
    add = command.add_argument
    add("--output", type=Path, required=True, metavar="FILE", help="outcomes, .parquet or .csv")
    add("--policy", default=policies.default(), metavar="POLICY", help=f"who aims: {policies.HELP}")
    add("--control", choices=("default", "paper"), default="default", help="paper: its law as printed")
    add(
        "--set", nargs="+", action="extend", default=[], metavar=flight_settings.METAVAR,
        help=flight_settings.HELP,
    )  # fmt: skip
    add("--cluster", metavar="ADDRESS", help=workers.HELP)
    add("--chunk", type=_positive, default=CHUNK, metavar="N", help=f"missions flown together; default {CHUNK}")


def _checked(word: str, kind: type, low: float, high: float, allowed: str):
    try:
        value = kind(word)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"{word}: allowed: {allowed}")
    return value


def _positive(word: str) -> int:
    return _checked(word, int, 1, math.inf, "a whole number from 1")


def _not_negative(word: str) -> int:
    return _checked(word, int, 0, math.inf, "a whole number from 0")


def _rate(word: str) -> float:
    return _checked(word, float, 0.0, 90.0, "0 to 90 deg/s")


def _duration(word: str) -> float:
    return _checked(word, float, 0.0, 1000.0, "0 to 1000 s")
