"""How far a long run is: lines in a file, a bar on a terminal, with what others say above it."""

from __future__ import annotations

import fcntl
import io
import os
import pty
import struct
import subprocess
import sys
import termios
from types import SimpleNamespace

import pytest

from tethernet_learning.run_progress import MissionProgress, Progress


class Terminal(io.StringIO):
    """A terminal, and what is written to it."""

    def __init__(self, columns: int):
        super().__init__()
        self.ends = pty.openpty()
        fcntl.ioctl(self.ends[1], termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))

    def fileno(self) -> int:
        return self.ends[1]

    def isatty(self) -> bool:
        return True


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def on_terminal(monkeypatch):
    made = []

    def make(columns: int = 100, kind: str = "xterm") -> Terminal:
        made.append(Terminal(columns))
        monkeypatch.setenv("TERM", kind)
        monkeypatch.setattr(sys, "stderr", made[-1])
        return made[-1]

    yield make
    for terminal in made:
        for end in terminal.ends:
            os.close(end)


def test_a_file_gets_a_line_after_ten_seconds_and_at_the_end():
    out, clock = io.StringIO(), Clock()
    with Progress("episodes of zenit_8mu", 100, 20, stream=out, clock=clock) as progress:
        for done, clock.now in ((30, 5.0), (40, 10.0), (50, 15.0), (100, 16.0)):
            progress.tell(done, "reward 0.50")
    assert out.getvalue().splitlines() == [
        "40 of 100 episodes of zenit_8mu, reward 0.50, 00:10,  2.00 episodes/s, about 00:30 left",
        "100 of 100 episodes of zenit_8mu, reward 0.50, 00:16,  5.00 episodes/s, about 00:00 left",
    ]


def test_of_missions_every_chunk_is_told_with_its_errors(capsys):
    with MissionProgress(7, 2) as progress:
        progress.add([SimpleNamespace(error="")] * 3)
        progress.add([SimpleNamespace(error=""), SimpleNamespace(error="too far")])
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("5 of 7 flown, 00:00, ")
    assert second.startswith("7 of 7 flown, 1 in error, 00:00, ")


def test_a_terminal_gets_one_line_that_is_overwritten_and_ended(on_terminal):
    terminal = on_terminal()
    with Progress("epochs of mlp", 4) as progress:
        progress.tell(4, "validation loss 0.100")
    assert "100% |" in terminal.getvalue() and "4 of 4 epochs of mlp, validation loss 0.100" in terminal.getvalue()
    assert terminal.getvalue().count("\n") == 1 and terminal.getvalue().endswith("\n")
    assert sys.stderr is terminal


def test_what_others_say_has_a_line_of_its_own_above_the_bar(on_terminal, capsys):
    terminal = on_terminal()
    with Progress("widths", 2) as progress:
        print("compiling the physics kernels", file=sys.stderr, flush=True)
        progress.print("| a row |")
        progress.tell(1)
    assert "\rcompiling the physics kernels\n\r" in terminal.getvalue()
    assert capsys.readouterr().out == "| a row |\n"


def test_an_interrupt_ends_the_bar_before_anything_else_is_said(on_terminal):
    terminal = on_terminal()
    with pytest.raises(KeyboardInterrupt), Progress("scenarios", 2):
        raise KeyboardInterrupt
    assert terminal.getvalue().endswith("\n")


def test_a_narrow_window_cuts_the_line(on_terminal):
    terminal = on_terminal(columns=30)
    with Progress("scenarios of a system with a long name", 2) as progress:
        progress.tell(1)
    lines = terminal.getvalue().replace("\n", "\r").split("\r")
    assert any("1 of 2" in line for line in lines) and all(len(line) < 30 for line in lines)


@pytest.mark.parametrize("terminal", [{"kind": "dumb"}, {"columns": 0}])
def test_a_terminal_that_cannot_move_its_cursor_or_has_no_width_gets_lines(on_terminal, terminal):
    stream = on_terminal(**terminal)
    with Progress("scenarios", 1) as progress:
        progress.tell(1)
    assert stream.getvalue().startswith("1 of 1 scenarios, ") and "\r" not in stream.getvalue()


def test_a_command_that_counts_nothing_does_not_load_what_draws_bars():
    code = "import sys, tethernet_learning.run_progress; sys.exit('tqdm' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0
