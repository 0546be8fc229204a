"""The processes of a mission: start, watch, stop; none is left behind, whatever happens.

Each node is a process in a session of its own, so that Ctrl-C at the terminal reaches the supervisor alone and the
order of the end stays in its hands: first everybody but the recorder, the recorder last. The other way round, nodes
that outlive the supervisor end themselves, see :mod:`tethernet_bringup.mission.child`.
"""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tethernet_bringup.mission import child, shared_memory, sweeper
from tethernet_bringup.mission.child import ForkedProcess
from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_core.quiet_start import ONE_THREAD, absolute_search_paths
from tethernet_core.shown import shown

TAIL_LINES = 15
_POLL_S = 0.01
_KILL_PATIENCE_S = 0.2
_NO_HURRY = 3.0  # times the patience where nobody waits for the end

_KEPT = (
    "PATH",
    "HOME",
    "LANG",
    "LC_ALL",
    "TZ",
    "TMPDIR",
    "USER",
    "VIRTUAL_ENV",
    "PYTHONPATH",
    "LD_LIBRARY_PATH",
    "LD_PRELOAD",
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "RMW_IMPLEMENTATION",
    "CYCLONEDDS_URI",
    "XDG_CACHE_HOME",
)
_KEPT_PREFIXES = ("ROS_", "_ROS_", "RMW_", "FASTRTPS_", "FASTDDS_", "NUMBA_", "COVERAGE_", "TETHERNET_")


@dataclass(frozen=True)
class NodeProcess:
    """How one node is started."""

    name: str
    """Its name in the ROS graph."""
    module: str
    """Python module that runs it."""
    essential: bool = True
    """Whether the mission cannot go on without it."""
    last: bool = False
    """Whether it ends after all others: the recorder."""
    bystander: bool = False
    """Whether the mission does as well without it, from its start on: the viewer."""
    batch: bool = False
    """Whether it interrupts nobody when it is woken: it runs as soon as a core is free (Linux: SCHED_BATCH)."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Environment variables in which it differs from the other nodes."""
    arguments: tuple[str, ...] = ()
    """Further words of its command line."""


@dataclass(frozen=True)
class Exit:
    """How one node ended."""

    node: NodeProcess
    code: int
    """Exit code; negative: killed by that signal."""
    tail: tuple[str, ...]
    """The last lines of its log."""
    forced: bool = False
    """Whether it had to be killed."""

    @property
    def how(self) -> str:
        """The exit code in words."""
        if self.code >= 0:
            return f"exit status {self.code}"
        try:
            return f"killed by {signal.Signals(-self.code).name}"
        except ValueError:
            return f"killed by signal {-self.code}"

    def report(self) -> str:
        """Name and exit code, then the last lines of the log."""
        lines = [f"{self.node.name} died ({self.how})"]
        return "\n".join(lines + [f"    | {line}" for line in self.tail])


def mission_environment(
    domain_id: int, discovery: str, log_folder: Path, base: Mapping[str, str] = os.environ
) -> dict[str, str]:
    """The environment of all processes of a mission, built from the few variables that they need.

    Args:
        domain_id: DDS domain.
        discovery: "localhost" or "subnet".
        log_folder: where ROS writes its logs.
        base: the environment to take from.
    """
    kept = {name: value for name, value in base.items() if name in _KEPT or name.startswith(_KEPT_PREFIXES)}
    kept = absolute_search_paths(kept)
    kept.setdefault("HOME", str(log_folder))  # rcl refuses to start without
    kept.update(dict.fromkeys(ONE_THREAD, "1"))  # a dozen processes share the cores already
    kept.update(
        ROS_DOMAIN_ID=str(domain_id),
        ROS_AUTOMATIC_DISCOVERY_RANGE=discovery.upper(),
        ROS_LOG_DIR=str(log_folder),
        RCUTILS_COLORIZED_OUTPUT="0",
        RCUTILS_LOGGING_USE_STDOUT="0",
        PYTHONUNBUFFERED="1",
        PYTHONSAFEPATH="1",  # as -P, for whatever a node starts
    )
    kept.pop("ROS_LOCALHOST_ONLY", None)  # deprecated, and it would overrule the discovery range
    return kept


