"""``ros2`` in an environment of wheels: the stock command, in any terminal."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

GRAPH_COMMANDS = {"node", "param", "service", "topic"}
"""They ask for nodes and topics, and by default they ask the daemon."""

START_S = 15.0
ALONE = {"-h", "--help", "--no-daemon"}
DISCOVERY_S = 5.0
"""A daemon that was just started gets so long at most to find who is there."""

DAEMONS_OWN = {"/parameter_events", "/rosout"}
SETTLED_S = 0.5
"""Nobody new was found for so long: who is there has been found."""


def main() -> int | None:
    """Run the stock command as if its ROS 2 were sourced."""
    wanted = environment(os.environ)
    if any(wanted.get(name) != os.environ.get(name) for name in ("LD_LIBRARY_PATH", "PYTHONPATH")):
        os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], wanted)  # they count at a program's start
    os.environ.clear()
    os.environ.update(wanted)
    if asks_for_the_graph(sys.argv[1:]):
        _start_daemon(sys.argv[1:])
    from ros2cli.cli import main as stock

    return stock()


def environment(given: Mapping[str, str]) -> dict[str, str]:
    """Variables of the command: what its environment needs, without what another ROS 2 has set.

    A workspace that was built for this environment and sourced is kept, so that `ros2 run` finds its programs.
    """
    root = json.loads(Path(sys.prefix, "setup.json").read_text(encoding="utf-8"))["root"]
    sys.path.append(root)
    from bootstrap import ros, runtime
    from bootstrap.places import Places

    sys.path.remove(root)
    workspace = "" if ros.sourced(given) else given.get("AMENT_PREFIX_PATH", "")
    rest = given if ros.sourced(given) else {name: given[name] for name in given if name not in runtime.OTHER_ROS}
    result = runtime.environment(Places(Path(root), Path(sys.prefix)), rest)
    prefixes = [prefix for prefix in workspace.split(os.pathsep) if prefix and prefix != sys.prefix]
    return result | {"AMENT_PREFIX_PATH": os.pathsep.join([*prefixes, sys.prefix])}


def asks_for_the_graph(words: Sequence[str]) -> bool:
    """Whether a command line asks the daemon for nodes and topics."""
    return len(words) > 1 and words[0] in GRAPH_COMMANDS and not ALONE & set(words)


def _start_daemon(words: Sequence[str]) -> None:
    """Have a daemon that knows who is there: without one the first command would look for half a second only."""
    from ros2cli.node.daemon import DaemonNode, is_daemon_running, spawn_daemon

    try:
        if is_daemon_running(None) or not spawn_daemon(None, timeout=START_S):
            return
        with DaemonNode(None) as daemon:
            if not daemon.connected:
                return
            named = {word for word in words if word.startswith("/")} if words[0] == "topic" else set()
            begin = news = time.monotonic()
            known: set[str] = set()
            while (now := time.monotonic()) - begin < DISCOVERY_S:
                found = {name for name, _ in daemon.get_topic_names_and_types()} - DAEMONS_OWN
                if found != known:
                    known, news = found, now
                elif known and named <= known and now - news > SETTLED_S:
                    return
                time.sleep(0.05)
    except (OSError, RuntimeError):
        return  # the stock command looks on its own then
