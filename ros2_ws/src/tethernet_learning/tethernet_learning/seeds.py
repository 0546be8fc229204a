"""Where the randomness of each use comes from: streams that never overlap.

Every stream is a family of NumPy seed sequences with a spawn key of its own, ``(purpose, number)``. Keys of one number,
which the evaluation command spawns, are a third family.
"""

from __future__ import annotations

import enum
from collections.abc import Iterator

import numpy as np


class Purpose(enum.IntEnum):
    """What random numbers are used for. The numbers are part of every result: never renumber them."""

    SURROGATE_TRAINING = 1
    SURROGATE_TEST = 2
    POLICY_TRAINING = 3
    POLICY_EVALUATION = 4
    OFFSET_OPTIMISATION = 5
    REWARD_REFERENCES = 6
    PREDICTION_NOISE = 7
    ASSUMED_NUMBERS = 8


def sequence(purpose: Purpose, seed: int, number: int) -> np.random.SeedSequence:
    """The seed sequence of one scenario of a stream.

    Args:
        purpose: the stream.
        seed: chosen by the user, not negative.
        number: of the scenario, from 0.
    """
    return np.random.SeedSequence(seed, spawn_key=(int(purpose), number))


def generators(purpose: Purpose, seed: int, begin: int, count: int) -> Iterator[np.random.Generator]:
    """Random generators of the scenarios ``begin`` to ``begin + count - 1`` of a stream."""
    for number in range(begin, begin + count):
        yield np.random.default_rng(sequence(purpose, seed, number))