class Supervisor:
    """Starts, watches and stops the processes of one mission; a context manager that leaves none behind."""

    def __init__(self, log_folder: Path, environment: Mapping[str, str], parameters: SupervisorParameters):
        """Args:
        log_folder: exists; gets one log file per node.
        environment: of the processes, see :func:`mission_environment`.
        parameters: how patient it is.
        """
        self.log_folder = log_folder
        self.parameters = parameters
        self._environment = dict(environment)
        self._processes: dict[str, tuple[NodeProcess, ForkedProcess]] = {}
        self._exits: dict[str, Exit] = {}
        self._began_s = time.time()
        self._segments: set[str] = set()
        # Nobody writes into this pipe: its end tells the nodes that the supervisor is gone.
        self._pipe: tuple[int, int] | None = os.pipe()
        self._gate, self._gate_open = os.pipe(), False
        self._life: int | None = None

    def __enter__(self) -> Supervisor:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def pids(self) -> dict[str, int]:
        """Process ids of the living, by node."""
        return {name: process.pid for name, (_, process) in self._processes.items() if name not in self._exits}

    def start(self, node: NodeProcess) -> None:
        """Start one node; returns at once. It waits before it joins the graph, see :meth:`let_in`.

        This process must have loaded no middleware, see :mod:`tethernet_bringup.mission.child`.

        Raises:
            OSError: when its log cannot be written or the process cannot be made.
            RuntimeError: after :meth:`stop`; each mission has its own supervisor.
        """
        if self._pipe is None:
            raise RuntimeError(f"{node.name} cannot be started: this supervisor has stopped; make another one")
        with self._log_path(node.name).open("wb") as log:
            environment = {**self._environment, **node.environment}
            surroundings = child.Surroundings(
                self._pipe[0], log.fileno(), self._gate[0], environment, self._began_s, node.batch
            )
            process = child.fork(node.name, node.module, node.arguments, surroundings)
        self._processes[node.name] = (node, process)
        if self._gate_open:
            os.write(self._gate[1], b"+")

    def start_all(self, nodes: Iterable[NodeProcess]) -> None:
        """Start nodes in the given order, without waiting for any."""
        for node in nodes:
            self.start(node)

    def let_in(self) -> None:
        """Let the nodes join the graph, those that are started later too."""
        if not self._gate_open:
            self._gate_open = True
            os.write(self._gate[1], b"+" * len(self._processes))

    def deaths(self) -> list[Exit]:
        """Who ended since the last call."""
        found = []
        for name in self.pids:
            node, process = self._processes[name]
            code = process.poll()
            if code is not None:
                self._exits[name] = Exit(node, code, self.tail(name))
                found.append(self._exits[name])
        return found

    def tail(self, name: str) -> tuple[str, ...]:
        """The last lines that a node printed."""
        try:
            with self._log_path(name).open("rb") as log:
                log.seek(0, os.SEEK_END)
                log.seek(max(0, log.tell() - 20_000))
                lines = log.read().decode(errors="replace").splitlines()
        except OSError:
            return ()
        return tuple(shown(line) for line in lines if line.strip())[-TAIL_LINES:]

    def memory_mb(self) -> float:
        """Proportional set size of all living nodes and this process together [MB]: what they take from the machine."""
        return sum(_proportional_set_size(pid) for pid in (os.getpid(), *self.pids.values())) / 1e6

    def note_shared_memory(self) -> None:
        """Remember which shared-memory segments the living nodes and this process hold, to clean up after those that
        get killed; what this process owns stays until it lets go of it.
        """
        self._segments |= shared_memory.held_by((os.getpid(), *self.pids.values()))

    def clean(self) -> None:
        """Remove the shared memory that killed nodes left; again whenever this process has talked to them since."""
        shared_memory.clean(self._segments | shared_memory.left_since(self._began_s))

    def clean_up(self) -> None:
        """The same for good, when all nodes have ended: what a node made in its last second is waited for."""
        shared_memory.clean_with_the_young(self._segments, self._began_s)

    def stand_by(self) -> None:
        """From now on, until :meth:`call_off`, let what is left be removed even where this process is killed after its
        nodes have ended.
        """
        if self._pipe is not None and self._life is None:
            self.note_shared_memory()
            with contextlib.suppress(OSError):  # no process can be made: what is left stays, should it come to that
                self._life = sweeper.stand_by(self._pipe[0], self._began_s, self._segments)

    def call_off(self) -> None:
        """All is in order: nothing is left to be removed."""
        if self._life is not None:
            with contextlib.suppress(BrokenPipeError):  # it was killed
                os.write(self._life, b".")
            os.close(self._life)
            self._life = None

    def stop(self, hurry: bool = True) -> list[Exit]:
        """End all processes: SIGINT, then SIGTERM, then SIGKILL; those marked ``last`` after the others. Where there
        is no hurry those who look on end first, while what they lack can still be told again.

        Bounded by the parameters' patience; may be called again.

        Args:
            hurry: false gives slow machines more time.

        Returns:
            How each process ended that was alive before.
        """
        if self._pipe is None:
            return []
        self.deaths()
        before = set(self.pids)
        self.note_shared_memory()
        p, times = self.parameters, 1.0 if hurry else _NO_HURRY
        if not hurry:
            onlookers = [name for name in before if self._processes[name][0].bystander]
            self._end(onlookers, times * p.interrupt_patience_s, times * p.terminate_patience_s)
        for last, patience in ((False, p.interrupt_patience_s), (True, p.recorder_patience_s)):
            names = [name for name in before if self._processes[name][0].last == last and name not in self._exits]
            self._end(names, times * patience, times * p.terminate_patience_s)
        for end in (*self._pipe, *self._gate):
            os.close(end)
        self._pipe = None
        self.clean()
        return [self._exits[name] for name in self._processes if name in before and name in self._exits]

    def _end(self, names: Sequence[str], interrupt_patience: float, terminate_patience: float) -> None:
        for number, patience in (
            (signal.SIGINT, interrupt_patience),
            (signal.SIGTERM, terminate_patience),
            (signal.SIGKILL, _KILL_PATIENCE_S),
        ):
            waiting = [name for name in names if name not in self._exits]
            for name in waiting:
                _signal_group(self._processes[name][1], number)
                if self._processes[name][0].bystander:  # it may stand still, with much to write before it ends
                    _signal_group(self._processes[name][1], signal.SIGCONT)
            deadline = time.monotonic() + patience
            while waiting and time.monotonic() < deadline:
                for name in waiting:
                    node, process = self._processes[name]
                    code = process.poll()
                    if code is not None:
                        forced = number == signal.SIGKILL
                        self._exits[name] = Exit(node, code, self.tail(name), forced)
                        _signal_group(process, signal.SIGKILL)  # whatever it may have started itself
                waiting = [name for name in waiting if name not in self._exits]
                if waiting:
                    time.sleep(_POLL_S)

    def _log_path(self, name: str) -> Path:
        return self.log_folder / f"{name}.log"


def _signal_group(process: ForkedProcess, number: int) -> None:
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        if process.returncode is None:  # it has not yet come to making its own group
            os.kill(process.pid, number)


def _proportional_set_size(pid: int) -> int:
    """Memory of one process [bytes]: its own pages, and its share of those that it shares. 0 when it is gone."""
    try:
        with Path(f"/proc/{pid}/smaps_rollup").open(encoding="ascii") as file:
            return next(int(line.split()[1]) * 1024 for line in file if line.startswith("Pss:"))
    except (OSError, StopIteration):
        return 0
