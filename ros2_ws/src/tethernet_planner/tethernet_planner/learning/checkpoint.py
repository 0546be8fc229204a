"""The state of a training between two updates, complete: gone on with, it does what it would have done."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np

from tethernet_control import atomic_file

_KEPT = 2
_MODEL, _RANDOM = "model.zip", "random.json"


def save(folder: Path, model) -> None:
    """Write a checkpoint and remove all but the newest two.

    Args:
        folder: of the checkpoints.
        model: a stable-baselines3 PPO between two updates.
    """
    import torch

    partial = folder / "partial"
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    model.save(partial / _MODEL)
    kind, keys, position, has_gauss, gauss = np.random.get_state()  # noqa: NPY002 - what stable-baselines3 draws from
    state = {
        "torch": torch.get_rng_state().tolist(),
        "numpy": [kind, keys.tolist(), position, has_gauss, gauss],
    }
    atomic_file.write_text(partial / _RANDOM, json.dumps(state))
    whole = folder / f"{model.num_timesteps:08d}"
    shutil.rmtree(whole, ignore_errors=True)
    partial.rename(whole)
    for old in _all(folder)[:-_KEPT]:
        shutil.rmtree(old)


def newest(folder: Path) -> Path | None:
    """The newest checkpoint; None where there is none."""
    found = _all(folder)
    return found[-1] if found else None


def load(checkpoint: Path, env):
    """Go back to a checkpoint, the state of all random generators included.

    Returns:
        The PPO, its ``num_timesteps`` the episodes flown.
    """
    import torch
    from stable_baselines3 import PPO

    model = PPO.load(checkpoint / _MODEL, env=env, device="cpu")
    state = json.loads((checkpoint / _RANDOM).read_text(encoding="utf-8"))
    torch.set_rng_state(torch.tensor(state["torch"], dtype=torch.uint8))
    kind, keys, position, has_gauss, gauss = state["numpy"]
    np.random.set_state((kind, np.array(keys, np.uint32), position, has_gauss, gauss))  # noqa: NPY002
    return model


def _all(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("[0-9]*") if path.is_dir())
