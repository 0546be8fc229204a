"""The command line of ``run_mission.py``.

Standard library only, and of this project only what is so too: the command refuses bad usage before the set-up has
installed anything. What is bounded by a
parameter file (the debris' place, for one) is checked after the set-up, in :mod:`tethernet_bringup.mission.parameters`.
"""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from tethernet_bringup.view.arguments import view_target
from tethernet_core import short_names as short
from tethernet_core.errors import InputError
from tethernet_core.near_match import near_match
from tethernet_core.shown import SHORT, shown
from tethernet_core.subcommand import Parser, number, one_of, whole_number
from tethernet_core.unit_norm import is_unit

PROGRAM = "run_mission.py"
SHIPPED_SYSTEMS = Path(short.__file__).with_name("systems")
"""Folder of the shipped descriptions: their names are needed before what reads them is installed."""
MOST_UNITS = 24
PACES = ("realtime", "lockstep")
DISCOVERY_RANGES = ("localhost", "subnet")
LARGEST_SEED = 2**63 - 1
DOMAIN_ID = whole_number(0, 232)
SMALLEST_NORM = 1e-6

EXIT_STATUS = """\
exit status: 0 captured (held or not), 3 flown but not captured, 2 bad usage, 1 a fault (the reason is printed),
130 ended by Ctrl-C, 143 ended by SIGTERM"""
EXAMPLES = """\
examples:
  python run_mission.py --mus 4 --debris 3 -2 -48 --tumble 0 0.05 0
  python run_mission.py --mus 8 --hold 60 --tow 20 --pace lockstep"""


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """Read the command line.

    Args:
        argv: the words after the program's name.

    Returns:
        The options, None where one is not given and a parameter file decides; ``notices`` holds remarks for the user.

    Raises:
        SystemExit: status 2 for bad usage, with a message on stderr that names what was given and what is allowed;
            status 0 for --help.
    """
    parser = _parser()
    options = parser.parse_args(argv)
    options.notices = []
    try:
        _check(options)
    except InputError as error:
        parser.error(str(error))
    return options


def _parser() -> Parser:
    description = "Fly a tether-net capture mission over ROS 2, record it and print the verdict."
    parser = Parser(PROGRAM, description, f"{EXAMPLES}\n\n{EXIT_STATUS}")
    add, finite = parser.add_argument, number()
    systems = shipped_systems()
    add(
        "--system", metavar="NAME|FILE",
        help=f"what is flown: {', '.join(systems)}, or the path of a description; default zenit_8mu",
    )  # fmt: skip
    add("--mus", type=whole_number(0), metavar="N", help=f"short for --system zenit_Nmu; {_or(short_names(systems))}")
    add(
        "--debris", nargs=3, type=finite, metavar=("X", "Y", "Z"),
        help="debris' centre of mass [m], frame launch; default: the system's, 0 0 -50 for zenit_8mu",
    )  # fmt: skip
    add(
        "--attitude", nargs=4, type=finite, metavar=("QX", "QY", "QZ", "QW"),
        help="debris' attitude, body to launch; default: the system's; the body's z axis along (1, 1, 0)",
    )  # fmt: skip
    add(
        "--tumble", nargs=3, type=finite, metavar=("WX", "WY", "WZ"),
        help="debris' angular rate [rad/s], body frame; default 0 0 0",
    )  # fmt: skip
    add("--seed", type=whole_number(0, LARGEST_SEED), metavar="N", help="seed of the sensor noise; default 1")
    add(
        "--policy", metavar="POLICY",
        help="who chooses the aiming points: nominal, rl (the trained policy that is shipped) or the path of a "
        "policy.safetensors; default: rl where a policy is shipped for the system, else nominal",
    )  # fmt: skip
    add(
        "--hold", type=finite, metavar="S",
        help="go on so long after the verdict and say whether the debris is held [s]; default 0: end with the verdict",
    )  # fmt: skip
    add(
        "--tow", type=finite, metavar="N",
        help="meanwhile the chaser tows with this steady tension of the main tether [N]; default 0: it coasts",
    )  # fmt: skip
    add(
        "--pace",
        type=one_of(*PACES),
        metavar="{realtime,lockstep}",
        help="20 Hz by the wall clock (default), or as fast as all commands arrive",
    )
    add("--output", default="runs", metavar="DIR", help="folder for the runs; default runs")
    add(
        "--external-mu", nargs="+", type=whole_number(1, MOST_UNITS), default=[], metavar="N",
        help="units whose odometry comes from a driver of their own",
    )  # fmt: skip
    add(
        "--external-timeout",
        type=number(0.0, unit="s"),
        default=60.0,
        metavar="S",
        help="wait so long for the drivers of external units [s]; default 60",
    )
    add("--no-sim", action="store_true", help="no simulator: all units are external, --debris says where the debris is")
    add("--params", metavar="FILE", help="ROS 2 parameter file; flags go before it, it goes before the shipped values")
    add("--domain-id", type=DOMAIN_ID, metavar="N", help="DDS domain; default: $ROS_DOMAIN_ID, or 0")
    add(
        "--discovery", type=one_of(*DISCOVERY_RANGES), default="localhost", metavar="{localhost,subnet}",
        help="who finds the nodes; default localhost",
    )  # fmt: skip
    add(
        "--view", nargs="?", const="window", metavar="web|FILE.rrd",
        help="show the flight in Rerun: in its window, in a browser on this machine, or recorded to a file; needs "
        "python3 -m bootstrap view, once",
    )  # fmt: skip
    add("--setup-only", action="store_true", help="make the environment, fly nothing")
    return parser


