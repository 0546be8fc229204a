"""Run the tools of a set-up: their output into the log, their progress to the user, and nothing of them left behind."""

from __future__ import annotations

import contextlib
import os
import re
import selectors
import shlex
import signal
import subprocess
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from .errors import SetupError
from .lock import MARK
from .places import Places

TICK_S = 0.2
END_S = 3.0
"""A tool gets so long to end by itself when the set-up is interrupted."""

LAST_LINES = 15
NOT_FOR_TOOLS = {
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "LD_LIBRARY_PATH",
    "PIP_PREFIX",
    "PIP_ROOT",
    "PIP_TARGET",
    "PYTHONHOME",
    "PYTHONPATH",
    "ROS_DISTRO",
    "VIRTUAL_ENV",
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
}
"""Variables of another environment that would lead the tools astray."""


def tool_environment(places: Places) -> dict[str, str]:
    """Environment variables for a tool that works on this environment only."""
    environment = {key: value for key, value in os.environ.items() if key not in NOT_FOR_TOOLS}
    environment["PATH"] = f"{places.venv / 'bin'}{os.pathsep}{environment.get('PATH', os.defpath)}"
    environment.update(
        {MARK: str(places.venv), "PIP_USER": "0", "PIP_NO_INPUT": "1", "PYTHONUNBUFFERED": "1", "NO_COLOR": "1"}
    )
    environment.setdefault("HOME", str(places.venv))
    return environment


def run_tool(
    command: Sequence[str | Path],
    places: Places,
    *,
    advice: str,
    on_line: Callable[[str], None] = lambda line: None,
    environment: Mapping[str, str] | None = None,
) -> str:
    """Run a tool to its end.

    Args:
        command: program and arguments.
        places: the environment; the output goes to its log.
        advice: what the user can do if the tool fails.
        on_line: called with each line of output, and with "" while there is none.
        environment: variables for the tool instead of :func:`tool_environment`.

    Returns:
        The output, stdout and stderr together.

    Raises:
        SetupError: the tool cannot be started or has failed; with the end of its output, the log's place, the advice.
    """
    words = [str(word) for word in command]
    with open(places.log, "a", buffering=1, errors="replace") as log:
        log.write(f"\n$ {shlex.join(words)}\n")
        try:
            # A session of its own: Ctrl-C reaches this process alone, which then ends the tool with all its children.
            process = subprocess.Popen(
                words,
                cwd=places.venv,
                env=dict(environment or tool_environment(places)),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        except OSError as error:
            raise SetupError(f"{words[0]} cannot be started: {error.strerror}.\n{advice}") from error
        try:
            output = _read(process, log.write, on_line)
            status = process.wait()
        except BaseException:
            _end(process)
            raise
    if status:
        end = "\n".join(f"  | {line}" for line in output.rstrip().splitlines()[-LAST_LINES:])
        name = " ".join([Path(words[0]).name, *words[1:4]])
        raise SetupError(
            f"`{name} ...` failed with exit status {status}. Its last lines:\n{end}\nAll of it: {places.log}\n{advice}"
        )
    return output


def _read(process: subprocess.Popen[bytes], write: Callable[[str], object], on_line: Callable[[str], None]) -> str:
    """Pass the output on line by line until the tool closes it."""
    output, rest = [], ""
    if process.stdout is None:
        raise ValueError("the process has no pipe for its output")
    descriptor = process.stdout.fileno()
    with selectors.DefaultSelector() as selector:
        selector.register(descriptor, selectors.EVENT_READ)
        while True:
            if not selector.select(TICK_S):
                on_line("")
                continue
            piece = os.read(descriptor, 65536).decode(errors="replace")
            if not piece:
                break
            write(piece)
            output.append(piece)
            *lines, rest = re.split(r"[\r\n]+", rest + piece)
            for line in lines:
                on_line(line)
    return "".join(output)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End an interrupted tool with all its children."""
    for signal_number in (signal.SIGTERM, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal_number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(END_S)
