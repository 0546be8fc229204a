"""The command line of ``run_mission.py``.

Standard library only: the command refuses bad usage before the set-up has installed anything. What is bounded by a
parameter file (the debris' place, for one) is checked after the set-up, in :mod:`tethernet_bringup.mission.parameters`.
"""

from __future__ import annotations

import argparse
import difflib
import math
import os
import runpy
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NoReturn

PROGRAM = "run_mission.py"
SHIPPED_SYSTEMS = Path(__file__).resolve().parents[3] / "tethernet_core" / "tethernet_core" / "systems"
"""Folder of the shipped descriptions: their names are needed before the package that reads them is installed."""
MOST_UNITS = 24
PACES = ("realtime", "lockstep")
DISCOVERY_RANGES = ("localhost", "subnet")
LARGEST_SEED = 2**63 - 1
LARGEST_DOMAIN_ID = 232
UNIT_TOLERANCE = 1e-6
SMALLEST_NORM = 1e-6
LONGEST_WORD = 80
"""[characters] shown of what was given."""

EXIT_STATUS = """\
exit status: 0 captured (held or not), 3 flown but not captured, 2 bad usage, 1 a fault (the reason is printed),
130 ended by Ctrl-C, 143 ended by SIGTERM"""
EXAMPLES = """\
examples:
  python run_mission.py --mus 4 --debris 3 -2 -48 --tumble 0 0.05 0
  python run_mission.py --mus 8 --hold 60 --tow 20 --pace lockstep"""


class UsageError(ValueError):
    """The command line cannot be meant: what was given and what is allowed."""


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
    options = parser.parse_args([_shield_number(word) for word in argv])
    options.notices = []
    try:
        _check(options)
    except UsageError as error:
        parser.error(str(error))
    return options


class _Parser(argparse.ArgumentParser):
    """Shows what was given escaped and cut, where the project is installed already."""

    def error(self, message: str) -> NoReturn:
        try:
            from tethernet_core.shown import shown
        except ImportError:
            super().error(message)
        super().error(shown(message))


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog=PROGRAM,
        description="Fly a tether-net capture mission over ROS 2, record it and print the verdict.",
        epilog=f"{EXAMPLES}\n\n{EXIT_STATUS}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    systems = shipped_systems()
    add(
        "--system", metavar="NAME|FILE",
        help=f"what is flown: {', '.join(systems)}, or the path of a description; default zenit_8mu",
    )  # fmt: skip
    add("--mus", metavar="N", help=f"short for --system zenit_Nmu; {_or(short_names(systems))}")
    add(
        "--debris", nargs=3, metavar=("X", "Y", "Z"),
        help="debris' centre of mass [m], frame launch; default: the system's, 0 0 -50 for zenit_8mu",
    )  # fmt: skip
    add(
        "--attitude", nargs=4, metavar=("QX", "QY", "QZ", "QW"),
        help="debris' attitude, body to launch; default: the system's; the body's z axis along (1, 1, 0)",
    )  # fmt: skip
    add("--tumble", nargs=3, metavar=("WX", "WY", "WZ"), help="debris' angular rate [rad/s], body frame; default 0 0 0")
    add("--seed", metavar="N", help="seed of the sensor noise; default 1")
    add(
        "--policy", metavar="POLICY",
        help="who chooses the aiming points: nominal, rl (the trained policy that is shipped) or the path of a "
        "policy.safetensors; default: rl where a policy is shipped for the system, else nominal",
    )  # fmt: skip
    add(
        "--hold", metavar="S",
        help="go on so long after the verdict and say whether the debris is held [s]; default 0: end with the verdict",
    )  # fmt: skip
    add(
        "--tow", metavar="N",
        help="meanwhile the chaser tows with this steady tension of the main tether [N]; default 0: it coasts",
    )  # fmt: skip
    add(
        "--pace",
        metavar="{realtime,lockstep}",
        help="20 Hz by the wall clock (default), or as fast as all commands arrive",
    )
    add("--output", default="runs", metavar="DIR", help="folder for the runs; default runs")
    add("--external-mu", nargs="+", metavar="N", help="units whose odometry comes from a driver of their own")
    add(
        "--external-timeout",
        default="60",
        metavar="S",
        help="wait so long for the drivers of external units [s]; default 60",
    )
    add("--no-sim", action="store_true", help="no simulator: all units are external, --debris says where the debris is")
    add("--params", metavar="FILE", help="ROS 2 parameter file; flags go before it, it goes before the shipped values")
    add("--domain-id", metavar="N", help="DDS domain; default: $ROS_DOMAIN_ID, or 0")
    add("--discovery", default="localhost", metavar="{localhost,subnet}", help="who finds the nodes; default localhost")
    add(
        "--view", nargs="?", const="window", metavar="web|FILE.rrd",
        help="show the flight in Rerun: in its window, in a browser on this machine, or recorded to a file; needs "
        "python3 -m bootstrap view, once",
    )  # fmt: skip
    add("--setup-only", action="store_true", help="make the environment, fly nothing")
    return parser


