"""Training of the gradient-boosted trees, with scikit-learn."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from tethernet_learning.surrogates.surrogate_training import FOLDS, Material
from tethernet_planner.inference.net_features import NUMBERS


@dataclass(frozen=True)
class TreeTraining:
    """Hyper-parameters."""

    members: int = FOLDS
    """How many are trained, each without another part of the data."""
    components: int = 40
    """Principal components of the inputs that the trees see, beside the MUs."""
    trees: int = 400
    depth: int = 4
    learning_rate: float = 0.05
    subsample: float = 0.7
    mirror: bool = True
    """Learn from all images of every scenario under the scene's symmetries."""


def train(training: TreeTraining, material: Material, seed: int) -> dict[str, np.ndarray]:
    """Train one forest for each output.

    Args:
        training: hyper-parameters.
        material: data.
        seed: one seed gives one model.

    Returns:
        The arrays of :func:`.networks.boosted_trees`.
    """
    from sklearn.ensemble import GradientBoostingClassifier, GradientBoostingRegressor

    images = range(len(material.images) if training.mirror else 1)
    inputs = np.concatenate([material.mirrored(np.full(len(material.inputs), image)) for image in images])
    targets = np.tile(material.targets, (len(images), 1))
    components = _components(material.inputs, training.components)
    direct = np.arange(inputs.shape[1] - NUMBERS * material.system.unit_count, inputs.shape[1])
    seen = np.hstack([inputs @ components.T, inputs[:, direct]]).astype(np.float32)
    options = {
        "n_estimators": training.trees,
        "max_depth": training.depth,
        "learning_rate": training.learning_rate,
        "subsample": training.subsample,
        "max_features": "sqrt",
        "random_state": seed,
    }
    forests, bases = [], []
    for k in range(4):
        model = GradientBoostingClassifier(**options) if k == 3 else GradientBoostingRegressor(**options)
        model.fit(seen, targets[:, k] > 0.5 if k == 3 else targets[:, k])
        trees = [tree.tree_ for tree in model.estimators_[:, 0]]
        whole = (model.decision_function if k == 3 else model.predict)(seen[:1])[0]
        grown = training.learning_rate * sum(tree.predict(seen[:1])[0, 0] for tree in trees)
        forests.append([_Tree.of(tree, training.learning_rate) for tree in trees])
        bases.append(whole - grown)
    nodes = max(len(tree.value) for forest in forests for tree in forest)
    arrays = {
        field.name: np.stack([[tree.padded(field.name, nodes) for tree in forest] for forest in forests])
        for field in dataclasses.fields(_Tree)
    }
    return {**arrays, "components": components, "direct": direct, "base": np.array(bases, np.float32)}


def _components(inputs: np.ndarray, count: int) -> np.ndarray:
    """Principal components, shape (at most count, inputs)."""
    spread = (inputs - inputs.mean(axis=0)).astype(float)
    values, vectors = np.linalg.eigh(spread.T @ spread)
    chosen = np.argsort(values)[::-1][: min(count, len(inputs))]
    return vectors[:, chosen].T.astype(np.float32)


@dataclass(frozen=True)
class _Tree:
    """A decision tree as arrays over its nodes; leaves lead to themselves."""

    feature: np.ndarray
    left: np.ndarray
    right: np.ndarray
    threshold: np.ndarray
    value: np.ndarray

    @classmethod
    def of(cls, tree: Any, learning_rate: float) -> _Tree:
        leaf = tree.children_left < 0
        own = np.arange(len(leaf))
        # What the tree compares is float32; the next float32 below a threshold divides it the same way.
        rounded = tree.threshold.astype(np.float32)
        below = np.nextafter(rounded, np.float32(-np.inf))
        return cls(
            np.where(leaf, 0, tree.feature).astype(np.int16),
            np.where(leaf, own, tree.children_left).astype(np.int16),
            np.where(leaf, own, tree.children_right).astype(np.int16),
            np.where(leaf, 0.0, np.where(rounded > tree.threshold, below, rounded)).astype(np.float32),
            (learning_rate * tree.value[:, 0, 0] * leaf).astype(np.float32),
        )

    def padded(self, name: str, nodes: int) -> np.ndarray:
        values = getattr(self, name)
        return np.concatenate([values, np.zeros(nodes - len(values), values.dtype)])
