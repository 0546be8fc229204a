"""What all tests share: a ROS_DOMAIN_ID that no other test on this machine uses."""

from __future__ import annotations

import contextlib
import fcntl
import os
import random
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

os.environ.setdefault("HOME", tempfile.gettempdir())  # rcl's log folder
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ.pop("ROS_LOCALHOST_ONLY", None)

# Whatever this process was told to ignore, by nohup or a shell's background: its children are to obey.
signal.signal(signal.SIGINT, signal.default_int_handler)
for _number in (signal.SIGHUP, signal.SIGQUIT, signal.SIGTERM):
    signal.signal(_number, signal.SIG_DFL)

_DOMAINS = range(1, 101)
"""Above 101 the ports of DDS run into those that Linux hands out to anybody."""


@pytest.fixture
def domain_id(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A ROS_DOMAIN_ID for this test alone, also set in the environment."""
    with _free_domain() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        yield domain


@pytest.fixture(scope="module")
def module_domain_id() -> Iterator[int]:
    """A ROS_DOMAIN_ID for what the tests of a module share."""
    with _free_domain() as domain:
        yield domain


@contextlib.contextmanager
def _free_domain() -> Iterator[int]:
    """Reserves a domain by a lock on a file: tests that run at the same time, in whatever process, never share one."""
    folder = Path(tempfile.gettempdir()) / f"tethernet_test_domains_{os.getuid()}"
    folder.mkdir(exist_ok=True)
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        with open(folder / str(domain), "w", encoding="ascii") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    pytest.fail("all ROS_DOMAIN_IDs from 1 to 100 are in use by tests")
