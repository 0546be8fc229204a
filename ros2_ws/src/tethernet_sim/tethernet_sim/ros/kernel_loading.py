"""Loading the kernels beside the making of the simulator's node.

A signal has its turn meanwhile: the compiler works in a thread of its own, which is left to itself where the process
has to end.
"""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Sequence
from threading import Thread

from tethernet_core.parameters import ParameterError, defaults, load, read_yaml
from tethernet_core.system import load_system
from tethernet_ros.executor import outlast
from tethernet_sim.settings import PhysicsParameters, ScenarioParameters
from tethernet_sim.warm_up import load_kernels

NET_CONTACT = "net_contact"
"""The parameter of the physics that kernels hang on."""


class KernelLoading:
    """Loads every kernel that a flight needs from now on; says so where they have to be compiled."""

    def __init__(self, args: Sequence[str]):
        """Args:
        args: command line of the simulator's process, which names the system.
        """
        self._args = args
        self._error: Exception | None = None
        self._thread = Thread(target=self._load, name="kernels", daemon=True)
        self._thread.start()

    def wait(self) -> None:
        """Wait until all are there.

        Raises:
            ExternalShutdownException: when a signal asks to stop meanwhile.
            Exception: why they cannot be loaded.
        """
        outlast(self._thread)
        if self._error is not None:
            raise self._error

    def leave(self, status: int) -> None:
        """End the process where they are still being loaded: the interpreter cannot end beside a compiler at work.

        Args:
            status: its exit status.
        """
        if self._thread.is_alive():
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)

    def _load(self) -> None:
        try:
            system = load_system(str(named(self._args, "system", defaults(ScenarioParameters)["system"])))
            physics = system.parameters.get("physics", {})
            contact = named(self._args, NET_CONTACT, physics.get(NET_CONTACT))
            given = physics if contact is None else {**physics, NET_CONTACT: contact}
            load_kernels(lambda text: print(text, flush=True), system, load(PhysicsParameters, given))
        except ParameterError:
            pass  # the node finds the same, and says so
        except Exception as error:  # told by whoever waits
            self._error = error


def named(args: Sequence[str], entry: str, default: object) -> object:
    """What the command line gives for a parameter, itself or in a parameter file: before the node is, which reads all.

    Args:
        args: the command line.
        entry: name of the parameter.
        default: where it is not given.

    Raises:
        ParameterError: when a parameter file cannot be read.
    """
    value = default
    for word, following in itertools.pairwise([*args, ""]):
        if word == "--params-file":
            given = read_yaml(following)
            value = given.get("/**", {}).get(entry, value)
            value = given.get("sim", {}).get(entry, value)
        elif word.startswith(f"{entry}:="):
            value = word.removeprefix(f"{entry}:=")
    return value
