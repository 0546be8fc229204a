"""What the commands that fly many episodes have in common: options from a dataclass, the source, the facts."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path
from typing import Any, TypeVar

from tethernet_core.errors import InputError
from tethernet_core.subcommand import Parser, whole_number
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning import assumed_numbers
from tethernet_learning.flight_settings import Flight, settings_fingerprint
from tethernet_learning.policies import capture_sources as sources
from tethernet_learning.policies.episode_settings import EpisodeSettings
from tethernet_learning.policies.ppo import BASELINES
from tethernet_learning.policies.reward import REFERENCES_FILE, VARIANTS, Reward, references
from tethernet_planner.inference import model_file, task
from tethernet_planner.inference.surrogate_file import NOISES, Surrogate
from tethernet_planner.inference.task import aimed_task_of
from tethernet_sim.fly import Settings

S = TypeVar("S", bound=EpisodeSettings)

_CHOICES = {
    "reward": VARIANTS,
    "symmetry": task.SYMMETRIES,
    "source": (sources.SURROGATE, sources.FULL),
    "noise": NOISES,
    "assumed": assumed_numbers.CHOICES_OF_TRAINING,
    "baseline": BASELINES,
}


def add(parser: Parser, settings: type) -> None:
    """Make every field of a dataclass of settings an option, and add those of the run itself."""
    for field in dataclasses.fields(settings):
        flag, choices = f"--{field.name.replace('_', '-')}", _CHOICES.get(field.name)
        if field.name == "system":
            add_system(parser)
        elif isinstance(field.default, bool):
            parser.add_argument(flag, action="store_true")
        elif field.name == "seed":
            parser.add_argument(flag, type=whole_number(0), default=field.default, metavar="N", help="default 0")
        else:
            kind, text = type(field.default), f"default {field.default}"
            metavar = None if choices else {int: "N", float: "X"}.get(kind)
            parser.add_argument(
                flag, type=kind, default=field.default, choices=choices, metavar=metavar, help=text
            )  # fmt: skip
    parser.add_argument("--surrogate", type=Path, metavar="FILE", help="needed with --source surrogate")
    parser.add_argument(
        "--references", type=Path, default=REFERENCES_FILE, metavar="FILE.json",
        help="constants of the reward, of tethernet train references; default: those that are shipped",
    )  # fmt: skip
    parser.add_argument("--output", type=Path, required=True, metavar="FOLDER", help="of this run")


def settings_of(options: argparse.Namespace, settings: type[S]) -> S:
    """Settings from the options that :func:`add` has made of them.

    Raises:
        InputError: for values that cannot be used.
    """
    if options.source == sources.SURROGATE and options.surrogate is None:
        raise InputError("--source surrogate needs --surrogate FILE")
    system = chosen_system(options)
    names = [field.name for field in dataclasses.fields(settings) if field.name != "system"]
    try:
        made = settings(system=system, **{name: getattr(options, name) for name in names})
    except ValueError as error:
        raise InputError(str(error)) from error
    aimed_task_of(system)  # there must be units
    return made


def prepare(
    settings: EpisodeSettings, surrogate_file: Path | None, references_file: Path = REFERENCES_FILE
) -> tuple[sources.Source, Reward, dict[str, Any]]:
    """Source, reward and all that the run's result depends on.

    Warns where the reward's constants or the surrogate are older than the control or the physics.

    Args:
        settings: with ``system``, ``reward``, ``source`` and ``noise``.
        surrogate_file: for ``source`` surrogate.
        references_file: constants of the reward.

    Raises:
        ValueError: for a wrong name.
        ModelFileError: for a wrong surrogate.
    """
    system = settings.system
    flights = Settings.load(system)
    file = surrogate_file if settings.source == sources.SURROGATE else None
    reward = Reward.load(system, settings.reward, references_file)
    source = sources.make(settings.source, flights, file, settings.noise)
    if settings.assumed != assumed_numbers.AS_DESCRIBED:
        kind = sources.RandomlyAssumed if settings.assumed == assumed_numbers.RANDOM else sources.AssumedAtEnds
        source = kind(source, Flight(system, flights))
        if file:
            print(
                "warning: the surrogate knows captures with the described numbers only; --source full changes them "
                "for captures too",
                file=sys.stderr,
            )
    fingerprint = settings_fingerprint(flights)
    if references(references_file)[system.name].get("flight_parameters") != fingerprint:
        print(
            "warning: the reward's constants were measured with other flight parameters; "
            "tethernet train references measures them anew",
            file=sys.stderr,
        )
    if file:
        surrogate = Surrogate.load(file)
        surrogate.check_system(system)
        if surrogate.about.get("flight_parameters") != fingerprint:
            print("warning: the surrogate was trained with other flight parameters", file=sys.stderr)
    facts = {
        "settings": settings.as_json(),
        "system_digest": system.digest,
        "reward": reward.as_json(),
        "flight_parameters": fingerprint,
        "surrogate": model_file.file_fingerprint(file) if file else None,
    }
    return source, reward, facts
