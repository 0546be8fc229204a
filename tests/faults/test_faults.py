"""A short campaign of faulted missions; the long one is ``python -m tests.faults --missions 500 --output FOLDER``."""

import itertools
from pathlib import Path

import pytest

from . import isolation
from .__main__ import fly
from .kinds import CATALOGUE
from .mission import Run

WHY_NOT = isolation.missing()
SHORT = ("essential node hangs", "controller killed", "command killed", "hostile topics", "bag cut", "second mission")
"""Kinds that CI flies."""
IN_HOLD = ("driver killed", "command killed")
"""Those whose fault comes in a hold test."""


def seeds(kinds) -> list[int]:
    """One mission of each kind."""
    names = [kind.name for kind in CATALOGUE]
    return [names.index(kind) + len(CATALOGUE) for kind in kinds]


def seeds_in_hold(kinds) -> list[int]:
    """For each kind the first mission in lock-step whose fault comes in a hold test."""
    found = []
    for kind in kinds:
        missions = (Run(seed, Path()) for seed in itertools.count())
        found.append(next(m.seed for m in missions if (m.kind.name, m.moment, m.pace) == (kind, "hold", "lockstep")))
    return found


@pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT)
@pytest.mark.parametrize(
    "seed", seeds(SHORT) + seeds_in_hold(IN_HOLD), ids=[*SHORT, *(f"{kind} in a hold test" for kind in IN_HOLD)]
)
def test_a_faulted_mission_keeps_its_promises(seed, tmp_path):
    result = fly(seed, tmp_path)
    assert result["injected"] or CATALOGUE[seed % len(CATALOGUE)].inject is None
    assert result["broken"] == []
