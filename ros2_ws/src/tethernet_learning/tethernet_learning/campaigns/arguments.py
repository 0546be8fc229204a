"""The options of the campaign commands."""

from __future__ import annotations

from pathlib import Path

from tethernet_core.subcommand import Parser, number, whole_number
from tethernet_core.system.option import add_systems
from tethernet_learning import flight_settings, workers
from tethernet_sim.fly import CHUNK
from tethernet_sim.scenario import FAILURES

FASTEST_DEG_S, LATEST_S = 90.0, 1000.0


def add_random(parser: Parser) -> None:
    """Options of ``campaign random``."""
    _add_flight(parser)
    _add_seeded(parser)
    _add_count(parser, "--scenarios", 100, "how many for each system")


def add_attitude(parser: Parser) -> None:
    """Options of ``campaign attitude``."""
    _add_flight(parser)
    _add_seeded(parser)
    _add_count(
        parser, "--directions", 200, "directions of the debris' long axis (of another where it has none), evenly spread"
    )
    _add_count(parser, "--each", 5, "missions for each direction")


def add_tumble(parser: Parser) -> None:
    """Options of ``campaign tumble``."""
    _add_flight(parser)
    _add_seeded(parser)
    parser.add_argument(
        "--rates", type=number(0.0, FASTEST_DEG_S, "deg/s"), nargs="+", default=[0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        metavar="DEG_S", help="tumble rates [deg/s]; default 0 1 2 3 4 5",
    )  # fmt: skip
    _add_count(parser, "--axes", 20, "axes, evenly spread over the sphere")
    _add_count(parser, "--each", 3, "missions for each rate and axis")
    parser.add_argument(
        "--attitude", choices=("default", "random"), default="default",
        help="at launch: default (long axis along the net's diagonal) or random",
    )  # fmt: skip


def add_loss(parser: Parser) -> None:
    """Options of ``campaign loss``."""
    _add_flight(parser)
    _add_seeded(parser)
    _add_count(parser, "--scenarios", 100, "how many for each system")
    parser.add_argument(
        "--latest", type=number(0.0, LATEST_S, "s"), default=32.0, metavar="S",
        help="the loss comes at a random time from launch to this [s]; default 32, some 8 s after the trigger",
    )  # fmt: skip
    parser.add_argument(
        "--kinds", nargs="+", choices=FAILURES, default=list(FAILURES), metavar="KIND",
        help=f"of {', '.join(FAILURES)}; default all",
    )  # fmt: skip


def add_file(parser: Parser) -> None:
    """Options of ``campaign file``."""
    _add_flight(parser)
    parser.add_argument("--scenarios", type=Path, required=True, metavar="FILE", help=".csv or .parquet")
    parser.add_argument(
        "--system", nargs="+", default=[], metavar="NAME|FILE", help="own systems that its column system names"
    )  # fmt: skip


def add_table(parser: Parser) -> None:
    """Options of ``campaign table``."""
    _add_files(parser)
    parser.add_argument("--by", nargs="+", metavar="COLUMN", help="columns to group by; default system policy group")


def add_plot(parser: Parser) -> None:
    """Options of ``campaign plot``."""
    parser.add_argument(
        "map", choices=("attitude", "tumble"),
        help="attitude: over the direction of the long axis, or of another; tumble: over rate and axis of the tumble",
    )  # fmt: skip
    _add_files(parser)
    parser.add_argument("--output", type=Path, required=True, metavar="PICTURE", help=".png, .svg or .pdf")
    parser.add_argument("--system", nargs="+", default=[], metavar="NAME|FILE", help="own systems that were flown")


def _add_files(parser: Parser) -> None:
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="outcomes, .parquet or .csv")


def _add_flight(parser: Parser) -> None:
    add = parser.add_argument
    add("--output", type=Path, required=True, metavar="FILE", help="outcomes, .parquet or .csv")
    flight_settings.add_flight(parser)
    add("--cluster", metavar="ADDRESS", help=workers.HELP)
    _add_count(parser, "--chunk", CHUNK, "missions flown together")


def _add_seeded(parser: Parser) -> None:
    add_systems(parser)
    parser.add_argument(
        "--seed", type=whole_number(0), default=0, metavar="N", help="of all that is random; default 0"
    )  # fmt: skip


def _add_count(parser: Parser, name: str, default: int, text: str) -> None:
    parser.add_argument(
        name, type=whole_number(1), default=default, metavar="N", help=f"{text}; default {default}"
    )  # fmt: skip
