"""Training of the surrogates that are neural networks, with torch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tethernet_learning.surrogates.surrogate_training import FOLDS, Material
from tethernet_planner.inference import networks
from tethernet_planner.inference.net_features import NUMBERS, sector_nodes

if TYPE_CHECKING:
    import torch

HIDDEN = (500, 300)
"""Units of the hidden layers (paper)."""


@dataclass(frozen=True)
class NetworkTraining:
    """Hyper-parameters."""

    model: str
    """rnn or mlp."""
    learning_rate: float
    epochs: int
    members: int = FOLDS
    """How many are trained, each without another part of the data."""
    batch: int = 32
    """[A]: the paper does not say."""
    weight_decay: float = 0.0
    dropout: float = 0.0
    """Share of the hidden units left out at a time."""
    mirror: bool = False
    """Show every scenario in a randomly chosen image under the scene's symmetries."""
    decay: bool = False
    """The learning rate falls to nothing along a half cosine."""


PRESETS = {
    "rnn-paper": NetworkTraining("rnn", 1e-5, 500, members=1),
    "rnn": NetworkTraining("rnn", 5e-4, 150, weight_decay=0.05, dropout=0.3, mirror=True, decay=True),
    "mlp": NetworkTraining("mlp", 5e-4, 150, weight_decay=0.05, dropout=0.3, mirror=True, decay=True),
}
"""By name; ``rnn-paper`` has the paper's learning rate and epochs."""


def train(
    training: NetworkTraining, material: Material, seed: int, tell: Callable[[int, str], None]
) -> dict[str, np.ndarray]:
    """Train a network; the epoch with the least loss on the part held back counts.

    Args:
        training: hyper-parameters.
        material: data.
        seed: of weights and order; one seed gives one network.
        tell: called after every epoch with (epochs done, what to tell).

    Returns:
        The network's arrays, see :mod:`.networks`.
    """
    import torch

    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    recurrent, sectors = training.model == "rnn", sector_nodes(material.system)

    def shown(rows: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(networks.sector_inputs(rows, sectors) if recurrent else rows)

    width = NUMBERS * sectors.shape[1] if recurrent else material.inputs.shape[1]
    network = _Recurrent(width, training.dropout) if recurrent else _Dense(width, training.dropout)
    module = network.module
    optimiser = torch.optim.AdamW(module.parameters(), training.learning_rate, weight_decay=training.weight_decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, training.epochs)
    held, held_targets = shown(material.held_inputs), torch.from_numpy(material.held_targets)
    inputs, targets = shown(material.inputs), torch.from_numpy(material.targets)
    least, best = np.inf, network.arrays()
    for epoch in range(training.epochs):
        module.train()
        if training.mirror:
            inputs = shown(material.mirrored(random.integers(len(material.images), size=len(material.inputs))))
        for batch in np.array_split(random.permutation(len(inputs)), -(-len(inputs) // training.batch)):
            optimiser.zero_grad()
            _loss(network.outputs(inputs[batch]), targets[batch]).backward()
            optimiser.step()
        if training.decay:
            schedule.step()
        module.eval()
        with torch.no_grad():
            loss = float(_loss(network.outputs(held), held_targets))
        if loss < least:
            least, best = loss, network.arrays()
        tell(epoch + 1, f"validation loss {loss:.3f}, least {least:.3f}")
    return best


def _loss(outputs: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
    """Squared errors of the standardised numbers plus the cross entropy of "captured"."""
    from torch.nn import functional

    numbers = functional.mse_loss(outputs[:, :3], targets[:, :3], reduction="none").mean(dim=0).sum()
    return numbers + functional.binary_cross_entropy_with_logits(outputs[:, 3], targets[:, 3])


def _plain(parameter: torch.Tensor) -> np.ndarray:
    return parameter.detach().numpy().copy()


class _Dense:
    """Dense layers with tanh."""

    def __init__(self, inputs: int, dropout: float):
        from torch import nn

        sizes = (inputs, *HIDDEN)
        hidden = [
            layer
            for narrow, wide in zip(sizes[:-1], HIDDEN, strict=True)
            for layer in (nn.Linear(narrow, wide), nn.Tanh(), nn.Dropout(dropout))
        ]
        self.module = nn.Sequential(*hidden, nn.Linear(HIDDEN[-1], 4))

    def outputs(self, inputs: torch.Tensor) -> torch.Tensor:
        return self.module(inputs)

    def arrays(self) -> dict[str, np.ndarray]:
        layers = [layer for layer in self.module if hasattr(layer, "weight")]
        weights = {f"weight_{k}": _plain(layer.weight) for k, layer in enumerate(layers)}
        return weights | {f"bias_{k}": _plain(layer.bias) for k, layer in enumerate(layers)}


class _Recurrent:
    """Two recurrent layers with tanh, a linear one on the last state."""

    def __init__(self, inputs: int, dropout: float):
        from torch import nn

        first, second = HIDDEN
        self.module = nn.ModuleDict(
            {
                "0": nn.RNN(inputs, first, batch_first=True),
                "1": nn.RNN(first, second, batch_first=True),
                "out": nn.Linear(second, 4),
                "drop": nn.Dropout(dropout),
            }
        )

    def outputs(self, inputs: torch.Tensor) -> torch.Tensor:
        drop = self.module["drop"]
        states, _ = self.module["0"](inputs)
        states, _ = self.module["1"](drop(states))
        return self.module["out"](drop(states[:, -1]))

    def arrays(self) -> dict[str, np.ndarray]:
        arrays = {"weight_0": _plain(self.module["out"].weight), "bias_out": _plain(self.module["out"].bias)}
        for k in ("0", "1"):
            layer = self.module[k]
            arrays[f"in_{k}"] = _plain(layer.weight_ih_l0)
            arrays[f"state_{k}"] = _plain(layer.weight_hh_l0)
            arrays[f"bias_{k}"] = _plain(layer.bias_ih_l0 + layer.bias_hh_l0)
        return arrays