def _shield_number(word: str) -> str:
    """Keep argparse from taking a negative number such as -1e-3 for an option; a leading blank does."""
    if word.startswith("-"):
        try:
            float(word)
        except ValueError:
            return word
        return " " + word
    return word


def _check(options: argparse.Namespace) -> None:
    for name in ("output", "policy", "params", "system"):
        if getattr(options, name) is not None and not getattr(options, name).strip():
            raise UsageError(f"--{name}: nothing given; allowed: a name")
    _check_system(options)
    options.debris = _numbers("--debris", options.debris)
    options.tumble = _numbers("--tumble", options.tumble)
    options.attitude = _unit_quaternion(options)
    for name in ("hold", "tow"):
        if (word := getattr(options, name)) is not None:
            setattr(options, name, _number(f"--{name}", word))
    if options.seed is not None:
        options.seed = _whole("--seed", options.seed, 0, LARGEST_SEED)
    for name, allowed in (("pace", PACES), ("discovery", DISCOVERY_RANGES)):
        given = getattr(options, name)
        if given is not None and given not in allowed:
            raise UsageError(f"--{name} {_cut(given)}: unknown; allowed: {' or '.join(allowed)}")
    if options.view is not None:
        try:
            _view_rules()["view_target"](options.view)
        except ValueError as error:
            raise UsageError(f"--view {error}") from error
    options.external_timeout = _number("--external-timeout", options.external_timeout)
    if options.external_timeout < 0.0:
        raise UsageError(f"--external-timeout {options.external_timeout:g}: allowed: 0 s or more")
    options.domain_id = _domain_id(options.domain_id)
    _check_external(options)


def shipped_systems() -> tuple[str, ...]:
    """Names of the shipped systems; none where the package that holds them lies elsewhere."""
    return tuple(sorted(path.stem for path in SHIPPED_SYSTEMS.glob("*.yaml")))


def short_names(systems: Sequence[str]) -> dict[int, str]:
    """The numbers that ``--mus`` takes, and the systems that they stand for."""
    units_of = _short_names()["units_of"]
    found = {units: name for name in systems if (units := units_of(name)) is not None}
    return dict(sorted(found.items()))


def _short_names() -> dict[str, Any]:
    """What :mod:`tethernet_core.short_names` defines, by its path where nothing is installed yet."""
    path = SHIPPED_SYSTEMS.parent / "short_names.py"
    if path.exists():
        return runpy.run_path(str(path))
    from tethernet_core import short_names

    return vars(short_names)


def _view_rules() -> dict[str, Any]:
    """What :mod:`tethernet_bringup.view.arguments` defines, by its path: nothing may be installed yet."""
    return runpy.run_path(str(Path(__file__).resolve().parents[1] / "view" / "arguments.py"))


