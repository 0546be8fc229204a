"""The kinds of faults. Each is injected into a running command at a random moment; each says what may come of it."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .mission import Run

CAPTURED, FAULT, USAGE, MISSED, INTERRUPTED, TERMINATED = 0, 1, 2, 3, 130, 143
MISSION_COMMAND = "tethernet_bringup.mission.command_line"
FLOWN = frozenset({CAPTURED, MISSED})
ANY_END = FLOWN | {FAULT}
FAILED = frozenset({FAULT})
BEFORE_END = ("start", "flight")
ANY_MOMENT = ("start", "flight", "late")
ESSENTIAL = ("sim", "planner", "assessor", "recorder")


@dataclass(frozen=True)
class Kind:
    """One kind of fault."""

    name: str
    inject: Callable[[Run, random.Random], None] | None = None
    """Does it, at its moment; None: it lies in how the command is started."""
    prepare: Callable[[Run, random.Random], None] | None = None
    """Changes how the command is started."""
    moments: tuple[str, ...] = ("flight",)
    """When: "start" (processes start), "flight" (after launch), "late" (seconds after launch). In a mission with a hold
    test most of those in flight wait for that test.
    """
    allowed: frozenset[int] = FLOWN
    """Exit statuses."""
    within_s: float = 30.0
    """The command has ended so long after the fault, beside the flight's own time."""
    outcome: bool = True
    """Whether outcome.json must be there."""
    bag: bool = True
    """Whether the bag must be whole or salvageable."""
    memory: bool = True
    """Whether no shared memory may be left: not where making it fails half way."""
    deaths: bool = False
    """Whether a node may die: where it is killed."""
    reason: str = ""
    """What the verdict of a mission that failed must say, a regular expression; ``{target}`` stands for whom it hit."""
    paces: tuple[str, ...] = ("lockstep",) * 7 + ("realtime",)

    @property
    def in_flight(self) -> bool:
        """Whether it may be injected after launch."""
        return self.inject is not None and self.moments != ("start",)


def _kill(number: signal.Signals, names: tuple[str, ...] = ()) -> Callable[[Run, random.Random], None]:
    def inject(run: Run, generator: random.Random) -> None:
        pid = run.choose(lambda name: not names or name in names, generator)
        if pid:
            run.send(pid, number)

    return inject


def _controller(number: signal.Signals) -> Callable[[Run, random.Random], None]:
    def inject(run: Run, generator: random.Random) -> None:
        pid = run.choose(lambda name: name.startswith("mu"), generator)
        if pid:
            run.send(pid, number)

    return inject


def _command(number: signal.Signals) -> Callable[[Run, random.Random], None]:
    def inject(run: Run, _generator: random.Random) -> None:
        run.target = "run_mission"
        run.send(run.command.pid, number)

    return inject


def _halt(shortest_s: float, longest_s: float) -> Callable[[Run, random.Random], None]:
    def inject(run: Run, generator: random.Random) -> None:
        pid = run.choose(lambda name: True, generator)
        if pid:
            _stop_and_go(run, pid, generator.uniform(shortest_s, longest_s))

    return inject


def _stop_and_go(run: Run, pid: int, seconds: float) -> None:
    run.send(pid, signal.SIGSTOP)
    run.wait(seconds)
    run.send(pid, signal.SIGCONT)


def _command_killed(run: Run, generator: random.Random) -> None:
    """Sometimes because a node hangs."""
    node = run.choose(lambda name: True, generator) if generator.random() < 0.3 else 0
    halted = run.target if node else ""
    if node:
        run.send(node, signal.SIGSTOP)
        run.wait(generator.uniform(0.0, 2.0))
    _command(signal.SIGKILL)(run, generator)
    run.target += f", {halted} halted" if halted else ""


def _command_halts(run: Run, generator: random.Random) -> None:
    _stop_and_go(run, run.command.pid, generator.uniform(1.0, 6.0))


def _driver_halts(run: Run, generator: random.Random) -> None:
    _stop_and_go(run, run.beside[0].pid, generator.uniform(0.2, 3.0))


def _rogue(kind: str) -> Callable[[Run, random.Random], None]:
    def inject(run: Run, generator: random.Random) -> None:
        seconds = generator.uniform(2.0, 6.0)
        environment = dict(os.environ)
        profile = next(iter(sorted(run.output.glob("*/*.xml"))), None)
        if profile is not None and generator.random() < 0.5:  # as one of the mission's own processes would
            environment["FASTRTPS_DEFAULT_PROFILES_FILE"] = environment["FASTDDS_DEFAULT_PROFILES_FILE"] = str(profile)
            run.target = f"{kind}, with the mission's own profile"
        words = ["--seed", str(generator.randrange(10**6)), "--seconds", f"{seconds:g}", "--mus", str(run.mus)]
        words += ["--kind", kind]
        with open(run.output / "rogue.log", "wb") as log:
            run.beside.append(
                subprocess.Popen(
                    [sys.executable, "-m", "tests.faults.rogue", *words], env=environment, stdout=log, stderr=log
                )
            )

    return inject


