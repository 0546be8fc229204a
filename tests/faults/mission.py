"""One faulted mission, alone in network, process and mount namespaces of its own.

    python -m tests.faults.mission --seed 7 --output FOLDER

writes FOLDER/result.json: what was done, how the command ended, and every promise that was broken.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

from tethernet_bringup.mission import shared_memory, sweeper

from .kinds import CATALOGUE, MISSION_COMMAND, Kind

SEGMENT = re.compile(r"fastrtps_(?!port7[0-3]\d\d)")
"""Shared memory of Fast DDS, but for the ports that belong to no domain: whoever comes next takes them over."""
LAUNCHED = "launch: the "
HOLDING = re.compile(r"\d s  hold test: ")
NODE = re.compile(r"__node:=(\w+)")
FLIGHT_S = {"lockstep": 40.0, "realtime": 75.0}
"""What a mission without a fault may take on a busy machine, from start to end [s] of wall time."""
LEFTOVER_S = sweeper.HEAD_START_S + sweeper.PATIENCE_S + shared_memory.YOUNG_S + 5.0
"""After the command has ended, or was killed, its nodes and their memory are gone within this time [s]: what the
sweeper allows itself, and its start on a busy machine."""
LATE_S = {"lockstep": (2.0, 5.0), "realtime": (15.0, 40.0)}
EARLY_S = {"lockstep": (0.0, 3.0), "realtime": (0.0, 20.0)}
HOLDS = 0.25
"""Share of missions that are tested for holding."""
FAULTS_IN_HOLD = 0.8
"""Share of those whose fault comes in that test, where it may."""
HOLD_S = {"lockstep": (40.0, 120.0), "realtime": (5.0, 10.0)}
TOW_N = (0.0, 20.0, 20.0, 200.0)
SLOWEST_LOCKSTEP = 3.0
"""Seconds of a mission in one of wall time, at least, on a busy machine."""
HOLD_FRACTION = {"lockstep": 0.05, "realtime": 0.7}
"""The fault comes within this fraction of the test [s of wall time in s of the mission]."""


class Run:
    """The command under test."""

    def __init__(self, seed: int, output: Path):
        self.seed, self.generator = seed, random.Random(seed)
        self.kind: Kind = CATALOGUE[seed % len(CATALOGUE)]
        self.pace = self.generator.choice(self.kind.paces)
        self.mus = self.generator.choice((4, 4, 8))
        self.moment = self.generator.choice(self.kind.moments)
        self.output = output
        self.words = ["--mus", str(self.mus), "--pace", self.pace, "--seed", str(seed)]
        self.hold_s = self.tow_n = 0.0
        self._draw_hold(random.Random(f"hold {seed}"))
        self.environment = dict(os.environ)
        self.before: list[str] = []
        """Commands of the shell that starts the command under test."""
        self.reader_goes_away = False
        self.beside: list[subprocess.Popen] = []
        self.target = ""
        self.injected = False
        self.lines: list[str] = []
        self.broken: list[str] = []
        self.command: subprocess.Popen | None = None
        self._launched, self._holding = threading.Event(), threading.Event()

    def _draw_hold(self, generator: random.Random) -> None:
        """Some missions are tested for holding."""
        if generator.random() >= HOLDS:
            return
        self.hold_s, self.tow_n = round(generator.uniform(*HOLD_S[self.pace]), 1), generator.choice(TOW_N)
        self.words += ["--hold", str(self.hold_s)]
        if self.tow_n:
            self.words += ["--tow", str(self.tow_n)]
        if self.kind.in_flight and generator.random() < FAULTS_IN_HOLD:
            self.moment = "hold"

    def set_parameters(self, node: str, **values: float) -> None:
        """Let the command fly with these parameters."""
        path = self.output / "parameters.yaml"
        lines = [f"    {name}: {value!r}" for name, value in values.items()]
        path.write_text(f"{node}:\n  ros__parameters:\n" + "\n".join(lines) + "\n")
        self.words += ["--params", str(path)]

    def nodes(self) -> dict[str, int]:
        """Process ids of the mission's nodes that live, by name."""
        found = {}
        for pid, command in processes().items():
            name = NODE.search(command)
            if name and str(self.output) in command:
                found[name[1]] = pid
        return found

    def choose(self, wanted: Callable[[str], bool], generator: random.Random) -> int:
        """Process id of a node drawn from those whose names are wanted, as soon as there is one; 0 when none comes."""
        while self.command.poll() is None:
            nodes = {name: pid for name, pid in self.nodes().items() if wanted(name)}
            if nodes:
                self.target = generator.choice(sorted(nodes))
                return nodes[self.target]
            self.wait(0.05)
        self.injected = False
        return 0

    def send(self, pid: int, number: signal.Signals) -> None:
        """Send a signal to a process that may have ended."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)

    def wait(self, seconds: float) -> None:
        """Wait, or until the command has ended."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.command.wait(seconds)

    def fly(self) -> dict:
        """Start the command, inject the fault, wait for the end, check the promises."""
        if self.kind.prepare is not None:
            self.kind.prepare(self, self.generator)
        began = time.monotonic()
        self._start()
        faulted = began
        if self.kind.inject is not None and self._await_moment():
            faulted = time.monotonic()
            self.injected = True
            self.kind.inject(self, self.generator)
        hold_s = self.hold_s / SLOWEST_LOCKSTEP if self.pace == "lockstep" else self.hold_s
        limit_s = FLIGHT_S[self.pace] + hold_s + self.kind.within_s
        try:
            status = self.command.wait(max(0.0, began + limit_s - time.monotonic()))
        except subprocess.TimeoutExpired:
            status = None
            self.broken.append(f"still running {time.monotonic() - faulted:.0f} s after the fault")
            self.command.kill()
            self.command.wait()
        ended = time.monotonic()
        self._check_leftovers()
        for process in self.beside:
            process.kill()
            process.wait()
        self._check(status)
        return {
            "kind": self.kind.name, "mus": self.mus, "pace": self.pace, "moment": self.moment, "target": self.target,
            "hold_s": self.hold_s, "tow_n": self.tow_n,
            "injected": self.injected, "status": status, "seconds": round(ended - began, 1),
            "after_fault_s": round(ended - faulted, 1), "broken": self.broken, "tail": self.lines[-12:],
        }  # fmt: skip

    def _start(self) -> None:
        mission = [
            sys.executable,
            "-m",
            MISSION_COMMAND,
            "--output",
            str(self.output),
            *self.words,
        ]
        shell = ["bash", "-c", "; ".join([*self.before, 'exec "$@"']), "bash"]
        self.command = subprocess.Popen(
            [*shell, *mission], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=self.environment
        )
        if self.reader_goes_away:
            self.command.stdout.close()
        else:
            threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in io.TextIOWrapper(self.command.stdout, errors="replace"):
            self.lines.append(line.rstrip("\n"))
            if LAUNCHED in line:
                self._launched.set()
            if HOLDING.search(line):
                self._holding.set()

    def _await_moment(self) -> bool:
        """Wait for the moment of the fault; false when the command has ended before."""
        if self.moment == "start":
            self.wait(self.generator.uniform(0.0, 6.0))
        else:
            begun = self._holding if self.moment == "hold" else self._launched
            while not begun.wait(0.05):
                if self.command.poll() is not None:
                    return False
            low, high = (LATE_S if self.moment == "late" else EARLY_S)[self.pace]
            if self.moment == "hold":
                low, high = 0.0, HOLD_FRACTION[self.pace] * self.hold_s
            self.wait(self.generator.uniform(low, high))
        return self.command.poll() is None

    # What must hold

    def _check_leftovers(self) -> None:
        known = {os.getpid(), os.getppid(), 1, *(process.pid for process in self.beside)}
        deadline = time.monotonic() + LEFTOVER_S
        while left := {pid: text for pid, text in processes().items() if pid not in known and NODE.search(text)}:
            if time.monotonic() > deadline:
                self.broken.append(f"processes left behind: {sorted(left.values())}")
                return
            time.sleep(0.1)
        while self.kind.memory and not self.beside and (found := segments()):
            if time.monotonic() > deadline:
                self.broken.append(f"{len(found)} files left in /dev/shm: {found[:4]}")
                return
            time.sleep(0.1)

    def _check(self, status: int | None) -> None:
        kind = self.kind
        allowed = kind.allowed if self.injected or kind.inject is None else kind.allowed | {0}
        if status is not None and status not in allowed:
            self.broken.append(f"exit status {status}; allowed: {sorted(allowed)}")
        printed = "\n".join(self.lines)
        if "Traceback" in printed:
            self.broken.append("a traceback was printed")
        folder = next((path for path in sorted(self.output.glob("*/")) if (path / "logs").is_dir()), None)
        launched = LAUNCHED in printed
        if folder is None:
            if kind.outcome and status not in (2, 130, 143):
                self.broken.append("there is no run folder")
            return
        self._check_logs(folder)
        self._check_outcome(folder, status)
        if kind.bag and launched and (folder / "bag").exists():
            self._check_bag(folder)

    def _check_logs(self, folder: Path) -> None:
        for log in sorted((folder / "logs").glob("*.log")):
            text = log.read_text(errors="replace")
            for sign in ("Traceback", "stopped by ", "core dumped"):
                if sign in text:
                    at = text.index(sign)
                    self.broken.append(f"{log.name}: {text[max(0, at - 200) : at + 1500]}")
                    break
        if not self.kind.deaths:
            deaths = [line for line in self.lines if re.search(r"\w+ died \(", line)]
            if deaths:
                self.broken.append(f"a node died: {deaths[0]}")

    def _check_outcome(self, folder: Path, status: int | None) -> None:
        path = folder / "outcome.json"
        if not path.exists():
            if self.kind.outcome:
                self.broken.append("there is no outcome.json")
            return
        try:
            outcome = json.loads(path.read_text(), parse_constant=lambda word: math.nan / 0)
        except (ValueError, ZeroDivisionError) as error:
            self.broken.append(f"outcome.json: {error}")
            return
        if status is None or status < 0:
            return
        if outcome.get("exit_status", status) != status:
            self.broken.append(f"exit status {status}, but outcome.json says {outcome['exit_status']}")
        captured, faults = outcome["captured"], outcome["faults"]
        if (status == 0) != bool(captured and not faults):
            self.broken.append(f"exit status {status}, but outcome.json: captured {captured}, {faults}")
        if status == 1 and not faults:
            self.broken.append("exit status 1 without a fault in outcome.json")
        reason = self.kind.reason.format(target=self.target)
        if status == 1 and self.injected and not re.search(reason, outcome["verdict"]):
            self.broken.append(f"the reason given is {outcome['verdict']!r}; expected: {reason}")
        self._check_hold(outcome, status)

    def _check_hold(self, outcome: dict, status: int) -> None:
        """What is said of the hold test is true, or that it is not known."""
        known, judged = outcome["hold_verdict"] is not None, outcome["capture_verdict"] is not None
        if status in (0, 3) and self.hold_s and not known:
            self.broken.append("nothing is said of the hold test")
        if known and not (self.hold_s and judged):
            self.broken.append(f"a verdict on the hold without one on the capture: {outcome['hold_verdict']}")
        if not known and outcome["held"] is not None:
            self.broken.append(f"held is {outcome['held']}, but no verdict says so")
        if self.moment == "hold" and self.injected:
            untrue = [text for text in outcome["warnings"] if "its thrust held" in text or "close the net" in text]
            if untrue:
                self.broken.append(f"said of a hold test, in which all units are off: {untrue[0]}")
        if self._holding.is_set() and status in (1, 130, 143) and not known:
            if not judged or outcome["cqi"] is None or outcome["end_time_s"] is None:
                self.broken.append("outcome.json does not keep the verdict that was made before the hold test")
            if "the hold test was not over" not in outcome["verdict"]:
                self.broken.append(f"the verdict does not say that the hold test was cut short: {outcome['verdict']}")

    def _check_bag(self, folder: Path) -> None:
        from tethernet_bringup.analysis import command_line as cli

        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
            try:
                status = cli.main([str(folder), "--no-plots", "--output", str(folder / "analysis")])
            except BaseException as error:
                self.broken.append(f"analysis of the bag: {type(error).__name__}: {error}")
                return
        if status != 0:
            self.broken.append(f"the bag cannot be analysed: {output.getvalue()[-500:]}")


def segments() -> list[str]:
    """Shared memory of Fast DDS that is there."""
    return sorted(path.name for path in Path("/dev/shm").iterdir() if SEGMENT.search(path.name))


def processes() -> dict[int, str]:
    """Command lines of all processes here that live, by process id."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            except OSError:
                continue
            if command and _state(int(entry.name)) not in ("Z", ""):
                found[int(entry.name)] = command
    return found


def _state(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return ""


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    result = {"seed": options.seed, **Run(options.seed, options.output).fly()}
    (options.output / "result.json").write_text(json.dumps(result, indent=2) + "\n")
    return 1 if result["broken"] else 0


if __name__ == "__main__":
    raise SystemExit(main())
