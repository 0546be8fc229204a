"""The command line of ``run_mission.py``.

Standard library only: the command refuses bad usage before the set-up has installed anything. What is bounded by a
parameter file (the debris' place, for one) is checked after the set-up, in :mod:`tethernet_bringup.mission.parameters`.
"""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Sequence
from typing import NoReturn

PROGRAM = "run_mission.py"
MU_COUNTS = (4, 8)
PACES = ("realtime", "lockstep")
DISCOVERY_RANGES = ("localhost", "subnet")
LARGEST_SEED = 2**63 - 1
LARGEST_DOMAIN_ID = 232
UNIT_TOLERANCE = 1e-6
SMALLEST_NORM = 1e-6
LONGEST_WORD = 80
"""[characters] shown of what was given."""

EXIT_STATUS = """\
exit status: 0 captured, 3 flown but not captured, 2 bad usage, 1 a fault (the reason is printed),
130 ended by Ctrl-C, 143 ended by SIGTERM"""


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
        epilog=EXIT_STATUS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--mus", metavar="{4,8}", help="maneuverable units: 4 (winches close the net) or 8 (the MUs dock); default 8")
    add("--debris", nargs=3, metavar=("X", "Y", "Z"), help="debris' centre of mass [m], frame launch; default 0 0 -50")
    add(
        "--attitude", nargs=4, metavar=("QX", "QY", "QZ", "QW"),
        help="debris' attitude, body to launch; default: long axis along the net's diagonal",
    )  # fmt: skip
    add("--tumble", nargs=3, metavar=("WX", "WY", "WZ"), help="debris' angular rate [rad/s], body frame; default 0 0 0")
    add("--seed", metavar="N", help="seed of the sensor noise; default 1")
    add(
        "--policy", metavar="POLICY",
        help="who chooses the aiming points: nominal, rl (the trained policy that is shipped) or the path of a "
        "policy.safetensors; default: what the planner's parameter file says, rl as shipped",
    )  # fmt: skip
    add(
        "--pace",
        metavar="{realtime,lockstep}",
        help="20 Hz by the wall clock (default), or as fast as all commands arrive",
    )
    add("--output", default="runs", metavar="DIR", help="folder for the runs; default runs")
    add("--external-mu", nargs="+", metavar="N", help="MUs whose odometry comes from a driver of their own")
    add(
        "--external-timeout",
        default="60",
        metavar="S",
        help="wait so long for the drivers of external MUs [s]; default 60",
    )
    add("--no-sim", action="store_true", help="no simulator: all MUs are external, --debris says where the debris is")
    add("--params", metavar="FILE", help="ROS 2 parameter file; flags go before it, it goes before the shipped values")
    add("--domain-id", metavar="N", help="DDS domain; default: $ROS_DOMAIN_ID, or 0")
    add("--discovery", default="localhost", metavar="{localhost,subnet}", help="who finds the nodes; default localhost")
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
    if options.mus is not None:
        options.mus = _whole("--mus", options.mus)
        if options.mus not in MU_COUNTS:
            raise UsageError(
                f"--mus {options.mus}: no such design; allowed: 4 (winches close the net) or 8 (the MUs dock)"
            )
    options.debris = _numbers("--debris", options.debris)
    options.tumble = _numbers("--tumble", options.tumble)
    options.attitude = _unit_quaternion(options)
    if options.seed is not None:
        options.seed = _whole("--seed", options.seed, 0, LARGEST_SEED)
    for name, allowed in (("pace", PACES), ("discovery", DISCOVERY_RANGES)):
        given = getattr(options, name)
        if given is not None and given not in allowed:
            raise UsageError(f"--{name} {_cut(given)}: unknown; allowed: {' or '.join(allowed)}")
    for name in ("output", "policy", "params"):
        if getattr(options, name) is not None and not getattr(options, name).strip():
            raise UsageError(f"--{name}: nothing given; allowed: a name")
    options.external_timeout = _number("--external-timeout", options.external_timeout)
    if options.external_timeout < 0.0:
        raise UsageError(f"--external-timeout {options.external_timeout:g}: allowed: 0 s or more")
    options.domain_id = _domain_id(options.domain_id)
    _check_external(options)


def _check_external(options: argparse.Namespace) -> None:
    largest = options.mus or max(MU_COUNTS)
    given = options.external_mu or []
    options.external_mu = sorted({_whole("--external-mu", word, 1, largest) for word in given})
    if options.no_sim:
        if options.external_mu and options.mus and len(options.external_mu) < options.mus:
            options.notices.append("--no-sim: all MUs are external, not only those that --external-mu names")
        for name in ("attitude", "tumble"):
            if getattr(options, name) is not None:
                options.notices.append(f"--{name} has no effect: without a simulator the debris is a real one")
    if options.pace == "lockstep" and options.no_sim:
        raise UsageError(
            "--pace lockstep with --no-sim: there is no simulator that could wait for the MUs; allowed: --pace realtime"
        )


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
