"""Optimise one set of offsets with CMA-ES."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from tethernet_core.errors import InputError
from tethernet_core.extras import require
from tethernet_core.subcommand import Parser, Subcommand
from tethernet_learning import run_folder
from tethernet_learning.policies import run_options
from tethernet_learning.policies.offset_search import SearchSettings, search
from tethernet_learning.policies.train_policy import POLICY
from tethernet_learning.run_progress import Progress
from tethernet_planner.inference import model_file
from tethernet_planner.inference.policy_file import AimingPolicy


def _add_arguments(parser: Parser) -> None:
    run_options.add(parser, SearchSettings)
    parser.add_argument(
        "--begin-with", type=Path, metavar="FILE",
        help="trained policy that the offsets come on top of; default: the nominal points",
    )  # fmt: skip


def run(options: argparse.Namespace) -> None:
    """Search; prints the policy's file and its offsets."""
    settings = run_options.settings_of(options, SearchSettings)
    source, reward, facts = run_options.prepare(settings, options.surrogate, options.references)
    require("cma")
    first = AimingPolicy.load(options.begin_with) if options.begin_with else None
    if first:
        first.check_system(settings.system)
        if first.task != settings.task:
            raise InputError(f"{options.begin_with} was trained for other bounds or images; --symmetry says which")
        facts["begin_with"] = model_file.file_fingerprint(options.begin_with)
    run_folder.claim(options.output, {"command": "optimise_offsets", **facts})
    flown = settings.generations * settings.scenarios * settings.candidates
    about = {"method": "cma-es", **facts, "commit": model_file.commit()}
    with Progress(f"episodes of {settings.system.name}", flown) as progress:
        policy = search(options.output, settings, source, reward, progress.tell, about, first)
    policy.save(options.output / POLICY)
    print(options.output / POLICY)
    middle = np.add(policy.task.debris_low_m, policy.task.debris_high_m) / 2.0
    shown = ", ".join(f"({x:g}, {y:g})" for x, y in policy.offsets(middle.tolist()).tolist())
    print(f"offsets [m], unit 1 first: {shown}")


COMMAND = Subcommand(
    "Optimise one set of aiming offsets for all debris positions with CMA-ES: a baseline without learning, as a policy "
    "file; or what to add to a trained policy. Killed and started again with the same words it goes on.",
    (
        "--mus 8 --surrogate SURROGATE/surrogate.safetensors --output RUN", "--mus 4 --source full --output RUN",
        "--mus 8 --source full --begin-with P.safetensors --assumed ends --scenarios 72 --output R",
    ),
    run, _add_arguments,
)  # fmt: skip
