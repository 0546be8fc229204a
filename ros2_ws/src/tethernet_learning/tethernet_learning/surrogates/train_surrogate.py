"""Train surrogates on one data set and compare them in one table."""

from __future__ import annotations

import argparse
import dataclasses
import json
import shutil
import time
from pathlib import Path
from typing import Any

from tethernet_core import atomic_file
from tethernet_core.errors import InputError
from tethernet_core.extras import require
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_learning import run_folder
from tethernet_learning.data import data_set
from tethernet_learning.run_progress import Progress
from tethernet_learning.surrogates import surrogate_report, train_networks, train_trees
from tethernet_learning.surrogates.surrogate_scores import scores, with_errors
from tethernet_learning.surrogates.surrogate_training import Material, finish, prepare
from tethernet_planner.inference import model_file
from tethernet_planner.inference.surrogate_file import Surrogate

TREES = "trees"
MODELS = ("rnn-paper", "rnn", "mlp", TREES)
BEST = "surrogate.safetensors"


def train_one(
    name: str, materials: list[Material], seed: int, overrides: dict[str, Any], about: dict[str, Any]
) -> Surrogate:
    """Train one model.

    Args:
        name: one of MODELS.
        materials: data of each member.
        seed: one seed gives one model.
        overrides: hyper-parameters to replace, where the model has them.
        about: facts for the model card.
    """
    began = time.monotonic()
    training = train_trees.TreeTraining() if name == TREES else train_networks.PRESETS[name]
    known = {field.name for field in dataclasses.fields(training)}
    training = dataclasses.replace(training, **{key: v for key, v in overrides.items() if key in known})
    chosen, members = materials[: training.members], []
    for number, material in enumerate(chosen):
        if isinstance(training, train_trees.TreeTraining):
            model, arrays = TREES, train_trees.train(training, material, seed + number)
        else:
            with Progress(f"epochs of {name} {number + 1} of {len(chosen)}", training.epochs) as progress:
                model, arrays = training.model, train_networks.train(training, material, seed + number, progress.tell)
        members.append(arrays)
    facts = {"name": name, "training": dataclasses.asdict(training), "seconds": time.monotonic() - began}
    return finish(model, members, chosen, {**about, **facts})


def plot(path: Path, results: dict[str, dict[str, Any]]) -> None:
    """The calibration of the predicted probability."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 5), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color="0.7")
    for name, r in results.items():
        predicted, observed, count = zip(*r["calibration"], strict=True)
        axes.plot(predicted, observed, marker="o", label=f"{name} ({sum(count)} scenarios)")
    axes.set_xlabel("predicted probability of capture")
    axes.set_ylabel("share captured")
    axes.legend()
    figure.savefig(path, dpi=150)


def run(options: argparse.Namespace) -> None:
    """Train, test, write; prints the table."""
    overrides = {name: value for name in ("epochs", "trees") if (value := getattr(options, name)) is not None}
    files = {split: options.data / f"{split}.parquet" for split in ("train", "test")}
    try:
        data, test = (data_set.read(file) for file in files.values())
        materials = prepare(data, options.seed)
    except ValueError as error:
        raise InputError(str(error)) from error
    require("torch", "sklearn")
    import torch

    torch.set_num_threads(options.torch_threads)
    fingerprints = {split: model_file.file_fingerprint(file) for split, file in files.items()}
    settings = {"command": "train_surrogate", "data": fingerprints, "seed": options.seed, "overrides": overrides}
    run_folder.claim(options.output, settings)
    about = {
        "system": data.system.name,
        "commit": model_file.commit(),
        "seed": options.seed,
        "data": fingerprints,
        "data_seed": data.about["seed"],
        "flight_parameters": data.about["flight_parameters"],
        "train_scenarios": data.scenarios,
        "train_failure_share": data.failures / data.scenarios,
    }
    results = {}
    for name in options.models:
        file = options.output / f"{name}.safetensors"
        if not file.exists():
            surrogate = with_errors(train_one(name, materials, options.seed, overrides, about), test)
            dataclasses.replace(surrogate, about={**surrogate.about, "scores": scores(surrogate, test)}).save(file)
        surrogate = Surrogate.load(file)
        told = {key: surrogate.about[key] for key in ("seconds", "members", "validation_brier")}
        results[name] = {**surrogate.about["scores"], **told}
    # The test decides nothing.
    best = min(results, key=lambda name: results[name]["validation_brier"])
    shutil.copyfile(options.output / f"{best}.safetensors", options.output / BEST)
    text = surrogate_report.table(results, best, about)
    atomic_file.write_text(
        options.output / "report.json", json.dumps({**about, "best": best, "models": results}, indent=2)
    )
    atomic_file.write_text(options.output / "report.md", text)
    plot(options.output / "calibration.png", results)
    print(text)


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add("--data", type=Path, required=True, metavar="FOLDER", help="of tethernet data make")
    add("--output", type=Path, required=True, metavar="FOLDER", help="models, report, plot")
    add(
        "--models", nargs="+", choices=MODELS, default=list(MODELS), metavar="MODEL",
        help=f"of {', '.join(MODELS)}; default all",
    )  # fmt: skip
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of training, default 0")
    add("--epochs", type=whole_number(1), metavar="N", help="instead of each network's own")
    add("--trees", type=whole_number(1), metavar="N", help="instead of the forest's own")
    add("--torch-threads", type=whole_number(1), default=1, metavar="N", help="default 1")


COMMAND = Subcommand(
    "Train surrogates on one data set, test them on unseen scenarios, compare them in one table. Killed and started "
    "again with the same words it keeps the models that are done.",
    ("--data DATA --output SURROGATE", "--data DATA --output SURROGATE --models trees mlp --epochs 40"),
    run, _add_arguments,
)  # fmt: skip
