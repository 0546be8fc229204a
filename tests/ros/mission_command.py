"""Runs ``run_mission.py`` as users do: as a process, its lines read as they come, its nodes found by their names."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from tethernet_bringup.mission.dds_profile import FILE_VARIABLES

MISSION_COMMAND = "tethernet_bringup.mission.command_line"
FLYING = r"[2-9]\.\d s  DEPLOYING"
"""A line of progress some seconds after launch."""
DEADLINE_S = 90.0
STOP_S = 6.0
"""What the command promises: all processes end within this time after Ctrl-C."""


class MissionCommand:
    """One run of the command; a context manager that leaves no process."""

    def __init__(
        self,
        output: Path,
        domain_id: int,
        *words: str,
        program: Sequence[str] = ("-m", MISSION_COMMAND),
    ):
        """Args:
        output: folder for the runs.
        domain_id: DDS domain.
        words: more of the command line.
        program: what Python runs.
        """
        self.output = output
        self.lines: list[str] = []
        self._news = threading.Condition()
        command = [
            sys.executable,
            *program,
            "--output",
            str(output),
            "--domain-id",
            str(domain_id),
        ]
        # The command makes a profile of its own, unless it is given one.
        environment = {name: value for name, value in os.environ.items() if name not in FILE_VARIABLES}
        self.process = subprocess.Popen(
            [*command, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> MissionCommand:
        return self

    def __exit__(self, *_) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.wait(lambda: not self.nodes(), "the nodes to end")
        self._reader.join()

    @property
    def text(self) -> str:
        """All that was printed."""
        return "\n".join(self.lines)

    @property
    def run(self) -> Path:
        """The run's folder."""
        return next(path for path in self.output.iterdir() if path.is_dir())

    @property
    def outcome(self) -> dict:
        """The content of outcome.json."""
        return json.loads((self.run / "outcome.json").read_text())

    def nodes(self) -> dict[str, int]:
        """Process ids of the nodes that live, by name."""
        found = {}
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    command = (entry / "cmdline").read_bytes().decode(errors="replace")
                    state = (entry / "stat").read_text().rsplit(")", 1)[1].split()[0]
                except OSError:
                    continue
                name = re.search(r"__node:=(\w+)", command)
                if name and str(self.output) in command and state != "Z":
                    found[name[1]] = int(entry.name)
        return found

    def kill_node(self, name: str) -> None:
        """Kill a node as soon as there is one with this name."""
        self.wait(lambda: name in self.nodes(), f"node {name}")
        os.kill(self.nodes()[name], signal.SIGKILL)

    def wait(self, condition: Callable[[], object], what: str) -> None:
        """Wait until a condition holds, looking again at every line and some times a second."""
        deadline = time.monotonic() + DEADLINE_S
        with self._news:
            while not condition():
                assert time.monotonic() < deadline, f"waited {DEADLINE_S:g} s for {what}; printed so far:\n{self.text}"
                self._news.wait(0.05)

    def wait_for(self, pattern: str) -> None:
        """Wait until a line that matches this regular expression is printed.

        Raises:
            AssertionError: when the command ends before.
        """

        def seen() -> bool:
            if any(re.search(pattern, line) for line in self.lines):
                return True
            assert self._reader.is_alive(), f"ended without {pattern!r}:\n{self.text}"
            return False

        self.wait(seen, repr(pattern))

    def stop(self, number: signal.Signals) -> tuple[int, float]:
        """Send a signal; returns the exit status and the time until all processes were gone [s]."""
        began = time.monotonic()
        self.process.send_signal(number)
        status = self.process.wait(DEADLINE_S)
        self.wait(lambda: not self.nodes(), "the nodes to end")
        return status, time.monotonic() - began

    def finish(self) -> int:
        """Wait for the end; returns the exit status."""
        status = self.process.wait(DEADLINE_S)
        self._reader.join(DEADLINE_S)
        assert not self.nodes(), f"left behind: {self.nodes()}"
        return status

    def _read(self) -> None:
        for line in self.process.stdout:
            with self._news:
                self.lines.append(line.rstrip("\n"))
                self._news.notify_all()
        self.process.stdout.close()


def read_bag(run: Path, bag: str = "bag") -> dict[str, list]:
    """All messages of a run's bag, decoded, by topic."""
    from rosbags.highlevel import AnyReader

    messages: dict[str, list] = {}
    with AnyReader([run / bag]) as reader:
        for connection, _, data in reader.messages():
            messages.setdefault(connection.topic, []).append(reader.deserialize(data, connection.msgtype))
    return messages