def _check_system(options: argparse.Namespace) -> None:
    """Take ``--mus N`` for the system that it stands for, and refuse names of systems that there are not."""
    systems = shipped_systems()
    if options.mus is not None:
        count, names = _whole("--mus", options.mus), short_names(systems)
        if names and count not in names:
            raise UsageError(f"--mus {count}: no such system; allowed: {_or(names)}, or --system NAME|FILE")
        name = names.get(count, _short_names()["short_name"](count))
        if options.system not in (None, name):
            raise UsageError(
                f"--mus {count} with --system {_cut(options.system)}: two systems; allowed: one of them, --mus {count} "
                f"is short for --system {name}"
            )
        options.system = name
    elif options.system is not None and systems and options.system not in systems and not _is_file(options.system):
        near = difflib.get_close_matches(options.system, systems, 1)
        raise UsageError(
            f"--system {_cut(options.system)}: no such system{f' (did you mean {near[0]}?)' if near else ''}; "
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
    # How many the system has is known once its description is read.
    largest = MOST_UNITS
    given = options.external_mu or []
    options.external_mu = sorted({_whole("--external-mu", word, 1, largest) for word in given})
    if options.no_sim:
        if options.external_mu:
            options.notices.append("--no-sim: all units are external, whatever --external-mu names")
        for name in ("attitude", "tumble"):
            if getattr(options, name) is not None:
                options.notices.append(f"--{name} has no effect: without a simulator the debris is a real one")
    if options.pace == "lockstep" and options.no_sim:
        raise UsageError("--pace lockstep with --no-sim: no simulator waits for the units; allowed: --pace realtime")


def _unit_quaternion(options: argparse.Namespace) -> tuple[float, ...] | None:
    given = _numbers("--attitude", options.attitude)
    if given is None:
        return None
    norm = math.hypot(*given)
    if not SMALLEST_NORM < norm < math.inf:
        raise UsageError(
            f"--attitude {_text(given)}: no direction in it (norm {norm:g}); allowed: a quaternion x y z w of norm 1"
        )
    unit = tuple(value / norm for value in given)
    if abs(norm - 1.0) > UNIT_TOLERANCE:
        options.notices.append(
            f"--attitude {_text(given)} has norm {norm:g}; taken as the unit quaternion {_text(unit)}"
        )
    return unit


def _domain_id(word: str | None) -> int:
    if word is not None:
        return _whole("--domain-id", word, 0, LARGEST_DOMAIN_ID)
    from_environment = os.environ.get("ROS_DOMAIN_ID", "").strip()
    if not from_environment:
        return 0
    try:
        return _whole("ROS_DOMAIN_ID", from_environment, 0, LARGEST_DOMAIN_ID)
    except UsageError as error:
        raise UsageError(f"environment variable {error}; or give --domain-id") from error


def _cut(word: str) -> str:
    """A word of the user, short enough for what is allowed to be read behind it."""
    word = word.strip()
    return word if len(word) <= LONGEST_WORD else word[: LONGEST_WORD - 1] + "…"


def _numbers(name: str, words: list[str] | None) -> tuple[float, ...] | None:
    return None if words is None else tuple(_number(name, word) for word in words)


def _number(name: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        raise UsageError(f"{name}: {_cut(word)!r} is not a number") from None
    if not math.isfinite(value):
        raise UsageError(f"{name}: {word.strip()} is not finite; allowed: finite numbers")
    return value


def _whole(name: str, word: str, low: int | None = None, high: int | None = None) -> int:
    allowed = f"; allowed: {low} to {high}" if low is not None else ""
    try:
        value = int(word)
    except ValueError:
        raise UsageError(f"{name} {_cut(word)}: not a whole number{allowed}") from None
    if low is not None and high is not None and not low <= value <= high:
        raise UsageError(f"{name} {_cut(word)}: out of range{allowed}")
    return value


def _text(values: Sequence[float]) -> str:
    return " ".join(f"{value:.6g}" for value in values)