def _bag_file(change: Callable[[Path, random.Random], None]) -> Callable[[Run, random.Random], None]:
    def inject(run: Run, generator: random.Random) -> None:
        for path in run.output.glob("*/bag/*.mcap"):
            change(path, generator)

    return inject


def _cut(path: Path, generator: random.Random) -> None:
    os.truncate(path, int(path.stat().st_size * generator.random()))


def _replace(path: Path, _generator: random.Random) -> None:
    path.unlink()
    path.write_bytes(b"something else")


def _remove_run(run: Run, _generator: random.Random) -> None:
    for folder in run.output.iterdir():
        if folder.is_dir():
            shutil.rmtree(folder, ignore_errors=True)


def _file_size_limit(run: Run, generator: random.Random) -> None:
    run.before.append(f"ulimit -f {generator.choice((100, 1000, 3000))}")  # [KiB]


def _few_handles(run: Run, generator: random.Random) -> None:
    run.before.append(f"ulimit -n {generator.choice((20, 40, 64))}")


def _small_disk(run: Run, generator: random.Random) -> None:
    size = generator.choice(("4m", "6m", "8m"))
    run.output = run.output / "disk"
    run.output.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(run.output)], check=True)


def _no_shared_memory(run: Run, generator: random.Random) -> None:
    size = generator.choice(("64k", "1m", "4m"))
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", "/dev/shm"], check=True)


def _strange_folder(run: Run, generator: random.Random) -> None:
    run.output = run.output / generator.choice(("Flüge 7", "a b'c", "日本", "{x}", "a:=b", "-x"))
    run.output.mkdir()
    run.environment["LC_ALL"] = generator.choice(("C", "POSIX", "", "C.UTF-8"))


def _no_home(run: Run, _generator: random.Random) -> None:
    run.environment["HOME"] = "/nonexistent"


def _closed_output(run: Run, generator: random.Random) -> None:
    run.reader_goes_away = generator.random() < 0.5
    if not run.reader_goes_away:
        run.before.append(generator.choice(("exec >&-", "exec 2>&-", "exec >&- 2>&-")))


def _no_hangup(run: Run, _generator: random.Random) -> None:
    run.before.append("trap '' HUP")


def _random_parameters(run: Run, generator: random.Random) -> None:
    choices = {
        "contact_stiffness_n_m": (1e2, 1e3, 5e4, 1e5),
        "contact_damping_ratio": (0.0, 0.05, 0.3, 0.5),
        "friction": (0.0, 0.6),
        "give_up_s": (5.0, 26.0),
        "capture_duration_s": (1.0, 5.0),
        "trigger_distance_m": (1.0, 4.0),
        "joint_stiffness_n_m": (500.0, 2000.0),
        "fold_factor": (0.02, 0.1),
        "launch_delay_s": (0.0, 2.0),
    }
    drawn = generator.sample(sorted(choices), 2)
    run.set_parameters("/**", **{name: generator.choice(choices[name]) for name in drawn})


def _planner_loses_patience(run: Run, _generator: random.Random) -> None:
    """The planner misses what is measured before the command finds that the simulator hangs."""
    run.set_parameters("planner", silence_timeout_s=2.0)


def _only_news_count(run: Run, _generator: random.Random) -> None:
    """Nobody asks the nodes for a sign of life; a mission of which nothing is heard must end all the same."""
    run.set_parameters("run_mission", silence_timeout_s=3.0, hang_timeout_s=600.0)


def _second_mission(run: Run, generator: random.Random) -> None:
    output = run.output / "second"
    output.mkdir()
    words = ["--mus", str(generator.choice((4, 8))), "--pace", run.pace, "--output", str(output)]
    with open(run.output / "second.log", "wb") as log:
        run.beside.append(
            subprocess.Popen(
                [sys.executable, "-m", MISSION_COMMAND, *words],
                stdout=log,
                stderr=log,
                env=run.environment,
            )
        )


def _driver(run: Run, generator: random.Random) -> None:
    mu = generator.randint(1, run.mus)
    run.words += ["--external-mu", str(mu), "--external-timeout", "20"]
    command = [sys.executable, "examples/mu_driver.py", "--mu", str(mu), "--clock", "sim"]
    with open(run.output / "driver.log", "wb") as log:
        run.beside.append(subprocess.Popen(command, stdout=log, stderr=log))


def _end_driver(number: signal.Signals) -> Callable[[Run, random.Random], None]:
    def inject(run: Run, _generator: random.Random) -> None:
        run.beside[0].send_signal(number)

    return inject


def _nothing(_run: Run, _generator: random.Random) -> None:
    """A mission without a fault: it must be captured."""


