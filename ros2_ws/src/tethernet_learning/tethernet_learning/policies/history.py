"""The history of a training: one line for each batch of parallel episodes, and its plot."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core import atomic_file
from tethernet_learning.policies.reward import TERMS

FILE = "history.csv"
COLUMNS = ("episodes", "reward", *(f"term_{name}" for name in TERMS), "captured", "fuel_kg", "mouth_area_m2", "std")
"""Means over a batch: reward, its terms, share captured, total fuel [kg], mouth area [m^2]; ``std``: of the
exploration, actions scaled to [-1, 1]."""


def line(episodes: int, infos: Sequence[dict[str, Any]], std: float) -> list[float]:
    """One line from the infos of :class:`.vec_env.AimingVecEnv`."""
    terms = [np.mean([info["reward_terms"][name] for info in infos]) for name in TERMS]
    rest = [np.mean([info[name] for info in infos]) for name in ("is_success", "fuel_kg", "mouth_area_m2")]
    return [episodes, *(float(value) for value in (sum(terms), *terms, *rest, std))]


def write(path: Path, lines: Sequence[Sequence[float]]) -> None:
    """Write the whole history."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([COLUMNS, *lines])
    atomic_file.write_text(path, text.getvalue())


def read(path: Path) -> list[list[float]]:
    """Read a history; empty where there is none."""
    if not path.exists():
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return [[int(row[0]), *map(float, row[1:])] for row in list(csv.reader(file))[1:]]


def plot(path: Path, lines: Sequence[Sequence[float]], title: str) -> None:
    """The training history as in the paper: the reward averaged over each batch of parallel episodes; below it the
    terms, captures and fuel.
    """
    from matplotlib.figure import Figure

    values = {name: np.array(column) for name, column in zip(COLUMNS, zip(*lines, strict=True), strict=True)}
    figure = Figure(figsize=(8, 10), layout="constrained")
    axes = figure.subplots(4, sharex=True)
    axes[0].set_title(title)
    axes[0].plot(values["episodes"], values["reward"], color="0.7", label="batch")
    window = max(1, len(lines) // 20)
    smooth = np.convolve(values["reward"], np.ones(window) / window, mode="valid")
    axes[0].plot(values["episodes"][window - 1 :], smooth, label=f"mean of {window}")
    axes[0].set_ylabel("reward")
    for name in TERMS:
        axes[1].plot(values["episodes"], values[f"term_{name}"], label=name)
    axes[1].set_ylabel("terms of the reward")
    axes[2].plot(values["episodes"], 100 * values["captured"])
    axes[2].set_ylabel("captured [%]")
    axes[2].set_ylim(min(89.0, 100 * values["captured"].min() - 1.0), 101.0)  # no share is above 100
    axes[3].plot(values["episodes"], 1000 * values["fuel_kg"])
    axes[3].set_ylabel("total fuel [g]")
    axes[3].set_xlabel("episodes")
    for one in axes[:2]:
        one.legend()
    figure.savefig(path, dpi=150)
