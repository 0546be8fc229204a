"""Rerun's own program, which shows what recordings send it: a window, or a server for browsers.

It is a process beside the mission's: whoever sends it pictures may have to wait for it, nobody else does. A window
stays open until its user closes it. A server ends with the command that started it, however that ends.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from urllib.parse import quote

from tethernet_bringup.view.arguments import WINDOW, Target
from tethernet_core.errors import FaultError, InputError
from tethernet_core.extras import require

HOST = "127.0.0.1"
"""It is for this machine alone, as the mission's own network is by default."""
WEB_PORT = 9090
"""Of the page for browsers, where it is free."""
START_S = 30.0
"""[s] within which it must listen."""
_STOP_S = 3.0
_POLL_S = 0.05
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
_NICE = 10
"""Its pictures give way to controllers."""
_PR_SET_PDEATHSIG = 1


def check(target: Target, environment: Mapping[str, str] = os.environ) -> None:
    """Make sure that something can be shown, before anything is begun.

    Args:
        target: where to.
        environment: of this process.

    Raises:
        FaultError: when Rerun is not installed: what installs it.
        InputError: for a window where there is no display.
    """
    require("rerun")
    if target.kind == WINDOW and not any(environment.get(name) for name in _DISPLAYS):
        raise InputError(
            f"--view: there is no display for a window ({' and '.join(_DISPLAYS)} are not set); "
            "allowed here: --view web, --view FILE.rrd"
        )


class Application:
    """A running Rerun."""

    def __init__(self, kind: str, memory_mb: int, log: Path | None = None, words: tuple[str, ...] = ()):
        """Start it; returns at once.

        Args:
            kind: WINDOW or WEB.
            memory_mb: most memory for pictures [MB]: the oldest go first.
            log: what it prints; None: nowhere.
            words: more of its command line.

        Raises:
            FaultError: when it cannot be started.
        """
        self.kind = kind
        ports = _free_ports(0 if kind == WINDOW else WEB_PORT)
        self.address = f"rerun+http://{HOST}:{ports[1]}/proxy"
        """Where recordings are sent."""
        self.page = f"http://{HOST}:{ports[0]}/?url={quote(self.address, safe='')}"
        """For browsers, where it serves them."""
        self._port = ports[1]
        command = [_program(), "--bind", HOST, "--port", str(ports[1]), "--server-memory-limit", f"{memory_mb}MB"]
        if kind == WINDOW:
            command += ["--memory-limit", f"{memory_mb}MB", "--hide-welcome-screen", "--expect-data-soon"]
        else:
            command += ["--serve-web", "--web-viewer-port", str(ports[0])]
        # Libraries of the ROS wheels are not for it; nor does it ask for consent where nobody answers.
        environment = {k: v for k, v in os.environ.items() if k not in ("LD_LIBRARY_PATH", "PYTHONPATH")}
        environment["RERUN_APP_ONLY"] = "true"
        try:
            output = open(os.devnull if log is None else log, "wb")  # noqa: SIM115
            with output:
                self._process = subprocess.Popen(
                    [*command, *words], stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                    env=environment, start_new_session=True, preexec_fn=_stays if kind == WINDOW else _ends_with_us(),  # noqa: PLW1509
                )  # fmt: skip
        except OSError as error:
            raise FaultError(f"Rerun cannot be started: {error.strerror or error}") from error

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return self._process.poll() is None

    @property
    def failed(self) -> bool:
        """Whether it has ended by a fault: not because its user has closed it."""
        return bool(self._process.poll())

    def await_start(self) -> None:
        """Wait until recordings can be sent.

        Raises:
            FaultError: when it ends before, or takes longer than :data:`START_S`.
        """
        deadline = time.monotonic() + START_S
        while not listens(self._port):
            if not self.running:
                raise FaultError(f"Rerun ended at its start with exit status {self._process.returncode}")
            if time.monotonic() > deadline:
                raise FaultError(f"Rerun does not listen {START_S:g} s after its start")
            time.sleep(_POLL_S)

    def stay(self, asked_to_end: Callable[[], bool]) -> None:
        """Wait until it ends by itself, or this process is asked to end."""
        while self.running and not asked_to_end():
            time.sleep(_POLL_S)

    def stop(self) -> None:
        """End it."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            if self.running:
                self._process.send_signal(number)
                self._process.send_signal(signal.SIGCONT)
                try:
                    self._process.wait(_STOP_S)
                except subprocess.TimeoutExpired:
                    continue


def listens(port: int) -> bool:
    """Whether somebody on this machine listens on a port."""
    with socket.socket() as asking:
        asking.settimeout(1.0)
        return asking.connect_ex((HOST, port)) == 0


def _program() -> str:
    """The program itself: the script of that name in bin/ is a Python that starts it."""
    found = importlib.util.find_spec("rerun_cli")
    folders = [] if found is None else list(found.submodule_search_locations or ())
    return str(Path(folders[0], "rerun")) if folders else "rerun"


def _free_ports(first: int) -> list[int]:
    """Two ports that nobody has.

    Args:
        first: preferred for the first; 0: any.
    """
    ports = []
    with socket.socket() as one, socket.socket() as other:
        for asking, wanted in ((one, first), (other, 0)):
            try:
                asking.bind((HOST, wanted))
            except OSError:
                asking.bind((HOST, 0))
            ports.append(int(asking.getsockname()[1]))
    return ports


def _stays() -> None:
    os.nice(_NICE)


def _ends_with_us() -> Callable[[], None]:
    """What the child does to end when its parent does: not even ``kill -9`` of the command leaves a server behind."""
    prctl = ctypes.CDLL(None).prctl if sys.platform == "linux" else None

    def begin() -> None:
        os.nice(_NICE)
        if prctl is not None:
            prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)

    return begin
