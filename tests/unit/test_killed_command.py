"""A command that is killed leaves nothing behind: no node, however it is, and no shared memory."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import textwrap
import time
import uuid
from collections.abc import Sequence
from pathlib import Path

import pytest

from tethernet_bringup.mission import shared_memory

DEADLINE_S = 20.0
POLITE = """
    import signal, sys
    from pathlib import Path
    def end(number, frame):
        Path(sys.argv[1]).write_text(signal.Signals(number).name)
        sys.exit(0)
    signal.signal(signal.SIGINT, end)
    print("ready", flush=True)
    signal.pause()
"""
WAITING = """
    from tethernet_ros.start_gate import pass_gate
    print("ready", flush=True)
    pass_gate()
    print("in", flush=True)
"""
HOLDING = """
    import mmap, signal, sys
    maps = []
    for name in sys.argv[1:]:
        with open("/dev/shm/" + name, "rb") as file:
            maps.append(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
    print("ready", flush=True)
    signal.pause()
"""
COMMAND = """
    import sys
    from pathlib import Path
    from tethernet_bringup.mission.supervisor import *
    from tethernet_core.parameters import load
    logs, module, files, *nodes = {words!r}
    crew = Supervisor(Path(logs), mission_environment(1, "localhost", Path(logs)), load(SupervisorParameters))
    for name, *arguments in nodes:
        crew.start(NodeProcess(name, module, arguments=tuple(arguments)))
    for name in files:
        Path("/dev/shm", name).touch()
    print(*crew.pids.values(), flush=True)
    for step in sys.stdin:
        getattr(crew, step.strip())()
        print("done", flush=True)
"""


def until(condition, what):
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


def gone(pid):
    """True when there is no such process, or only its remains."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


class Command:
    """A command with nodes that all run one module; killed at the end, with all that it has left."""

    def __init__(self, folder: Path, source: str, nodes: Sequence[Sequence[str]], files: Sequence[str] = ()):
        """Args:
        folder: for the module and the logs.
        source: of the module.
        nodes: name and arguments of each.
        files: names of shared memory that the command makes once the nodes are started.
        """
        self.logs, self._files = folder / "logs", files
        self.logs.mkdir()
        (folder / "module.py").write_text(textwrap.dedent(source))
        code = textwrap.dedent(COMMAND).format(words=[str(self.logs), "module", list(files), *nodes])
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])}
        self._process = subprocess.Popen(
            [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )
        self.pids = [int(word) for word in self._process.stdout.readline().split()]
        until(lambda: all("ready" in self.log(name) for name, *_ in nodes), "the nodes are not ready")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        for pid in self.pids:
            if not gone(pid):
                os.kill(pid, signal.SIGKILL)
        for path in (path for name in self._files for path in shared_memory.FOLDER.glob(f"*{name}*")):
            path.unlink(missing_ok=True)
        self._process.communicate()

    def log(self, name: str) -> str:
        """What a node has printed."""
        return (self.logs / f"{name}.log").read_text()

    def do(self, *steps: str) -> None:
        """Let the command call these methods of its supervisor."""
        for step in steps:
            print(step, file=self._process.stdin, flush=True)
            assert self._process.stdout.readline() == "done\n"

    def kill(self) -> None:
        """Kill the command, and wait until no node is left."""
        self._process.kill()
        assert self._process.wait(timeout=DEADLINE_S) == -signal.SIGKILL
        until(lambda: all(gone(pid) for pid in self.pids), "a node outlived the command")


def test_nodes_end_in_order(tmp_path):
    with Command(tmp_path, POLITE, [(name, f"{tmp_path}/{name}") for name in ("sim", "recorder")]) as command:
        command.kill()
    assert [(tmp_path / name).read_text() for name in ("sim", "recorder")] == ["SIGINT", "SIGINT"]


def test_a_node_that_hangs_ends_too(tmp_path):
    with Command(tmp_path, POLITE, [(name, f"{tmp_path}/{name}") for name in ("sim", "planner")]) as command:
        os.kill(command.pids[0], signal.SIGSTOP)
        command.kill()
    assert [(tmp_path / name).exists() for name in ("sim", "planner")] == [False, True], "the other ended in order"


def test_a_node_that_is_halted_before_it_can_start_the_sweeper_ends_too(tmp_path):
    with (
        Command(tmp_path, POLITE, [(name, f"{tmp_path}/{name}") for name in ("sim", "planner", "recorder")]) as command,
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as name_of_the_halted,
    ):
        pipe = Path(f"/proc/{command.pids[0]}/fd/0").readlink()
        name_of_the_halted.bind(f"\0tethernet-sweeper-{pipe}-{os.getuid()}-0")
        os.kill(command.pids[0], signal.SIGSTOP)
        command.kill()
    assert [(tmp_path / name).exists() for name in ("sim", "planner", "recorder")] == [False, True, True]


def test_its_shared_memory_goes_where_no_node_was_let_in_yet(tmp_path):
    segment, port = f"fastrtps_{uuid.uuid4().hex[:16]}", "fastrtps_port65007"
    files = [segment, f"{segment}_el", port, f"{port}_el", f"sem.{port}_mutex"]
    with Command(tmp_path, WAITING, [("sim",), ("planner",)], files) as command:
        command.kill()
        for name in (segment, port):
            until(lambda name=name: not list(shared_memory.FOLDER.glob(f"*{name}*")), f"{name} is still there")
        assert command.log("sim") == "ready\n"


def sweepers():
    """Process ids of those that stand by."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and not gone(entry.name):
            with contextlib.suppress(OSError):
                if b"--standing-by" in (entry / "cmdline").read_bytes():
                    found.append(int(entry.name))
    return set(found)


@pytest.mark.parametrize("called_off", [False, True])
def test_its_shared_memory_goes_where_all_nodes_have_ended_already(tmp_path, called_off):
    segment, before = f"fastrtps_{uuid.uuid4().hex[:16]}", sweepers()
    with Command(tmp_path, WAITING, [("sim",)], [segment, f"{segment}_el"]) as command:
        command.do("stand_by", "stop")
        assert all(gone(pid) for pid in command.pids)
        if called_off:
            (shared_memory.FOLDER / segment).touch()  # as if the command's own node held it still
            command.do("call_off")
            until(lambda: sweepers() <= before, "it stands by")
            assert (shared_memory.FOLDER / segment).exists()
        else:
            (shared_memory.FOLDER / segment).touch()
            command.kill()
            until(lambda: not list(shared_memory.FOLDER.glob(f"*{segment}*")), f"{segment} is still there")
            until(lambda: sweepers() <= before, "it has not ended")


ENDED_IN_ORDER = 7
GATE = f"""if True:
    import os, signal, threading
    from tethernet_ros.start_gate import close_gate, pass_gate
    reading, writing = os.pipe()
    os.close(writing)
    signal.signal(signal.SIGINT, lambda *_: os._exit({ENDED_IN_ORDER}))
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    close_gate(reading)
    pass_gate()
"""


def test_a_node_that_nobody_lets_in_any_more_leaves_its_end_to_what_watches_over_it():
    done = subprocess.run([sys.executable, "-c", GATE], timeout=DEADLINE_S, check=False)
    assert done.returncode == ENDED_IN_ORDER


@pytest.fixture
def segments():
    """Names of pretended segments, real files in the folder of all: of the command, of a node, shared, another's."""
    names = [f"fastrtps_{uuid.uuid4().hex[:16]}" for _ in range(4)]
    for name in names:
        (shared_memory.FOLDER / name).write_bytes(bytes(4096))
    (shared_memory.FOLDER / f"{names[0]}_el").touch()
    yield names
    for name in names:
        for left in shared_memory.FOLDER.glob(f"*{name}*"):
            left.unlink()


def test_its_shared_memory_goes_and_nobody_elses(tmp_path, segments):
    the_commands, a_nodes, shared, another = segments
    (tmp_path / "other.py").write_text(textwrap.dedent(HOLDING))
    words = [sys.executable, tmp_path / "other.py", shared, another]
    other = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert other.stdout.readline() == "ready\n"
        nodes = [("sim", the_commands, a_nodes), ("planner", the_commands, shared)]
        with Command(tmp_path, HOLDING, nodes) as command:
            command.kill()
            until(lambda: not list(shared_memory.FOLDER.glob(f"{the_commands}*")), "the command's segment is there")
            until(lambda: not (shared_memory.FOLDER / a_nodes).exists(), "a node's segment is still there")
            assert all((shared_memory.FOLDER / name).exists() for name in segments[2:]), "these are others'"
    finally:
        other.kill()
        other.communicate()
