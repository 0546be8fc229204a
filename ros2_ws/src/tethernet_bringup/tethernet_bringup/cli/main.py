"""The command ``tethernet``: finds the sub-command, reads its words, runs it."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from tethernet_bringup.cli import tree
from tethernet_core.command import FAULT, USAGE, command, complain
from tethernet_core.errors import FaultError, InputError
from tethernet_core.extras import explain_missing

HELP = ("-h", "--help")


def load() -> None:
    """Import what the words of this process choose. Whatever is wrong with them or it, :func:`main` finds it again."""
    try:
        node, _, _ = tree.find(sys.argv[1:])
        if isinstance(node, tree.Leaf):
            node.load()
    except Exception:
        return


@command
def main(argv: Sequence[str] | None = None) -> int:
    """Do what the words say.

    Args:
        argv: the words behind ``tethernet``; None for those of this process.

    Returns:
        The exit status: 0 done, 1 a fault, 2 bad usage, 130 interrupted, or what the sub-command says.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a name may hold what the terminal cannot show
            stream.reconfigure(errors="backslashreplace")
    program = tree.PROGRAM
    try:
        node, program, words = tree.find(sys.argv[1:] if argv is None else list(argv))
        if isinstance(node, tree.Group):
            return _show(node, program, words)
        return _run(node, program, words)
    except SystemExit as ended:  # of argparse, after --help or a message
        return int(ended.code or 0)
    except InputError as error:
        complain(f"error: {error}", program)
        return USAGE
    except FaultError as error:
        complain(f"fault: {error}", program)
        return FAULT
    except ModuleNotFoundError as error:
        fault = explain_missing(error)
        if fault is None:
            raise
        complain(f"fault: {fault}", program)
        return FAULT


def _run(leaf: tree.Leaf, program: str, words: Sequence[str]) -> int:
    subcommand = leaf.load()
    options = subcommand.parser(program).parse_args(words)
    return subcommand.run(options) or 0


def _show(group: tree.Group, program: str, words: Sequence[str]) -> int:
    """The overview: asked for, or in the place of a sub-command that was not given."""
    if words[:1] == ["--version"] and group is tree.TREE:
        from importlib.metadata import version

        print(f"{tree.PROGRAM} {version('tethernet_bringup')}")
        return 0
    if words and words[0] not in HELP:
        raise InputError(f"{words[0]}: no such option; allowed: --help, or a command: {', '.join(group.members)}")
    asked = bool(words) or group is tree.TREE
    print(tree.overview(group, program), file=sys.stdout if asked else sys.stderr)
    if asked:
        return 0
    raise InputError(f"a command is missing; allowed: {', '.join(group.members)}")
