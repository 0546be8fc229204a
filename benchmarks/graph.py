"""Missions over ROS 2 with all processes, flown by the users' command: ``python -m benchmarks.graph [--smoke]``.

In lock-step: how much faster than real time. In real time: missed deadlines, time from odometry to thrust, memory of
all processes. In both: time from the command to launch. The figures are those of outcome.json; this program only adds
where the CPU time goes.

Each mission in lock-step takes turns with its baseline, the same processes with empty callbacks (empty_graph.py): what
of the time is the middleware's and the interpreter's. ``share_of_empty`` is the mission's real-time factor by the
baseline's, ``start_ratio_empty`` the mission's time from command to launch by the baseline's, medians over the turns;
``cpu_share_of_empty`` and ``start_cpu_ratio_empty`` the same of CPU time, which other jobs disturb less.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import shlex
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tethernet_core.subcommand import whole_number

from .empty_graph import EmptyFlown, EmptyMissionError, fly_empty
from .figures import conclude, cores, machine
from .processes import CpuSampler

ROOT = Path(__file__).resolve().parent.parent
DOMAIN_ID = 101
"""A mission that flies beside, on the default domain, disturbs no figure but the times."""
TIMEOUT_S = 300.0
CAPTURED, NOT_CAPTURED = 0, 3
_LAUNCH = "launch:"
"""In the line that the command prints at launch."""
_OUTPUT_S = 5.0  # for the last words of a command that has ended
SMOKE_PARAMETERS = "/**:\n  ros__parameters:\n    give_up_s: 4.0\n"
"""Ends the mission before the net is there; everybody has worked by then."""


class BenchmarkError(Exception):
    """A mission did not go as it must; the message has the command's own words."""


@dataclass(frozen=True)
class Flown:
    """One mission."""

    outcome: dict[str, Any]
    """Content of outcome.json."""
    cpu_s: dict[str, float]
    """CPU time of each process from launch to the verdict [s]."""
    start_cpu_s: dict[str, float]
    """CPU time of each process up to launch [s]."""
    launch_s: float
    """From the command to launch, its set-up check and its imports included [s]."""
    run: Path
    """Folder of the run."""


