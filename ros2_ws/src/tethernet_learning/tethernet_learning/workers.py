"""Many tasks one after the other: on this machine, or on the machines of a Ray cluster, behind the same function."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from tethernet_learning.ray_workers import ClusterError, Result, Task, run_on

__all__ = ["HELP", "ClusterError", "run"]

HELP = "fly on this Ray cluster (HOST:PORT of its head, ray://HOST:PORT from outside, or auto) instead of this machine"
"""For command lines."""


def run(function: Callable[[Task], Result], tasks: Sequence[Task], cluster: str | None = None) -> Iterator[Result]:
    """Call a function for every task.

    Args:
        function: importable by its name, and so are its parts; a task gives the same result wherever it runs. On this
            machine it takes all cores itself, on a cluster it gets one.
        tasks: can be pickled, like the results.
        cluster: address of a Ray cluster; None for this machine.

    Yields:
        The results in the order of the tasks, each as soon as it and all before it are there. What a dying process or
        machine of the cluster had in hand is done again by another.

    Raises:
        ClusterError: when the cluster cannot be used.
    """
    if cluster is None:
        yield from map(function, tasks)
        return
    yield from run_on(cluster, function, tasks)
