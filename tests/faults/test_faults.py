"""A short campaign of faulted missions; the long one is ``python -m tests.faults --missions 500 --output FOLDER``."""

import pytest

from . import isolation
from .__main__ import fly
from .kinds import CATALOGUE

WHY_NOT = isolation.missing()
SHORT = ("essential node hangs", "controller killed", "command killed", "hostile topics", "bag cut", "second mission")
"""Kinds that CI flies."""


def seeds(kinds) -> list[int]:
    """One mission of each kind."""
    names = [kind.name for kind in CATALOGUE]
    return [names.index(kind) + len(CATALOGUE) for kind in kinds]


@pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT)
@pytest.mark.parametrize("seed", seeds(SHORT), ids=SHORT)
def test_a_faulted_mission_keeps_its_promises(seed, tmp_path):
    result = fly(seed, tmp_path)
    assert result["injected"] or CATALOGUE[seed % len(CATALOGUE)].inject is None
    assert result["broken"] == []
