"""Whether this process has been asked to stop: one account for the signal handlers and for what a node does meanwhile.

A node is made of dozens of endpoints, each a call into the middleware of which nothing in Python gets out. While others
enter and leave the graph on the same cores such a call takes tenths of a second, all together seconds: longer than
anybody waits for a process that was asked to end. Whoever is killed in such a call can die with a lock in shared
memory on which all others then wait. So a request is looked for before each.
"""

from __future__ import annotations

from rclpy.executors import ExternalShutdownException

_requests = 0


def note(_number: int, _frame: object) -> None:
    """Take note of a request; a handler of signals."""
    global _requests
    _requests += 1


def requests() -> int:
    """How often this process was asked to stop."""
    return _requests


def leave_if_asked() -> None:
    """Called before another endpoint is made.

    Raises:
        ExternalShutdownException: when this process is to stop: :func:`tethernet_ros.executor.run` then leaves the
            graph.
    """
    if _requests:
        raise ExternalShutdownException
