"""From a script for users to the module that does the work, in an environment that is there by then."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import NoReturn

from . import ros, runtime
from .environment import Interrupted, ensure, pending
from .errors import SetupError
from .places import ros_places, venv_places
from .report import Report
from .steps import PROFILES, ROS_PROFILES

FAULT = 1
QUIET_START = "tethernet_core.quiet_start"


def launch(module: str, profile: str, arguments: str, argv: Sequence[str]) -> NoReturn:
    """Run a module in the environment, by replacing this process; set the environment up before, if need be.

    Args:
        module: what to run, as in ``python -m``.
        profile: which steps of the set-up it needs.
        arguments: module that knows the command line: ``parse(argv)`` with nothing but the standard library, ending
            the process for ``--help`` and bad usage. Used where a set-up would come first, which nobody wants to wait
            for just to read of a typing error.
        argv: the words after the script's name.
    """
    _ours(QUIET_START).open_standard_streams()
    python, environment = prepare((profile,), lambda: _ours(arguments).parse(list(argv)))
    # The module takes these as soon as it can (tethernet_core.command); until then they wait.
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    # -P: a file in the user's working folder must not take the place of a library.
    run_in([python, "-P", "-m", module, *argv], environment)


def prepare(
    profiles: Sequence[str], before: Callable[[], None] = lambda: None, *, fresh: bool = False
) -> tuple[str, dict[str, str]]:
    """Choose the environment and make sure that it is there; ends the process with a message where it cannot be.

    Args:
        profiles: what it is needed for.
        before: called if a set-up has to come first.
        fresh: make it anew.

    Returns:
        The Python to run and its environment variables.
    """
    report = Report()
    try:
        own_ros = _own_ros(os.environ, report)
        places, offered = (ros_places(), ROS_PROFILES) if own_ros else (venv_places(), PROFILES)
        if missing := [profile for profile in profiles if profile not in offered]:
            raise SetupError(
                f"{', '.join(missing)}: needs NumPy 2, and ROS 2 Jazzy of this machine has NumPy 1.26. "
                ".venv with its own ROS 2 does it: TETHERNET_ENVIRONMENT=venv, before this command and the mission's."
            )
        steps = list({step.name: step for profile in profiles for step in offered[profile]}.values())
        if fresh or pending(places, steps):
            before()
            ensure(places, steps, report, fresh=fresh)
        given = _ours(QUIET_START).absolute_search_paths(os.environ)
        return str(places.python), given if own_ros else runtime.environment(places, given)
    except SetupError as error:
        report.say(f"Set-up failed: {error}")
        sys.exit(FAULT)
    except KeyboardInterrupt:
        report.say("Set-up interrupted; the next start goes on with it.")
        sys.exit(128 + signal.SIGINT)
    except Interrupted as interrupted:
        report.say(f"Set-up ended by {signal.Signals(interrupted.signal_number).name}; the next start goes on with it.")
        sys.exit(128 + interrupted.signal_number)


def run_in(command: Sequence[str], environment: Mapping[str, str]) -> NoReturn:
    """Replace this process."""
    sys.stdout.flush()
    sys.stderr.flush()
    os.execve(command[0], list(command), dict(environment))


def _own_ros(given: Mapping[str, str], report: Report) -> bool:
    """Whether the machine's own ROS 2 is to be used; a notice where it is there and not used."""
    distribution = ros.sourced(given)
    if not distribution or given.get("TETHERNET_ENVIRONMENT") == "venv":
        return False
    if distribution != ros.DISTRIBUTION:
        report.say(
            f"ROS 2 {distribution} is sourced, {ros.DISTRIBUTION} is needed: .venv with its own ROS 2 is used instead."
        )
        return False
    unbuilt = ros.unbuilt(given)
    if unbuilt:
        report.say(
            f"ROS 2 {distribution} is sourced, but its workspace lacks {', '.join(unbuilt)}: .venv with its own "
            f"ROS 2 is used instead. To use yours: {ros.BUILD_COMMANDS}"
        )
        return False
    return True


def _ours(module: str) -> ModuleType:
    """A module of the project that needs nothing but the standard library, from its sources: before the set-up."""
    sources = venv_places().sources
    for package in ("tethernet_core", "tethernet_bringup"):
        if str(sources / package) not in sys.path:
            sys.path.insert(0, str(sources / package))
    return importlib.import_module(module)
