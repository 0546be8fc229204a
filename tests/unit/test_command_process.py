"""Commands as processes: what they make of closed streams, of Ctrl-C while they import, of the user's own folder."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bootstrap.environment import pending
from bootstrap.places import ROOT, venv_places
from bootstrap.steps import PROFILES
from tests.command import COMMAND, SCRIPT
from tethernet_bringup.cli import tree
from tethernet_bringup.mission.interrupts import Interrupts, MissionInterrupt
from tethernet_bringup.mission.supervisor import NodeProcess, Supervisor, mission_environment
from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_core.parameters import load

PATIENCE_S = 60.0
NODES = {
    "sim": "tethernet_sim.ros.sim_node",
    "planner": "tethernet_planner.planner_node",
    "assessor": "tethernet_planner.assessor_node",
    "recorder": "tethernet_bringup.recorder.recorder_node",
    "viewer": "tethernet_bringup.view.viewer_node",
    "mu1_controller": "tethernet_control.controller_node",
}
MODULES = (
    "tethernet_bringup.mission.command_line",
    "tethernet_bringup.analysis.command_line",
    "tethernet_bringup.view.command_line",
    "tethernet_sim.warm_up",
)
"""Started as ``python -m`` by scripts for users and by the set-up."""
NO_COMMAND_LINE = {"tethernet_sim.warm_up"}
SUBCOMMANDS = tuple(name.split()[1:] for name, _ in tree.leaves())
SCRIPTS = ("run_mission.py", "analyse_mission.py", "view_mission.py")
OF_BAGS = ("tethernet_bringup.analysis.", "tethernet_bringup.view.command_line")
"""Commands that want a bag."""


def trap(folder: Path, names: set[str]) -> Path:
    """A file for each name that leaves a trace when it is imported."""
    trace = folder / "executed"
    for name in names:
        (folder / f"{name}.py").write_text(f"open({str(trace)!r}, 'a').write({name!r} + ' ')\n")
    return trace


def every_name() -> set[str]:
    """Of all modules of the standard library, and of all that is installed."""
    installed = {path.name.partition(".")[0] for entry in sys.path for path in Path(entry or ".").glob("*")}
    return {name for name in sys.stdlib_module_names | installed | {"cupy", "ray"} if name.isidentifier()}


def loaded_first(folder: Path) -> set[str]:
    """What ``python -m`` itself imports before any module of this project."""
    (folder / "probe.py").write_text("import sys\nprint(*sys.modules)\n")
    done = subprocess.run([sys.executable, "-m", "probe"], cwd=folder, capture_output=True, text=True, check=True)
    return {name.partition(".")[0] for name in done.stdout.split()}


@pytest.fixture
def logs(tmp_path):
    folder = tmp_path / "logs"
    folder.mkdir()
    return folder


@pytest.mark.parametrize("node", NODES)
def test_no_node_imports_from_the_working_folder(tmp_path, logs, monkeypatch, node):
    here = tmp_path / "here"
    (here / "lib").mkdir(parents=True)
    traces = [trap(here, every_name()), trap(here / "lib", every_name())]
    environment = mission_environment(1, "localhost", logs, {**os.environ, "PYTHONPATH": ":lib:.:"})
    monkeypatch.chdir(here)
    with Supervisor(logs, environment, load(SupervisorParameters)) as crew:
        crew.start(NodeProcess(node, NODES[node], arguments=("nonsense",)))
        deadline, ended = time.monotonic() + PATIENCE_S, []
        while not ended and time.monotonic() < deadline:
            ended = crew.deaths()
            time.sleep(0.01)
        assert [exit_.code for exit_ in ended] == [2], crew.tail(node)
        assert "unexpected argument 'nonsense'" in crew.tail(node)[-1]
    assert not any(trace.exists() for trace in traces), [trace.read_text() for trace in traces if trace.exists()]


@pytest.mark.parametrize("module", [module for module in MODULES if module not in NO_COMMAND_LINE])
def test_no_module_imports_from_the_working_folder(tmp_path, module):
    refuses_without_importing_from(tmp_path, [sys.executable, "-m", module, "--no-such-flag"])


@pytest.mark.parametrize("words", SUBCOMMANDS, ids=" ".join)
def test_no_subcommand_imports_from_the_working_folder(tmp_path, words):
    refuses_without_importing_from(tmp_path, [str(SCRIPT), *words, "--no-such-flag"])


@pytest.mark.parametrize("words", [["--no-such-flag"], ["fyl"], ["train"]])
def test_the_tree_of_commands_imports_nothing_from_the_working_folder(tmp_path, words):
    refuses_without_importing_from(tmp_path, [str(SCRIPT), *words])
    refuses_without_importing_from(tmp_path, [sys.executable, "-m", "tethernet_bringup.cli", *words])


def refuses_without_importing_from(folder: Path, command: list[str]) -> None:
    early = loaded_first(folder)
    # Before its first line Python looks for the module itself; whoever fears for that starts it with -P.
    first = {"__future__", *(name for name in every_name() if name.startswith("tethernet"))}
    trace = trap(folder, every_name() - early - first)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.returncode == 2, done.stderr
    assert "error: " in done.stderr and "Traceback" not in done.stderr
    assert not trace.exists(), trace.read_text()


@pytest.mark.parametrize("script", SCRIPTS)
def test_no_script_imports_from_its_own_or_the_working_folder(tmp_path, script):
    early = loaded_first(tmp_path)
    root, here = tmp_path / "root", tmp_path / "here"
    root.mkdir()
    here.mkdir()
    shutil.copy(ROOT / script, root)
    (root / "bootstrap").symlink_to(ROOT / "bootstrap")
    names = every_name() - early - {"bootstrap", *(name.partition(".")[0] for name in SCRIPTS)}
    traces = [trap(folder, names) for folder in (root, here)]
    for folder in (root, here):
        done = subprocess.run(
            [sys.executable, root / script, "--no-such-flag"], cwd=folder,
            capture_output=True, text=True, timeout=PATIENCE_S, check=False,
        )  # fmt: skip
        assert done.returncode == 2, done.stderr
    assert not any(trace.exists() for trace in traces), [trace.read_text() for trace in traces if trace.exists()]


def slow_imports(folder: Path) -> None:
    """Libraries in whose import a signal comes for certain."""
    for name in ("numpy", "rclpy", "mcap", "rerun"):
        (folder / f"{name}.py").write_text("import time\nprint('importing', flush=True)\ntime.sleep(600)\n")


@pytest.mark.parametrize("module", MODULES)
def test_ctrl_c_while_a_module_imports_ends_it_without_a_traceback(tmp_path, module):
    slow_imports(tmp_path)
    arguments = ["/nowhere"] if module.startswith(OF_BAGS) else []
    interrupt(tmp_path, [sys.executable, "-P", "-m", module, *arguments])


@pytest.mark.parametrize("words", SUBCOMMANDS, ids=" ".join)
def test_ctrl_c_while_a_subcommand_imports_ends_it_without_a_traceback(tmp_path, words):
    slow_imports(tmp_path)
    example = tree.find(words)[0].load().examples[0]
    interrupt(tmp_path, [*COMMAND, *words, *example.split()])


@pytest.mark.parametrize("script", SCRIPTS)
def test_ctrl_c_while_a_script_starts_ends_it_without_a_traceback(tmp_path, script):
    slow_imports(tmp_path)
    if pending(venv_places(), PROFILES["mission"]):
        pytest.skip("the environment would be set up first")
    interrupt(tmp_path, [sys.executable, str(ROOT / script), *(["/nowhere"] if script in SCRIPTS[1:] else [])])


def interrupt(folder: Path, command: list[str]) -> None:
    process = subprocess.Popen(
        command, env={**os.environ, "PYTHONPATH": str(folder)},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert process.stdout.readline() == "importing\n", process.stderr.read()
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
    assert process.returncode == 130
    assert told.partition(": ")[2] in ("", "interrupted\n"), told


CLOSED = {
    "stdin": ("<&-", ""), "stdout": (">&-", ""), "stderr": ("2>&-", ""), "all": ("<&- >&- 2>&-", ""),
    "a reader that has gone": ("", "| true"), "a full disk": (">/dev/full", ""),
    "a full disk for complaints": ("2>/dev/full", ""),
}  # fmt: skip


@pytest.mark.parametrize("closed", CLOSED)
@pytest.mark.parametrize(
    ("words", "statuses"),
    [
        (["-m", "tethernet_bringup.mission.command_line", "--mus", "5"], {2}),
        (["-m", "tethernet_bringup.mission.command_line", "--params", "/nowhere"], {2}),
        (["-m", "tethernet_bringup.analysis.command_line", "/nowhere"], {1}),
        (["-m", "tethernet_bringup.cli", "fly", "--mus", "5"], {2}),
        (["-m", "tethernet_bringup.cli", "salvage", "/nowhere"], {1}),
        ([str(ROOT / "run_mission.py"), "--mus", "5"], {2}),
    ],
)
def test_closed_streams_change_no_exit_status(tmp_path, closed, words, statuses):
    before, after = CLOSED[closed]
    script = f'"$@" {before} {after}; exit ${{PIPESTATUS[0]}}'
    done = subprocess.run(
        ["bash", "-c", script, "bash", sys.executable, *words],
        cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    assert done.returncode in statuses, done.stderr
    assert "Traceback" not in done.stderr and "Exception ignored" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_mission_outlives_its_terminal_where_nohup_asks_for_it():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Interrupts() as interrupts:
            interrupts.hold()
            os.kill(os.getpid(), signal.SIGHUP)
            interrupts.check()
            os.kill(os.getpid(), signal.SIGINT)
            with pytest.raises(MissionInterrupt, match="SIGINT"):
                interrupts.check()
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
