"""The forward passes of all models in NumPy: inference needs no torch and no scikit-learn."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tethernet_planner.inference.net_features import NUMBERS

Arrays = Mapping[str, np.ndarray]


def dense_layers(arrays: Arrays) -> int:
    """How many layers a dense network has."""
    return sum(name.startswith("weight_") for name in arrays)


def dense(arrays: Arrays, inputs: np.ndarray) -> np.ndarray:
    """A dense network with tanh between its layers.

    Args:
        arrays: ``weight_k`` of shape (out, in) and ``bias_k`` of shape (out,) for each layer k.
        inputs: shape (n, in of the first layer).

    Returns:
        Shape (n, out of the last layer).
    """
    values, last = inputs, dense_layers(arrays) - 1
    for k in range(last + 1):
        values = values @ arrays[f"weight_{k}"].T + arrays[f"bias_{k}"]
        if k < last:
            values = np.tanh(values)
    return values


def sector_inputs(inputs: np.ndarray, sectors: np.ndarray) -> np.ndarray:
    """The sequence that the recurrent network reads.

    Args:
        inputs: standardised features, shape (n, inputs).
        sectors: see :func:`.net_features.sector_nodes`, shape (steps, width).

    Returns:
        Shape (n, steps, 6 width); zeros where a sector has nothing.
    """
    nodes = inputs.reshape(len(inputs), -1, NUMBERS)
    padded = np.concatenate([nodes, np.zeros((len(nodes), 1, NUMBERS), nodes.dtype)], axis=1)
    return padded[:, sectors].reshape(len(inputs), len(sectors), -1)


def recurrent(arrays: Arrays, steps: np.ndarray) -> np.ndarray:
    """Two recurrent layers with tanh (Elman), then a linear one on the last state.

    Args:
        arrays: ``in_k``, ``state_k``, ``bias_k`` of layers 0 and 1, ``weight_0`` and ``bias_out``.
        steps: shape (n, steps, inputs of a step).

    Returns:
        Shape (n, outputs).
    """
    sequence = steps
    for k in (0, 1):
        driven = sequence @ arrays[f"in_{k}"].T + arrays[f"bias_{k}"]
        state = np.zeros((len(steps), arrays[f"state_{k}"].shape[0]), steps.dtype)
        states = []
        for t in range(steps.shape[1]):
            state = np.tanh(driven[:, t] + state @ arrays[f"state_{k}"].T)
            states.append(state)
        sequence = np.stack(states, axis=1)
    return sequence[:, -1] @ arrays["weight_0"].T + arrays["bias_out"]


def boosted_trees(arrays: Arrays, inputs: np.ndarray) -> np.ndarray:
    """Sums of decision trees on the inputs' principal components and the inputs that are MUs.

    Args:
        arrays: ``components`` of shape (c, inputs); ``direct``, indices of inputs that the trees see as they are;
            ``feature``, ``left``, ``right``, ``threshold``, ``value``, each of shape (outputs, trees, nodes); ``base``
            of shape (outputs,). A leaf's children are itself.
        inputs: shape (n, inputs).

    Returns:
        Shape (n, outputs).
    """
    seen = np.hstack([inputs @ arrays["components"].T, inputs[:, arrays["direct"]]]).astype(np.float32)
    outputs = []
    for k in range(len(arrays["base"])):
        feature, left, right = arrays["feature"][k], arrays["left"][k], arrays["right"][k]
        tree = np.arange(len(feature))
        node = np.zeros((len(seen), len(feature)), int)
        while True:
            below = np.take_along_axis(seen, feature[tree, node], axis=1) <= arrays["threshold"][k][tree, node]
            going_on = np.where(below, left[tree, node], right[tree, node])
            if (going_on == node).all():
                break
            node = going_on
        outputs.append(arrays["base"][k] + arrays["value"][k][tree, node].sum(axis=1))
    return np.stack(outputs, axis=1)
