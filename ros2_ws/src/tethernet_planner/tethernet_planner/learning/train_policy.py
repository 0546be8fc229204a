"""Train a policy for the aiming points with PPO (``python -m tethernet_planner.learning.train_policy``)."""

from __future__ import annotations

import argparse
import dataclasses
import json
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tethernet_sim.fly import Settings

from . import checkpoint, history, model_file, run_folder, sources, task
from .ppo import PpoSettings, export, new_model
from .progress import Progress
from .reward import VARIANTS, Reward, references
from .surrogate_file import NOISES, Surrogate

POLICY = "policy.safetensors"
MODEL = "policy.zip"
_CHECKPOINT_EVERY = 2
"""Updates."""


def train(folder: Path, settings: PpoSettings, source: sources.Source, reward: Reward, about: dict) -> Path:
    """Train, or go on training, in a claimed folder.

    Args:
        folder: takes checkpoints, history, TensorBoard's files, the policy.
        settings: hyper-parameters.
        source: flies the episodes.
        reward: judges them.
        about: facts for the model card.

    Returns:
        The policy's file.
    """
    from stable_baselines3.common.logger import configure

    from .training_callback import Recorder
    from .vec_env import AimingVecEnv

    checkpoints = folder / "checkpoints"
    found = checkpoint.newest(checkpoints)
    begun = int(found.name) if found else 0
    env = AimingVecEnv(source, reward, settings.envs, settings.seed, begun, settings.symmetry)
    model = checkpoint.load(found, env) if found else new_model(settings, env)
    model.set_logger(configure(str(folder / "tensorboard"), ["tensorboard"]))
    lines = [line for line in history.read(folder / history.FILE) if line[0] <= begun]
    progress = Progress(f"episodes with {settings.mus} MUs", settings.episodes, begun)
    recorder = Recorder(folder, checkpoints, lines, progress, _CHECKPOINT_EVERY * settings.update_episodes)
    began = time.monotonic()
    if begun < settings.episodes:
        model.learn(settings.episodes - begun, callback=recorder, reset_num_timesteps=False)
        checkpoint.save(checkpoints, model)
    rate = (settings.episodes - begun) / max(time.monotonic() - began, 1e-9)
    history.write(folder / history.FILE, lines)
    history.plot(folder / "history.png", lines, f"Training with {settings.mus} MUs, seed {settings.seed}")
    model.save(folder / MODEL)
    last = np.array(lines[-max(1, len(lines) // 10) :])
    final = dict(zip(history.COLUMNS[1:], last[:, 1:].mean(axis=0).tolist(), strict=True))
    speed = {"episodes_per_s": rate} if begun < settings.episodes else {}
    export(model, settings, {**about, "last_tenth": final, **speed}).save(folder / POLICY)
    return folder / POLICY


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tethernet_planner.learning.train_policy",
        description="Train a policy with PPO. Defaults are the paper's. Killed and started again with the same words "
        "it goes on and comes to the same policy.",
    )
    fields = {field.name: field for field in dataclasses.fields(PpoSettings)}
    choices = {
        "mus": (4, 8),
        "reward": VARIANTS,
        "symmetry": task.SYMMETRIES,
        "source": (sources.SURROGATE, sources.FULL),
        "noise": NOISES,
    }
    for name, field in fields.items():
        flag = f"--{name.replace('_', '-')}"
        if name == "rate_decay":
            parser.add_argument(flag, action="store_true")
        elif name == "mus":
            parser.add_argument(flag, type=int, choices=choices[name], required=True)
        else:
            kind, shown = type(field.default), f"default {field.default}"
            parser.add_argument(flag, type=kind, default=field.default, choices=choices.get(name), help=shown)
    parser.add_argument("--surrogate", type=Path, metavar="FILE", help="needed with --source surrogate")
    parser.add_argument("--output", type=Path, required=True, metavar="FOLDER", help="of this training")
    parser.add_argument("--torch-threads", type=int, default=1, metavar="N")
    options = parser.parse_args(argv)
    if options.source == sources.SURROGATE and options.surrogate is None:
        parser.error("--source surrogate needs --surrogate FILE")
    return options


def run_settings(settings, reward: Reward, flights: Settings, surrogate: Path | None) -> dict:
    """All that a training's result depends on; warns where the reward's constants are older than the control."""
    fingerprint = model_file.settings_fingerprint(flights)
    measured = references()[str(reward.mus)]["flight_parameters"]
    if measured != fingerprint:
        print(
            "warning: the reward's constants were measured with other flight parameters; "
            "python -m tethernet_planner.learning.measure_references measures them anew",
            file=sys.stderr,
        )
    if surrogate is not None and Surrogate.load(surrogate).about["flight_parameters"] != fingerprint:
        print("warning: the surrogate was trained with other flight parameters", file=sys.stderr)
    return {
        "settings": dataclasses.asdict(settings),
        "reward": dataclasses.asdict(reward),
        "flight_parameters": fingerprint,
        "surrogate": model_file.file_fingerprint(surrogate) if surrogate else None,
    }


def main(argv: Sequence[str] | None = None) -> int:
    """Train. Returns 0; 2 for bad usage or a folder with another run."""
    options = _arguments(argv)
    names = [field.name for field in dataclasses.fields(PpoSettings)]
    flights = Settings.load()
    surrogate = options.surrogate if options.source == sources.SURROGATE else None
    try:
        settings = PpoSettings(**{name: getattr(options, name) for name in names})
        reward = Reward.load(settings.mus, settings.reward)
        source = sources.make(settings.source, flights, surrogate, settings.noise)
        if surrogate:
            Surrogate.load(surrogate).check_design(settings.mus)
        about = {"method": "ppo", **run_settings(settings, reward, flights, surrogate)}
        if run_folder.claim(options.output, {"command": "train_policy", **about}):
            print(f"going on in {options.output}", file=sys.stderr)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    import torch

    torch.set_num_threads(options.torch_threads)
    if surrogate and not (options.output / "surrogate.safetensors").exists():
        shutil.copyfile(surrogate, options.output / "surrogate.safetensors")
    file = train(options.output, settings, source, reward, {**about, "commit": model_file.commit()})
    print(f"{file}")
    print(json.dumps(model_file.read(file, "policy")[1]["last_tenth"], indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