def fly(command: list[str], pace: str, parameters: Path | None, domain_id: int, folder: Path) -> Flown:
    """Fly one mission.

    Args:
        command: starts run_mission.py.
        pace: lockstep or realtime.
        parameters: of a shortened mission; None for a whole one.
        domain_id: DDS domain.
        folder: for the run; made here.

    Raises:
        BenchmarkError: when it did not end with a verdict.
    """
    words = ["--mus", "8", "--pace", pace, "--output", str(folder), "--domain-id", str(domain_id)]
    words += ["--params", str(parameters)] if parameters else []
    allowed = (CAPTURED, NOT_CAPTURED) if parameters else (CAPTURED,)
    line = " ".join([*command, *words])
    # A session of its own: whatever happens here, Ctrl-C reaches the command once, from this program.
    try:
        process = subprocess.Popen(
            [*command, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
        )
    except OSError as error:
        raise BenchmarkError(f"cannot start {' '.join(command)}: {error.strerror}") from error
    output = _Output(process)
    with CpuSampler(process.pid) as sampler:
        try:
            process.wait(timeout=TIMEOUT_S)
        except BaseException as error:
            process.terminate()  # the command ends its nodes itself
            process.wait()
            if isinstance(error, subprocess.TimeoutExpired):
                raise BenchmarkError(f"no end after {TIMEOUT_S:g} s of {line}:\n{output.text()}") from error
            raise
    said = output.text()
    if process.returncode not in allowed:
        raise BenchmarkError(f"exit status {process.returncode} (allowed: {allowed}) of {line}:\n{said}")
    outcome = json.loads(next(folder.glob("*/outcome.json")).read_text(encoding="utf-8"))
    launch = output.launched_s
    in_flight = sampler.between(launch, launch + outcome["wall_time_s"])
    return Flown(
        outcome,
        in_flight,
        sampler.between(sampler.began, launch),
        launch - sampler.began,
        next(folder.glob("*/outcome.json")).parent,
    )


class _Output:
    """What a command prints, and when it tells of the launch."""

    def __init__(self, process: subprocess.Popen[str]):
        self.launched_s = math.nan
        """[s], time.monotonic; NaN before."""
        self._process, self._lines = process, list[str]()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def text(self) -> str:
        """All of it, once the command has ended."""
        self._thread.join(_OUTPUT_S)
        return "".join(self._lines)

    def _read(self) -> None:
        for line in self._process.stdout or ():
            self._lines.append(line)
            if _LAUNCH in line and math.isnan(self.launched_s):
                self.launched_s = time.monotonic()


def describe(pace: str, flown: Flown) -> str:
    """One mission in words."""
    outcome = flown.outcome
    return (
        f"{pace}: {outcome['flown_s']:.1f} s in {outcome['wall_time_s']:.1f} s, {outcome['real_time_factor']:.2f} x "
        f"real time; launch after {flown.launch_s:.1f} s; odometry to thrust p50 {outcome['latency_p50_ms']:.1f}, "
        f"p99 {outcome['latency_p99_ms']:.1f}, max {outcome['latency_max_ms']:.1f} ms; {outcome['deadline_misses']} "
        f"deadlines missed; {outcome['memory_mb']:.0f} MB\n"
        f"    CPU s to launch {_shares(flown.start_cpu_s)}; in flight {_shares(flown.cpu_s)}"
    )


def describe_empty(flown: EmptyFlown) -> str:
    """One run of the empty processes in words."""
    return (
        f"empty processes: {flown.real_time_factor:.2f} x real time; launch after {flown.start_s:.1f} s\n"
        f"    CPU s to launch {_shares(flown.start_cpu_s)}; in flight {_shares(flown.cpu_s)}"
    )


def _shares(cpu_s: dict[str, float]) -> str:
    shares = ", ".join(f"{name} {seconds:.2f}" for name, seconds in _grouped(cpu_s).items())
    return f"{sum(cpu_s.values()):.2f} ({shares})"


def _ratio(one: dict[str, float], other: dict[str, float]) -> float:
    """CPU time of all processes by that of all others; NaN where theirs was too short to be seen."""
    whole = sum(other.values())
    return sum(one.values()) / whole if whole else math.nan


def _grouped(cpu_s: dict[str, float]) -> dict[str, float]:
    """The controllers as one, the rest by name, the largest first."""
    grouped: dict[str, float] = {}
    for name, seconds in cpu_s.items():
        group = "controllers" if name.endswith("_controller") else name
        grouped[group] = grouped.get(group, 0.0) + seconds
    return dict(sorted(grouped.items(), key=lambda item: -item[1]))


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0; 1 when a mission failed."""
    options = _options(argv)
    print(machine())
    flown: dict[str, list[Flown]] = {"lockstep": [], "realtime": []}
    empty: list[EmptyFlown] = []
    with tempfile.TemporaryDirectory(prefix="tethernet_benchmark_") as scratch:
        parameters = None
        if options.smoke:
            parameters = Path(scratch, "short.yaml")
            parameters.write_text(SMOKE_PARAMETERS, encoding="utf-8")
        missions = 1 if options.smoke else options.missions
        for pace, count in (("lockstep", missions), ("realtime", 1)):
            for number in range(count):
                folder = Path(scratch, f"{pace}{number}")
                try:
                    flown[pace].append(fly(options.command, pace, parameters, options.domain_id, folder))
                    print(describe(pace, flown[pace][-1]), flush=True)
                    if pace == "lockstep":
                        empty.append(fly_empty(flown[pace][-1].run, Path(scratch), options.domain_id))
                        print(describe_empty(empty[-1]), flush=True)
                except (BenchmarkError, EmptyMissionError) as error:
                    print(f"benchmark graph: {error}", file=sys.stderr)
                    return 1
    every = [mission.outcome for missions in flown.values() for mission in missions]
    in_lockstep = [mission.outcome for mission in flown["lockstep"]]
    in_real_time = flown["realtime"][0]
    conclude(
        "graph",
        {
            "real_time_factor": statistics.median(outcome["real_time_factor"] for outcome in in_lockstep),
            "real_time_factor_empty": statistics.median(turn.real_time_factor for turn in empty),
            "share_of_empty": statistics.median(
                mission["real_time_factor"] / turn.real_time_factor
                for mission, turn in zip(in_lockstep, empty, strict=True)
            ),
            "start_ratio_empty": statistics.median(
                mission.launch_s / turn.start_s for mission, turn in zip(flown["lockstep"], empty, strict=True)
            ),
            "cpu_share_of_empty": statistics.median(
                _ratio(turn.cpu_s, mission.cpu_s) for mission, turn in zip(flown["lockstep"], empty, strict=True)
            ),
            "start_cpu_ratio_empty": statistics.median(
                _ratio(mission.start_cpu_s, turn.start_cpu_s)
                for mission, turn in zip(flown["lockstep"], empty, strict=True)
            ),
            "latency_p99_ms": in_real_time.outcome["latency_p99_ms"],
            "deadline_misses": in_real_time.outcome["deadline_misses"],
            "start_s": statistics.median(mission.launch_s for missions in flown.values() for mission in missions),
            "start_s_empty": statistics.median(turn.start_s for turn in empty),
            "memory_mb": max(outcome["memory_mb"] for outcome in every),
            "latency_p50_ms": in_real_time.outcome["latency_p50_ms"],
            "latency_max_ms": in_real_time.outcome["latency_max_ms"],
            "lockstep_deadline_misses": sum(outcome["deadline_misses"] for outcome in in_lockstep),
            "start_cpu_s": statistics.median(sum(mission.start_cpu_s.values()) for mission in flown["lockstep"]),
            "lockstep_cpu_s": statistics.median(sum(mission.cpu_s.values()) for mission in flown["lockstep"]),
            "realtime_cpu_share": sum(in_real_time.cpu_s.values()) / in_real_time.outcome["wall_time_s"] / cores(),
        },
    )
    return 0


def _options(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.graph", description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="missions of a few seconds")
    parser.add_argument(
        "--missions", type=whole_number(1), default=3, metavar="N", help="missions in lock-step; default 3"
    )
    parser.add_argument(
        "--domain-id",
        type=int,
        default=int(os.environ.get("ROS_DOMAIN_ID") or DOMAIN_ID),
        metavar="N",
        help=f"DDS domain; default: $ROS_DOMAIN_ID, or {DOMAIN_ID}",
    )
    parser.add_argument(
        "--command",
        type=shlex.split,
        default=[sys.executable, str(ROOT / "run_mission.py")],
        metavar="WORDS",
        help="what starts a mission, as one argument; default: this Python with run_mission.py",
    )
    return parser.parse_args(argv)


if __name__ == "__main__":
    sys.exit(main())
