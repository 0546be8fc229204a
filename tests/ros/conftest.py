"""Fixtures of the tests that talk over DDS; what they give is in graph.py."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.ros.graph import Probe, Processes
from tethernet_bringup.mission.dds_profile import use_profile


@pytest.fixture(autouse=True)
def profile(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """The nodes that tests start themselves, and the tests' own, talk as those of a mission do."""
    for name, value in use_profile(os.environ, tmp_path_factory.mktemp("dds")).items():
        monkeypatch.setenv(name, value)


@pytest.fixture
def probe(domain_id: int) -> Iterator[Probe]:
    """A node of the test's own, in the test's own domain."""
    node = Probe(domain_id)
    yield node
    node.close()


@pytest.fixture
def processes(domain_id: int, tmp_path: Path) -> Iterator[Processes]:
    """Starts processes in the test's own domain; at the end all are stopped and their exit statuses checked."""
    started = Processes(tmp_path)
    yield started
    started.stop()
