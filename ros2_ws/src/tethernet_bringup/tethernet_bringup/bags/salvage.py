"""Rewrites a torn bag into a whole one: ``tethernet salvage TORN [OUT]``.

TORN is a run's folder, a bag's folder, an MCAP or an SQLite file: cut off at any byte, with rubbish at its end, without
metadata.yaml, split, compressed. OUT is the folder of the new bag, one plain MCAP file, by default TORN's name with
``_salvaged`` beside it. TORN is only read.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from tethernet_bringup.bags.errors import BagWriteError, NotABagError
from tethernet_bringup.bags.reader import BagReader, open_bag
from tethernet_bringup.bags.writer import RUN_INFO_RECORD, BagWriter
from tethernet_core.subcommand import Parser, Subcommand

NANOSECOND_S = 1e-9


@dataclass(frozen=True)
class Salvage:
    """What was recovered."""

    folder: Path
    """The new bag."""
    message_count: int
    start_ns: int
    """Smallest log time [ns]."""
    end_ns: int
    """Largest log time [ns]."""
    problems: tuple[str, ...]
    """What is wrong with the torn bag; empty for a whole one."""
    verified: bool
    """Whether checksums over every byte say that the bag was whole."""


def salvage(torn: Path, out: Path | None = None) -> Salvage:
    """Rewrite a torn bag.

    Args:
        torn: a run's folder, a bag's folder, an MCAP or an SQLite file; only read.
        out: folder of the new bag.

    Raises:
        NotABagError: when ``torn`` is no bag, or not one message in it is whole.
        BagWriteError: when the new bag cannot be written.
        BagError: when ``torn`` cannot be read.
    """
    bag = open_bag(torn)
    out = _default_output(bag) if out is None else out
    # Topics stand before the messages, but in bags of other recorders they may come at any place: look for them first.
    first = next(messages := bag.messages(), None)
    if first is None:
        why = "; ".join(bag.problems) or "it is whole, but empty"
        raise NotABagError(f"not one message can be recovered from {torn} ({why})")
    for _ in messages:
        pass
    return _rewrite(bag, out)


def _rewrite(bag: BagReader, out: Path) -> Salvage:
    topics = list(bag.topics.values())
    number = {topic.name: index for index, topic in enumerate(topics)}
    is_new = not out.exists()
    writer = BagWriter(out, topics, run_info=bag.metadata.get(RUN_INFO_RECORD, {}))
    try:
        for message in bag.messages():
            writer.write(number[message.topic], message.log_time, message.publish_time, message.sequence, message.data)
        writer.close()
    except BagWriteError:
        if is_new:
            shutil.rmtree(out, ignore_errors=True)  # half a salvage would pass for the whole
        raise
    start, end = writer.span_ns
    return Salvage(out, sum(writer.counts), start, end, tuple(bag.problems), bag.verified)


def _default_output(bag: BagReader) -> Path:
    folder = bag.files[0].absolute().parent
    return folder.with_name(folder.name + "_salvaged")


def run(torn: Path, out: Path | None) -> None:
    """Salvage and print what was recovered and what was lost.

    Raises:
        BagError: see :func:`salvage`.
    """
    result = salvage(torn, out)
    seconds = [time * NANOSECOND_S for time in (result.start_ns, result.end_ns)]
    print(f"recovered {result.message_count} messages, {seconds[0]:.2f} s to {seconds[1]:.2f} s, into {result.folder}")
    if result.verified:
        print("the bag was whole")
    elif not result.problems:
        print("nothing is missing as far as can be seen; the bag has no checksums that could prove it")
    for problem in result.problems:
        print(f"lost: {problem}")


def _add_arguments(parser: Parser) -> None:
    parser.add_argument("torn", type=Path, metavar="TORN", help="a run's folder, a bag's folder, a .mcap or .db3 file")
    parser.add_argument(
        "out", type=Path, metavar="OUT", nargs="?", help="folder of the new bag; default: TORN_salvaged"
    )  # fmt: skip


COMMAND = Subcommand(
    "Rewrite a torn bag into a whole one; the torn one is only read.",
    ("runs/RUN", "runs/RUN/bag/bag_0.mcap whole"), lambda options: run(options.torn, options.out), _add_arguments,
    exit_status="exit status: 0 messages were recovered, 1 there is nothing to recover, 2 bad usage, 130 interrupted",
)  # fmt: skip
