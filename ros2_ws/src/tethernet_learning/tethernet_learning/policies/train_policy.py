"""Train a policy for the aiming points with PPO."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.extras import require
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_learning import run_folder
from tethernet_learning.policies import capture_sources as sources
from tethernet_learning.policies import checkpoint, history, run_options
from tethernet_learning.policies.ppo import DRAW, PpoSettings, begin_with, export, new_model
from tethernet_learning.policies.reward import Reward
from tethernet_learning.run_progress import Progress
from tethernet_planner.inference import model_file
from tethernet_planner.inference.policy_file import KIND, AimingPolicy

POLICY = "policy.safetensors"
MODEL = "policy.zip"
_CHECKPOINT_EVERY = 2
"""Updates."""


def train(
    folder: Path,
    settings: PpoSettings,
    source: sources.Source,
    reward: Reward,
    about: dict[str, Any],
    first: AimingPolicy | None = None,
) -> Path:
    """Train, or go on training, in a claimed folder.

    Args:
        folder: takes checkpoints, history, TensorBoard's files, the policy.
        settings: hyper-parameters.
        source: flies the episodes.
        reward: judges them.
        about: facts for the model card.
        first: the policy to begin with; None: an untrained one, which aims at the nominal points.

    Returns:
        The policy's file.

    Raises:
        CheckpointError: when the folder's newest checkpoint is damaged.
    """
    from stable_baselines3.common.logger import configure

    from tethernet_learning.policies.training_callback import Recorder
    from tethernet_learning.policies.vec_env import AimingVecEnv

    checkpoints = folder / "checkpoints"
    found = checkpoint.newest(checkpoints)
    begun = int(found.name) if found else 0
    env = AimingVecEnv(
        source, reward, settings.envs, settings.seed, begun, settings.symmetry,
        compare_within_draws=settings.baseline == DRAW,
    )  # fmt: skip
    model = new_model(settings, env)
    if found:
        checkpoint.load(found, model)
    elif first:
        begin_with(model, first)
    model.set_logger(configure(str(folder / "tensorboard"), ["tensorboard"]))
    lines = [line for line in history.read(folder / history.FILE) if line[0] <= begun]
    began = time.monotonic()
    if begun < settings.episodes:
        with Progress(f"episodes of {settings.system.name}", settings.episodes, begun) as progress:
            recorder = Recorder(folder, checkpoints, lines, progress, _CHECKPOINT_EVERY * settings.update_episodes)
            model.learn(settings.episodes - begun, callback=recorder, reset_num_timesteps=False)
        checkpoint.save(checkpoints, model)
    rate = (settings.episodes - begun) / max(time.monotonic() - began, 1e-9)
    history.write(folder / history.FILE, lines)
    history.plot(folder / "history.png", lines, f"Training for {settings.system.name}, seed {settings.seed}")
    model.save(folder / MODEL)
    last = np.array(lines[-max(1, len(lines) // 10) :])
    final = dict(zip(history.COLUMNS[1:], last[:, 1:].mean(axis=0).tolist(), strict=True))
    speed = {"episodes_per_s": rate} if begun < settings.episodes else {}
    export(model, settings, {**about, "last_tenth": final, **speed}).save(folder / POLICY)
    return folder / POLICY


def run(options: argparse.Namespace) -> None:
    """Train; prints the policy's file and what the last tenth of training came to."""
    settings = run_options.settings_of(options, PpoSettings)
    source, reward, facts = run_options.prepare(settings, options.surrogate, options.references)
    first = AimingPolicy.load(options.begin_with) if options.begin_with else None
    if first:
        first.check_system(settings.system)
        facts["begin_with"] = model_file.file_fingerprint(options.begin_with)
    require("torch", "stable_baselines3", "gymnasium", "tensorboard")
    if run_folder.claim(options.output, {"command": "train_policy", **facts}):
        print(f"going on in {options.output}", file=sys.stderr)
    import torch

    torch.set_num_threads(options.torch_threads)
    about = {"method": "ppo", **facts, "commit": model_file.commit()}
    file = train(options.output, settings, source, reward, about, first)
    print(file)
    print(json.dumps(model_file.read(file, KIND)[1]["last_tenth"], indent=2))


def _add_arguments(parser: Parser) -> None:
    run_options.add(parser, PpoSettings)
    parser.add_argument(
        "--begin-with", type=Path, metavar="FILE", help="trained policy to go on from; default: the nominal points"
    )
    parser.add_argument("--torch-threads", type=whole_number(1), default=1, metavar="N", help="default 1")


COMMAND = Subcommand(
    "Train a policy for the aiming points with PPO. Defaults are the paper's. Killed and started again with the same "
    "words it goes on and comes to the same policy.",
    (
        "--mus 8 --surrogate SURROGATE/surrogate.safetensors --output RUN",
        "--mus 4 --source full --reward lean --episodes 1280 --output RUN",
    ),
    run, _add_arguments,
)  # fmt: skip
