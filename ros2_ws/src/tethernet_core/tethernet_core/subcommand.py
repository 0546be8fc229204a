"""Command lines: how words are read, and what a sub-command of ``tethernet`` consists of.

Standard library only: ``run_mission.py`` refuses bad usage before the set-up has installed anything.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from tethernet_core.near_match import near_match
from tethernet_core.shown import SHORT, shown

_WIDTH = 100
"""Of texts in a help [characters]."""

EXIT_STATUS = "exit status: 0 done, 1 a fault, 2 bad usage, 130 interrupted"


class Parser(argparse.ArgumentParser):
    """Reads the words of one command.

    Options are given in full; a number may begin with a minus sign in any notation; errors show what was given escaped
    and cut, and hint at the option that was probably meant.
    """

    def __init__(self, program: str, description: str, epilog: str = "", *, wrapped: bool = False):
        """Args:
        program: the command's name.
        description: shown above the options.
        epilog: shown below them.
        wrapped: whether the two are broken into lines anew, to the terminal's width.
        """
        super().__init__(
            prog=program,
            description=description,
            epilog=epilog,
            formatter_class=argparse.HelpFormatter if wrapped else argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )

    def error(self, message: str) -> NoReturn:
        super().error(shown(message))

    def parse_args(  # type: ignore[override]  # the words must be given: this process' own are nobody's business
        self, args: Sequence[str], namespace: Any = None
    ) -> argparse.Namespace:
        """Read words.

        Raises:
            SystemExit: status 2 for bad usage, after a message on standard error; 0 for ``--help``.
        """
        words = list(args)
        known = self._option_string_actions
        options = words[: words.index("--")] if "--" in words else words
        for name in (word.partition("=")[0] for word in options if word.startswith("--")):
            if name not in known:
                self.error(f"{shown(name, SHORT)}: no such option{near_match(name, known)}")
        return super().parse_args([_shielded(word) for word in words], namespace)


@dataclass(frozen=True)
class Subcommand:
    """What a module offers to the command line."""

    description: str
    """What it does, in sentences."""
    examples: tuple[str, ...]
    """Words behind the sub-command's name that can be given as they stand."""
    run: Callable[[argparse.Namespace], int | None]
    """Does it; gives the exit status, None for 0. What the user can put right is raised as an
    :class:`tethernet_core.errors.InputError`, any other reason not to go on as a
    :class:`tethernet_core.errors.FaultError`."""
    add_arguments: Callable[[Parser], None] = lambda parser: None
    """Adds the options."""
    notes: str = ""
    """Shown below the options."""
    exit_status: str = EXIT_STATUS

    def parser(self, program: str) -> Parser:
        """What reads its words.

        Args:
            program: all words before them: ``tethernet train policy``.
        """
        lines = ["examples:" if len(self.examples) > 1 else "example:"]
        lines += [f"  {program} {words}".rstrip() for words in self.examples]
        notes = ["", textwrap.fill(self.notes, _WIDTH)] if self.notes else []
        epilog = "\n".join([*lines, *notes, "", textwrap.fill(self.exit_status, _WIDTH)])
        parser = Parser(program, textwrap.fill(self.description, _WIDTH), epilog)
        self.add_arguments(parser)
        return parser


def whole_number(low: int, high: float = math.inf) -> Callable[[str], int]:
    """The type of an option that takes whole numbers from ``low`` to ``high``."""
    allowed = f"a whole number from {low}" + (f" to {int(high)}" if high < math.inf else "")
    return lambda word: _checked(word, int, low, high, allowed)


def number(
    low: float = -math.inf, high: float = math.inf, unit: str = "", *, above: bool = False
) -> Callable[[str], float]:
    """The type of an option that takes finite numbers.

    Args:
        low: the smallest; may be infinite if ``high`` is.
        high: the largest; may be infinite.
        unit: named in errors.
        above: ``low`` itself is not allowed.
    """
    if low == -math.inf:
        allowed = "finite numbers"
    elif above:
        allowed = f"more than {low:g} {unit}" + (f", at most {high:g} {unit}" if high < math.inf else "")
    else:
        allowed = f"{low:g} to {high:g} {unit}" if high < math.inf else f"{low:g} {unit} or more"
    smallest = math.nextafter(low, math.inf) if above else low
    least, most = max(smallest, -sys.float_info.max), min(high, sys.float_info.max)
    return lambda word: _checked(word, float, least, most, allowed.replace("  ", " ").strip())


def one_of(*allowed: str) -> Callable[[str], str]:
    """The type of an option that takes one of a few words.

    Other than by argparse's ``choices``, what is allowed is told however long the word is that was given.
    """

    def chosen(word: str) -> str:
        if word not in allowed:
            raise argparse.ArgumentTypeError(f"{shown(word.strip(), SHORT)}: unknown; allowed: {' or '.join(allowed)}")
        return word

    return chosen


def _checked(word: str, kind: Callable[[str], Any], low: float, high: float, allowed: str) -> Any:
    try:
        value = kind(word)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"{shown(word.strip(), SHORT)}: allowed: {allowed}")
    return value


def _shielded(word: str) -> str:
    """A negative number, or what is meant for one, in a form that argparse does not take for an option."""
    return " " + word if re.match(r"-(\d|\.\d|inf|nan)", word) else word
