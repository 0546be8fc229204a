"""Make models of the format before the present one say which system they were made for; their weights stay."""

from __future__ import annotations

import argparse
from pathlib import Path

from tethernet_core import atomic_file
from tethernet_core.subcommand import Parser, Subcommand
from tethernet_core.system import System
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning.policies.episode_settings import learned_task
from tethernet_planner.inference import model_file
from tethernet_planner.inference.model_file import VERSION, MadeFor, ModelFileError
from tethernet_planner.inference.policy_file import KIND as POLICY
from tethernet_planner.inference.policy_file import AimingPolicy
from tethernet_planner.inference.surrogate_file import KIND as SURROGATE
from tethernet_planner.inference.surrogate_file import Surrogate, seen_arrays

_BEFORE = 2
_BOUNDS = ("debris_low_m", "debris_high_m", "offset_limit_m", "step_m")


def convert(file: Path, system: System) -> None:
    """Write a model anew in the present format.

    Args:
        file: a policy or a surrogate of the format before; replaced.
        system: that it was made for. The format before knew the number of units alone; what else it was made for, its
            user has to know.

    Raises:
        ModelFileError: when it is no such model, or does not fit the system.
    """
    arrays, about = model_file.read_any(file, f"allowed: a model of format version {_BEFORE}")
    kind = about.pop("kind", None)
    if about.pop("version", None) != _BEFORE or kind not in (POLICY, SURROGATE):
        raise ModelFileError(f"{file} is no model of format version {_BEFORE}; allowed: those alone")
    if about.get("mus") != system.unit_count:
        raise ModelFileError(f"{file} was made for {about.get('mus')} units, and {system.name} has {system.unit_count}")
    about |= MadeFor.of(system).as_json()
    if kind == POLICY:
        symmetry = about.pop("symmetry", "none")
        task = learned_task(system, "none" if symmetry == "none" else "system").as_json()
        if any(about.get(name) != task[name] for name in _BOUNDS):
            raise ModelFileError(
                f"{file} was trained for {[about.get(name) for name in _BOUNDS]}, and {system.name} has "
                f"{[task[name] for name in _BOUNDS]} ({', '.join(_BOUNDS)})"
            )
        about |= task
    else:
        arrays |= seen_arrays(system)
        about["max_locked_pairs"] = system.closing.max_locked_pairs

    def write_and_load(partial: Path) -> None:
        """It must be whole before it takes the old one's place."""
        model_file.write(partial, kind, arrays, about)
        (AimingPolicy if kind == POLICY else Surrogate).load(partial)

    atomic_file.write_whole(file, write_and_load)


def run(options: argparse.Namespace) -> None:
    """Convert; prints what was."""
    system = chosen_system(options)
    for file in options.files:
        convert(file, system)
        print(f"{file}: for {system.name}, digest {system.digest}")


def _add_arguments(parser: Parser) -> None:
    add_system(parser)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help=f"models of format version {_BEFORE}")


COMMAND = Subcommand(
    f"Bring models of format version {_BEFORE}, which know the number of their units alone, to version {VERSION}, "
    "which carries the system that they were made for. Their weights stay as they are.",
    ("--system zenit_8mu RUN/policy.safetensors",), run, _add_arguments,
)  # fmt: skip