CATALOGUE = (
    Kind("none", _nothing, allowed=frozenset({CAPTURED})),
    # Processes that die, hang or halt
    Kind("essential node killed", _kill(signal.SIGKILL, ESSENTIAL), moments=BEFORE_END, allowed=FAILED, deaths=True,
         reason=r"^{target} died \(killed by SIGKILL\)"),
    Kind("essential node crashes", _kill(signal.SIGSEGV, ESSENTIAL), allowed=FAILED, deaths=True,
         reason=r"^{target} died \(killed by SIGSEGV\)"),
    Kind("essential node hangs", _kill(signal.SIGSTOP, ESSENTIAL), moments=BEFORE_END, allowed=FAILED, deaths=True,
         reason=r"\b{target} (hangs|does not|lacks)"),
    Kind("controller killed", _controller(signal.SIGKILL), allowed=ANY_END, deaths=True),
    Kind("controller killed early", _controller(signal.SIGKILL), moments=("start",), allowed=ANY_END, deaths=True),
    Kind("controller hangs", _controller(signal.SIGSTOP), moments=BEFORE_END, allowed=ANY_END, deaths=True),
    Kind("node interrupted", _kill(signal.SIGINT), moments=BEFORE_END, allowed=ANY_END, deaths=True),
    Kind("node terminated", _kill(signal.SIGTERM), allowed=ANY_END, deaths=True),
    Kind("node halts for a moment", _halt(0.1, 2.0), moments=BEFORE_END, allowed=ANY_END),
    Kind("node halts for long", _halt(3.0, 10.0), allowed=ANY_END, deaths=True),
    Kind("command killed", _command_killed, moments=ANY_MOMENT, allowed=frozenset({-9}), outcome=False),
    Kind("command interrupted", _command(signal.SIGINT), moments=ANY_MOMENT, allowed=frozenset({INTERRUPTED})),
    Kind("command terminated", _command(signal.SIGTERM), moments=BEFORE_END, allowed=frozenset({TERMINATED})),
    Kind("terminal hangs up", _command(signal.SIGHUP), _no_hangup, allowed=frozenset({CAPTURED})),
    Kind("command halts", _command_halts, allowed=ANY_END),
    # Messages
    Kind("hostile topics", _rogue("topics"), moments=BEFORE_END, allowed=ANY_END),
    Kind("hostile topics, again", _rogue("topics"), moments=BEFORE_END, allowed=ANY_END),
    Kind("hostile topics, once more", _rogue("topics"), allowed=ANY_END),
    Kind("hostile types", _rogue("types"), moments=BEFORE_END, allowed=ANY_END),
    Kind("hostile services", _rogue("services"), moments=BEFORE_END, allowed=ANY_END),
    Kind("hostile flood", _rogue("flood"), allowed=ANY_END),
    Kind("second mission", _second_mission, allowed=frozenset({CAPTURED})),
    # Bag and disk
    Kind("bag deleted", _bag_file(lambda path, _: path.unlink()), allowed=FAILED, bag=False),
    Kind("bag cut", _bag_file(_cut), allowed=FAILED, bag=False),
    Kind("bag replaced", _bag_file(_replace), allowed=FAILED, bag=False),
    Kind("run folder removed", _remove_run, allowed=FAILED, outcome=False, bag=False),
    Kind("full disk", prepare=_small_disk, allowed=ANY_END, outcome=False, deaths=True),
    Kind("file size limit", prepare=_file_size_limit, allowed=ANY_END, outcome=False, memory=False, deaths=True),
    Kind("few file handles", prepare=_few_handles, allowed=ANY_END, outcome=False, bag=False, deaths=True),
    Kind("little shared memory", prepare=_no_shared_memory, allowed=ANY_END, deaths=True),
    # Environment
    Kind("strange folder and locale", prepare=_strange_folder, allowed=frozenset({CAPTURED, USAGE}), outcome=False),
    Kind("no home", prepare=_no_home, allowed=frozenset({CAPTURED})),
    Kind("closed output", prepare=_closed_output, allowed=frozenset({CAPTURED, FAULT, USAGE}), outcome=False),
    Kind("random parameters", prepare=_random_parameters, allowed=ANY_END | {USAGE}, outcome=False),
    # Drivers
    Kind("driver", prepare=_driver),
    Kind("driver killed", _end_driver(signal.SIGKILL), _driver, allowed=ANY_END),
    Kind("driver halts", _driver_halts, _driver, moments=BEFORE_END, allowed=ANY_END),
    # Ends that come from within
    Kind("abort asked for", _rogue("abort"), allowed=ANY_END,
         reason=r"^the mission was aborted: asked for on /planner/abort"),
    Kind("nothing measured", _kill(signal.SIGSTOP, ("sim",)), _planner_loses_patience, allowed=FAILED, deaths=True,
         reason=r"^the mission was aborted: nothing was measured for 2 s"),
    Kind("nothing heard", _kill(signal.SIGSTOP, ("sim", "planner")), _only_news_count, allowed=FAILED, deaths=True,
         reason=r"^(nothing new has been heard of the mission for \d+ s|the planner has not ended the mission)"),
)  # fmt: skip
"""In no order; a campaign goes through all of them again and again."""
