"""The tree of sub-commands, in words alone: nothing is imported before it is chosen."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tethernet_core.errors import InputError
from tethernet_core.near_match import near_match

if TYPE_CHECKING:
    from tethernet_core.subcommand import Subcommand

PROGRAM = "tethernet"


@dataclass(frozen=True)
class Leaf:
    """A sub-command."""

    summary: str
    module: str
    """Holds its :class:`tethernet_core.subcommand.Subcommand`."""
    name: str = "COMMAND"
    """Of that object."""

    def load(self) -> Subcommand:
        """Import it."""
        return getattr(importlib.import_module(self.module), self.name)


@dataclass(frozen=True)
class Group:
    """Sub-commands under one word."""

    summary: str
    members: Mapping[str, Leaf | Group]
    alone: Leaf | None = None
    """What the word of the group itself does, with words that name no member; None: it needs a member."""


_LEARNING, _CAMPAIGNS = "tethernet_learning", "tethernet_learning.campaigns.command"

TREE = Group(
    "Fly described systems of tether-net, units and debris, and all that comes before and after a flight.",
    {
        "fly": Leaf("fly one mission in this process, without ROS", "tethernet_bringup.cli.fly"),
        "evaluate": Group(
            "fly policies on unseen scenarios",
            {
                "policies": Leaf(
                    "policies and the nominal aiming points on the same unseen scenarios",
                    f"{_LEARNING}.evaluation.evaluate_policies",
                ),
                "widths": Leaf(
                    "nominal aiming points, moved inwards and outwards", f"{_LEARNING}.policies.measure_widths"
                ),
                "speedup": Leaf("what a surrogate saves in an episode", f"{_LEARNING}.policies.measure_speedup"),
            },
            alone=Leaf("the same as evaluate policies", f"{_LEARNING}.evaluation.evaluate_policies"),
        ),
        "campaign": Group(
            "fly many missions; one row each in a Parquet or CSV file",
            {
                "random": Leaf("the debris anywhere within the mission's bounds", _CAMPAIGNS, "RANDOM"),
                "attitude": Leaf("the debris' long axis over the whole sphere", _CAMPAIGNS, "ATTITUDE"),
                "tumble": Leaf("the debris tumbles about axes over the whole sphere", _CAMPAIGNS, "TUMBLE"),
                "loss": Leaf("one unit is lost in flight: any of them, at any time", _CAMPAIGNS, "LOSS"),
                "file": Leaf("the scenarios of a file", _CAMPAIGNS, "FILE"),
                "sweep": Leaf(
                    "the same scenarios under different settings of control or winch", f"{_LEARNING}.campaigns.sweep"
                ),
                "table": Leaf("statistics of outcomes files", _CAMPAIGNS, "TABLE"),
                "plot": Leaf("a map of outcomes files", _CAMPAIGNS, "PLOT"),
                "report": Leaf(
                    "a page of outcomes files: table, maps, flights", "tethernet_bringup.report.campaign_command"
                ),
            },
        ),
        "data": Group(
            "data sets for surrogates",
            {
                "make": Leaf("fly scenarios with widely spread aiming points", f"{_LEARNING}.data.make_data"),
                "repeatability": Leaf(
                    "how often a capture ends alike, moved by 1e-6 m", f"{_LEARNING}.data.measure_repeatability"
                ),
            },
        ),
        "train": Group(
            "train policies and surrogates",
            {
                "policy": Leaf("a policy for the aiming points, with PPO", f"{_LEARNING}.policies.train_policy"),
                "surrogate": Leaf("surrogates of the capture, from data", f"{_LEARNING}.surrogates.train_surrogate"),
                "offsets": Leaf(
                    "one set of offsets for all debris positions, with CMA-ES", f"{_LEARNING}.policies.optimise_offsets"
                ),
                "references": Leaf("the reward's constants, measured anew", f"{_LEARNING}.policies.measure_references"),
            },
        ),
        "models": Group(
            "the shipped models",
            {
                "install": Leaf("put a model in its place, with its card", f"{_LEARNING}.evaluation.install_model"),
                "convert": Leaf("bring older models to the present format", f"{_LEARNING}.evaluation.convert_model"),
                "cards": Leaf("measure them anew, write their cards", f"{_LEARNING}.evaluation.renew_cards"),
            },
        ),
        "analyse": Leaf("table, pictures and a report from a mission's bag", "tethernet_bringup.analysis.subcommand"),
        "view": Leaf("show the bag of a mission in three dimensions", "tethernet_bringup.view.subcommand"),
        "salvage": Leaf("rewrite a torn bag into a whole one", "tethernet_bringup.bags.salvage"),
        "systems": Group(
            "descriptions of systems",
            {
                "list": Leaf("the shipped ones, a line each", "tethernet_bringup.cli.systems", "LIST"),
                "show": Leaf("what a description comes to", "tethernet_bringup.cli.systems", "SHOW"),
                "check": Leaf("all mistakes of a description", "tethernet_bringup.cli.systems", "CHECK"),
                "draw": Leaf("a picture of net, units and debris", "tethernet_bringup.cli.systems", "DRAW"),
            },
        ),
        "validate": Group(
            "compare the engine with solutions and figures of others",
            {
                "convergence": Leaf(
                    "how far captures depend on step, contact, friction and threads",
                    f"{_LEARNING}.campaigns.convergence",
                ),
            },
            Leaf("compare the engine with solutions and figures of others", "tethernet_sim.validation.command"),
        ),
        "check-driver": Leaf("check the driver of a unit against the contract", "tethernet_control.check_driver"),
    },
)  # fmt: skip


def find(words: Sequence[str]) -> tuple[Leaf | Group, str, list[str]]:
    """What words choose.

    Args:
        words: behind ``tethernet``.

    Returns:
        The sub-command, its full name, and the words behind it; a group where the words end in one or go on with an
        option.

    Raises:
        InputError: for a word that names nothing.
    """
    node: Leaf | Group = TREE
    program, rest = PROGRAM, list(words)
    while isinstance(node, Group):
        if node.alone is not None and (not rest or rest[0] not in node.members):
            return node.alone, program, rest
        if not rest or rest[0].startswith("-"):
            break
        name = rest.pop(0)
        if name not in node.members:
            raise InputError(f"{name}: no such command{_near(name, node)}; allowed: {', '.join(node.members)}")
        node, program = node.members[name], f"{program} {name}"
    return node, program, rest


def _near(word: str, node: Group) -> str:
    """A hint at the command that was probably meant: of this group, or else of any."""
    if word == "help":
        return " (did you mean --help?)"
    if near := near_match(word, node.members):
        return near
    full = {name.rpartition(" ")[2]: name for name, _ in leaves()}
    for old in (word, word.rpartition("_")[2]):
        if match := near_match(old, full):
            last = match.removeprefix(" (did you mean ").removesuffix("?)")
            return f" (did you mean {full[last]}?)"
    return ""


def leaves(group: Group = TREE, program: str = PROGRAM) -> Iterator[tuple[str, Leaf]]:
    """All sub-commands below a group, each with its full name."""
    for name, member in group.members.items():
        if isinstance(member, Group):
            if member.alone is not None:
                yield f"{program} {name}", member.alone
            yield from leaves(member, f"{program} {name}")
        else:
            yield f"{program} {name}", member


def overview(group: Group, program: str) -> str:
    """The help of a group: a line for each sub-command."""
    lines = [
        f"usage: {program} COMMAND ...", "", group.summary[0].upper() + group.summary[1:].rstrip(".") + ".", "",
    ]  # fmt: skip
    names: list[tuple[str, str]] = []
    for name, member in group.members.items():
        names.append((f"  {name}", member.summary))
        if isinstance(member, Group):
            names += [(f"    {below}", leaf.summary) for below, leaf in member.members.items()]
    width = max(len(name) for name, _ in names) + 2
    lines += [f"{name:{width}}{summary}" for name, summary in names]
    lines += ["", f"{program} COMMAND --help says more, with examples."]
    if group is TREE:
        lines += ["A mission over ROS 2 is flown by python run_mission.py."]
    return "\n".join(lines)
