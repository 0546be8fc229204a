"""The set-up's machinery: what is done again and what is not, after changes, kills and side by side."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bootstrap import environment
from bootstrap.environment import ensure, pending, unusable
from bootstrap.errors import SetupError
from bootstrap.lock import MARK
from bootstrap.places import ROOT
from bootstrap.report import Report
from bootstrap.state import load
from tests.unit.setup_steps import NAMES, done, places_in, steps


def set_up(folder: Path) -> str:
    """Do the small set-up; what the user sees of it."""
    seen = io.StringIO()
    ensure(places_in(folder), steps(), Report(seen))
    return seen.getvalue()


def start(folder: Path, *arguments: str) -> subprocess.Popen:
    """Start the small set-up as a process."""
    command = [sys.executable, "-m", "tests.unit.setup_steps", str(folder), *arguments]
    return subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)


def wait_for(process: subprocess.Popen, text: str) -> None:
    """Read what a set-up says until ``text`` comes."""
    for line in process.stderr:
        if text in line:
            return
    pytest.fail(f"the set-up never said {text!r}; exit status {process.wait()}")


def marked(folder: Path) -> list[int]:
    """Processes of the folder's set-up that run."""
    mark = f"{MARK}={folder / '.venv'}".encode()
    found = []
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            if mark in path.read_bytes().split(b"\0"):
                found.append(int(path.parent.name))
        except OSError:
            continue
    return found


def linger(folder: Path, step: str) -> subprocess.Popen:
    """A set-up whose step has a tool with a child running."""
    process = start(folder, step)
    wait_for(process, f"step {step}")
    deadline = time.monotonic() + 20
    while len(marked(folder)) < 2:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return process


def test_first_start_does_all_steps_in_order_and_the_second_none(tmp_path):
    seen = set_up(tmp_path)
    assert done(tmp_path) == list(NAMES)
    assert "[1/4] step venv" in seen and "[4/4] step messages" in seen and "Set-up done" in seen
    assert set_up(tmp_path) == ""
    assert done(tmp_path) == list(NAMES)


def test_looking_whether_all_is_done_is_fast(tmp_path):
    set_up(tmp_path)
    began = time.perf_counter()
    assert pending(places_in(tmp_path), steps()) == []
    assert time.perf_counter() - began < 0.05


def test_a_changed_input_repeats_its_step_alone(tmp_path):
    set_up(tmp_path)
    (tmp_path / "messages").write_text("another field")
    assert [step.name for step in pending(places_in(tmp_path), steps())] == ["messages"]
    set_up(tmp_path)
    assert done(tmp_path) == [*NAMES, "messages"]


def test_changed_requirements_make_the_environment_anew(tmp_path):
    set_up(tmp_path)
    (tmp_path / ".venv" / "left over").touch()
    (tmp_path / "packages").write_text("numpy==9")
    assert "requirements of the step 'packages' have changed" in set_up(tmp_path)
    assert done(tmp_path) == [*NAMES, *NAMES]
    assert not (tmp_path / ".venv" / "left over").exists()


@pytest.mark.parametrize("step", NAMES)
def test_a_set_up_killed_in_any_step_is_repaired_by_the_next(tmp_path, step):
    process = linger(tmp_path, step)
    os.kill(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert len(marked(tmp_path)) == 2  # the tool and its child live on, and must not write into what comes next
    before = done(tmp_path)
    seen = set_up(tmp_path)
    assert marked(tmp_path) == []
    assert "Ended 2 processes" in seen
    if step in ("venv", "packages"):  # half-installed packages: only a new environment is sure
        assert "made anew" in seen
        assert done(tmp_path) == [*before, *NAMES]
    else:
        assert done(tmp_path) == list(NAMES)
    assert pending(places_in(tmp_path), steps()) == []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_an_interrupted_set_up_ends_its_tools(tmp_path, number):
    process = linger(tmp_path, "messages")
    process.send_signal(number)
    assert process.wait(timeout=20) != 0
    assert marked(tmp_path) == []
    set_up(tmp_path)
    assert done(tmp_path) == list(NAMES)


def test_two_starts_side_by_side_do_each_step_once(tmp_path):
    first = linger(tmp_path, "venv")
    second = start(tmp_path)
    wait_for(second, "waiting for it to end")
    first.kill()
    first.wait()
    assert second.wait(timeout=30) == 0, second.stderr.read()
    assert done(tmp_path) == list(NAMES)


def test_a_torn_state_file_makes_the_environment_anew(tmp_path):
    set_up(tmp_path)
    state = tmp_path / ".venv" / "setup.json"
    state.write_text(state.read_text()[:20])
    set_up(tmp_path)
    assert done(tmp_path) == [*NAMES, *NAMES]


def test_a_moved_repository_is_noticed(tmp_path):
    set_up(tmp_path)
    state = tmp_path / ".venv" / "setup.json"
    state.write_text(json.dumps(json.loads(state.read_text()) | {"root": "/elsewhere"}))
    assert "made for /elsewhere" in set_up(tmp_path)


def test_an_interpreter_that_is_gone_is_noticed(tmp_path):
    set_up(tmp_path)
    places = places_in(tmp_path)
    places.python.unlink()
    places.python.symlink_to("/nowhere/python3.11")
    assert "is now missing" in unusable(places, load(places), steps())
    set_up(tmp_path)
    assert pending(places, steps()) == []


def test_an_environment_of_somebody_else_is_left_alone(tmp_path):
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "pyvenv.cfg").touch()
    with pytest.raises(SetupError, match="was not made by this set-up"):
        set_up(tmp_path)
    assert (tmp_path / ".venv" / "pyvenv.cfg").exists()


def test_a_failing_tool_is_shown_with_its_last_lines_the_log_and_an_advice(tmp_path):
    from bootstrap.tools import run_tool

    places = places_in(tmp_path)
    places.venv.mkdir()
    fail = "import sys; print(*range(100), sep='\\n'); print('no space left', file=sys.stderr); sys.exit(7)"
    with pytest.raises(SetupError) as caught:
        run_tool([sys.executable, "-c", fail], places, advice="Buy a disk.")
    text = str(caught.value)
    assert "exit status 7" in text and "no space left" in text and "Buy a disk." in text
    assert "| 99" in text and "| 50" not in text
    assert str(places.log) in text
    assert "50\n" in places.log.read_text()


def test_a_disk_error_is_a_message(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(SetupError, match="TETHERNET_VENV"):
        set_up(tmp_path / "file")


def test_a_set_up_outlives_its_terminal_where_nohup_asks_for_it():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with environment._signals():
            os.kill(os.getpid(), signal.SIGHUP)
            with pytest.raises(environment.Interrupted):
                os.kill(os.getpid(), signal.SIGTERM)
                signal.pause()
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
