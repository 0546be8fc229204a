"""Put a trained model in its place in the package, with its card."""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tethernet_core import atomic_file
from tethernet_core.errors import InputError
from tethernet_core.subcommand import Parser, Subcommand
from tethernet_learning.evaluation.model_card import card
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.model_file import ModelFileError
from tethernet_planner.inference.policy_file import AimingPolicy
from tethernet_planner.inference.surrogate_file import Surrogate

HISTORY = "history.png"
_LOADERS: dict[str, Callable[[Path], AimingPolicy | Surrogate]] = {
    shipped_models.POLICY: AimingPolicy.load,
    shipped_models.SURROGATE: Surrogate.load,
}


def ship(file: Path, evaluation: dict[str, Any] | None = None) -> Path:
    """Check a model, copy it to where its name looks for it, and write its card beside it.

    A picture of its training that lies beside the file comes along.

    Args:
        file: a policy or a surrogate.
        evaluation: content of the evaluation's JSON file, for a policy's card.

    Returns:
        The shipped file.

    Raises:
        ModelFileError: when the file is neither.
        ValueError: when the evaluation is of another policy.
    """
    kind, model = _load(file)
    target = shipped_models.place(kind, model.made_for.system)
    target.parent.mkdir(exist_ok=True)
    picture, beside = target.with_suffix(".png"), file.with_name(HISTORY)
    history = picture.name if beside.is_file() else ""
    text = card(file, kind, model.about, evaluation, history).replace(f"# {file.stem}\n", f"# {target.stem}\n", 1)
    if history:
        shutil.copyfile(beside, picture)
    atomic_file.write_text(target.with_suffix(".md"), text)
    shutil.copyfile(file, target)
    return target


def _load(file: Path) -> tuple[str, AimingPolicy | Surrogate]:
    reasons = []
    for kind, load in _LOADERS.items():
        try:
            return kind, load(file)
        except ModelFileError as error:
            reasons.append(str(error))
    raise ModelFileError(reasons[0] if len(set(reasons)) == 1 else "; ".join(reasons))


def run(options: argparse.Namespace) -> None:
    """Install models; prints their places."""
    try:
        evaluation = json.loads(options.evaluation.read_text(encoding="utf-8")) if options.evaluation else None
        for file in options.files:
            print(ship(file, evaluation))
    except (OSError, ValueError) as error:
        raise InputError(str(error)) from error


def _add_arguments(parser: Parser) -> None:
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="policy.safetensors, surrogate.safetensors")
    parser.add_argument("--evaluation", type=Path, metavar="FILE.json", help="adds a policy's scores to its card")


COMMAND = Subcommand(
    "Put trained models where --policy rl and the assessor's predictor surrogate look for them, each with a model card "
    "written from what its file says of itself.",
    ("RUN/policy.safetensors --evaluation runs/evaluation/evaluation.json",), run, _add_arguments,
)  # fmt: skip