def _check(options: argparse.Namespace) -> None:
    for name in ("output", "policy", "params", "system"):
        if getattr(options, name) is not None and not getattr(options, name).strip():
            raise InputError(f"--{name}: nothing given; allowed: a name")
    _check_system(options)
    for name in ("debris", "tumble"):
        if (given := getattr(options, name)) is not None:
            setattr(options, name, tuple(given))
    options.attitude = _unit_quaternion(options)
    if options.view is not None:
        try:
            view_target(options.view)
        except ValueError as error:
            raise InputError(f"--view {error}") from error
    if options.domain_id is None:
        options.domain_id = _domain_id_of_environment()
    _check_external(options)


def shipped_systems() -> tuple[str, ...]:
    """Names of the shipped systems; none where the package that holds them lies elsewhere."""
    return tuple(sorted(path.stem for path in SHIPPED_SYSTEMS.glob("*.yaml")))


def short_names(systems: Sequence[str]) -> dict[int, str]:
    """The numbers that ``--mus`` takes, and the systems that they stand for."""
    found = {units: name for name in systems if (units := short.units_of(name)) is not None}
    return dict(sorted(found.items()))


def _check_system(options: argparse.Namespace) -> None:
    """Take ``--mus N`` for the system that it stands for, and refuse names of systems that there are not."""
    systems = shipped_systems()
    given = shown((options.system or "").strip(), SHORT)
    if options.mus is not None:
        count, names = options.mus, short_names(systems)
        if names and count not in names:
            raise InputError(f"--mus {count}: no such system; allowed: {_or(names)}, or --system NAME|FILE")
        name = names.get(count, short.short_name(count))
        if options.system not in (None, name):
            raise InputError(
                f"--mus {count} with --system {given}: two systems; allowed: one of them, --mus {count} "
                f"is short for --system {name}"
            )
        options.system = name
    elif options.system is not None and systems and options.system not in systems and not _is_file(options.system):
        raise InputError(
            f"--system {given}: no such system{near_match(options.system, systems)}; "
            f"allowed: {', '.join(systems)}, or the path of a description"
        )


def _is_file(word: str) -> bool:
    try:
        return Path(word).is_file()
    except (OSError, ValueError):  # such as a name that is too long, or with a NUL in it
        return False


def _or(values: Iterable[object]) -> str:
    """``4 or 8``."""
    words = [str(value) for value in values]
    return " or ".join(filter(None, (", ".join(words[:-1]), words[-1]))) if words else "none"


def _check_external(options: argparse.Namespace) -> None:
    options.external_mu = sorted(set(options.external_mu))  # how many there are is known once the description is read
    if options.no_sim:
        if options.external_mu:
            options.notices.append("--no-sim: all units are external, whatever --external-mu names")
        for name in ("attitude", "tumble"):
            if getattr(options, name) is not None:
                options.notices.append(f"--{name} has no effect: without a simulator the debris is a real one")
    if options.pace == "lockstep" and options.no_sim:
        raise InputError("--pace lockstep with --no-sim: no simulator waits for the units; allowed: --pace realtime")


def _unit_quaternion(options: argparse.Namespace) -> tuple[float, ...] | None:
    given = options.attitude
    if given is None:
        return None
    norm = math.hypot(*given)
    if not SMALLEST_NORM < norm < math.inf:
        raise InputError(
            f"--attitude {_text(given)}: no direction in it (norm {norm:g}); allowed: a quaternion x y z w of norm 1"
        )
    unit = tuple(value / norm for value in given)
    if not is_unit(norm):
        options.notices.append(
            f"--attitude {_text(given)} has norm {norm:g}; taken as the unit quaternion {_text(unit)}"
        )
    return unit


def _domain_id_of_environment() -> int:
    word = os.environ.get("ROS_DOMAIN_ID", "").strip()
    try:
        return DOMAIN_ID(word or "0")
    except argparse.ArgumentTypeError as error:
        raise InputError(f"environment variable ROS_DOMAIN_ID {error}; or give --domain-id") from error


def _text(values: Sequence[float]) -> str:
    return " ".join(f"{value:.6g}" for value in values)
