"""Tasks on a Ray cluster."""

from __future__ import annotations

import itertools
import socket
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from tethernet_core.errors import FaultError
from tethernet_learning.source_digest import source_digest

Task = TypeVar("Task")
Result = TypeVar("Result")

RETRIES = 5
"""So often a task is done again when the process or the machine that had it has died."""
_AHEAD = 3
"""Tasks given out for each core of the cluster, so that none waits for work."""
_CONNECT_S = 5.0  # [s]


class ClusterError(FaultError):
    """A cluster cannot be used: why, and what to do."""


def run_on(address: str, function: Callable[[Task], Result], tasks: Sequence[Task]) -> Iterator[Result]:
    """Call a function for every task.

    Args:
        address: of the cluster: HOST:PORT, ray://HOST:PORT or auto.
        function: importable by its name; takes one core.
        tasks: can be pickled, like the results.

    Yields:
        The results in the order of the tasks, each as soon as it and all before it are there. What a dying process or
        machine had in hand is done again by another.

    Raises:
        ClusterError: when the cluster cannot be used.
    """
    ray = _connect(address)
    try:
        yield from _results(ray, function, tasks)
    finally:
        # Ends what is still under way with the job. To cancel each task races with its end, which aborts Ray's core and
        # with it this process (ray-project/ray pull request 54798 mends one such race).
        ray.shutdown()


def _connect(address: str) -> Any:
    try:
        import ray
    except ImportError as error:
        raise ClusterError(
            f"--cluster needs Ray ({error}); install it with python3 -m bootstrap cluster, or with pip from "
            "requirements/cluster.txt, on every machine of the cluster"
        ) from error
    advice = "start one with  ray start --head --port=6379  and give HOST:PORT of that machine"
    _check_reachable(address, advice)
    try:
        ray.init(address=address, log_to_driver=False, logging_level="error")
    except (ConnectionError, RuntimeError, ValueError, OSError) as error:
        raise ClusterError(f"no Ray cluster can be used at {address}: {error}; {advice}") from error
    return ray


def _check_reachable(address: str, advice: str) -> None:
    """Ray itself waits long for a head that is not there."""
    if address == "auto":
        return
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not (colon and host and port.isdigit()):
        raise ClusterError(f"--cluster {address}: allowed: HOST:PORT, ray://HOST:PORT or auto; {advice}")
    try:
        socket.create_connection((host, int(port)), _CONNECT_S).close()
    except (OSError, OverflowError) as error:
        raise ClusterError(f"nobody answers at {address}: {error}; {advice}") from error


def _results(ray: Any, function: Callable[[Task], Result], tasks: Sequence[Task]) -> Iterator[Result]:
    call = ray.remote(num_cpus=1, max_retries=RETRIES)(_call)
    ahead = _AHEAD * max(1, int(ray.cluster_resources().get("CPU", 1)))
    digest = source_digest()
    given = (call.remote(function, task, digest) for task in tasks)
    pending = deque(itertools.islice(given, ahead))
    try:
        while pending:
            yield ray.get(pending[0])
            pending.popleft()
            pending.extend(itertools.islice(given, 1))
    except ray.exceptions.RayTaskError as error:
        raise error.cause from error
    except ray.exceptions.RayError as error:
        raise ClusterError(f"the cluster has failed: {type(error).__name__}: {error}") from error


def _call(function: Callable[[Task], Result], task: Task, expected_code: str) -> Result:
    """One task, in a process of the cluster."""
    if source_digest() != expected_code:
        raise ClusterError(
            f"{socket.gethostname()} has other sources than the machine that asks; bring both to the same commit"
        )
    from tethernet_sim import cores  # numba behind it takes half a second, and a command's help needs none of it

    cores.use(1)  # one core of the cluster for each task
    return function(task)
