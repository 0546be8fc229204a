"""The state of a training between two updates, complete: gone on with, it does what it would have done.

A checkpoint holds numbers alone. The library's own file of a model holds pickled objects, and reading one executes what
is in it; here the model is made anew from the run's settings and takes over weights, optimiser and counters.
"""

from __future__ import annotations

import json
import pickle
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core import atomic_file
from tethernet_core.errors import InputError

_KEPT = 2
_WEIGHTS, _STATE = "weights.pt", "state.json"
_COUNTERS = ("num_timesteps", "_n_updates", "_current_progress_remaining")
"""What PPO counts while it learns."""


class CheckpointError(InputError):
    """A checkpoint is damaged, or was not made by this version: what to do."""


def save(folder: Path, model: Any) -> None:
    """Write a checkpoint and remove all but the newest two.

    Args:
        folder: of the checkpoints.
        model: a stable-baselines3 PPO between two updates.
    """
    import torch

    partial = folder / "partial"
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    torch.save(model.get_parameters(), partial / _WEIGHTS)
    kind, keys, position, has_gauss, gauss = np.random.get_state()  # noqa: NPY002 - what stable-baselines3 draws from
    state = {
        "counters": {name: getattr(model, name) for name in _COUNTERS},
        "torch": torch.get_rng_state().tolist(),
        "numpy": [kind, np.asarray(keys).tolist(), position, has_gauss, gauss],
    }
    atomic_file.write_text(partial / _STATE, json.dumps(state))
    whole = folder / f"{model.num_timesteps:08d}"
    shutil.rmtree(whole, ignore_errors=True)
    partial.rename(whole)
    for old in _all(folder)[:-_KEPT]:
        shutil.rmtree(old)


def newest(folder: Path) -> Path | None:
    """The newest checkpoint; None where there is none."""
    found = _all(folder)
    return found[-1] if found else None


def load(checkpoint: Path, model: Any) -> None:
    """Bring a model to where a checkpoint was taken, and all random generators too. Executes nothing from the files.

    Args:
        checkpoint: its folder.
        model: a stable-baselines3 PPO, untrained, made with the settings of the run; its ``num_timesteps`` are then the
            episodes flown.

    Raises:
        CheckpointError: when the checkpoint does not hold what :func:`save` writes.
    """
    import torch

    try:
        weights = torch.load(checkpoint / _WEIGHTS, map_location="cpu", weights_only=True)
        state = json.loads((checkpoint / _STATE).read_text(encoding="utf-8"))
        model.set_parameters(weights, exact_match=True, device="cpu")
        for name in _COUNTERS:
            setattr(model, name, state["counters"][name])
        torch.set_rng_state(torch.tensor(state["torch"], dtype=torch.uint8))
        kind, keys, position, has_gauss, gauss = state["numpy"]
        np.random.set_state((kind, np.array(keys, np.uint32), position, has_gauss, gauss))  # noqa: NPY002
    except (OSError, EOFError, LookupError, TypeError, ValueError, RuntimeError, pickle.UnpicklingError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise CheckpointError(
            f"{checkpoint} cannot be read as a checkpoint ({reason}); remove it: the training then goes on from an "
            "earlier one, or from its beginning"
        ) from error


def _all(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("[0-9]*") if path.is_dir())
