"""Whoever flies first is told that the kernels are being compiled."""

import os
import subprocess
import sys

import numba

from tethernet_sim.compiling import COMPILED, COMPILING, compiling_said


def compile_one():
    numba.njit(lambda x: x + 1.0)(1.0)


def test_it_is_said_once_before_and_once_after(capsys):
    said = []
    with compiling_said(said.append):
        compile_one()
        assert [text.partition(":")[0] for text in said] == [COMPILING]
        with compiling_said():
            compile_one()
    assert [text.startswith(start) for text, start in zip(said, (COMPILING, COMPILED), strict=True)] == [True, True]
    with compiling_said():
        compile_one()
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith(COMPILING)
    assert len(told.err.splitlines()) == 2


def test_nothing_is_said_where_nothing_is_compiled(capsys):
    with compiling_said():
        pass
    assert capsys.readouterr() == ("", "")


def test_what_runs_at_every_tick_is_loaded_before_the_mission_begins():
    """Compiled in flight, on a busy machine, it takes longer than a process may answer nothing."""
    code = (
        "from tethernet_core.system import load_system\n"
        "from tethernet_sim.kernels.loads import largest_share\n"
        "from tethernet_sim.warm_up import load_kernels\n"
        "load_kernels(print, load_system('zenit_4mu'))\n"
        "assert largest_share.signatures\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=240)
    assert ended.returncode == 0, ended.stderr


def test_a_flight_without_contact_of_net_with_net_compiles_nothing_of_it(tmp_path):
    # Its kernels are half as much again as all others.
    code = """
import numba
import numpy as np
from tethernet_sim.kernels.crossing_kinds import CrossingThreads, no_crossings
from tethernet_sim.kernels import crossing_law, crossing_work, net_contact

def step(threads, crossed, count, pos):
    work = net_contact.begin(threads, 8, crossed, count)
    net_contact.react(threads, work, pos)
    net_contact.end(threads, work, crossed, count)

def compiled():
    kernels = crossing_work.workspace, crossing_work.store, crossing_law.react
    return sum(len(kernel.signatures) for kernel in kernels)

some = np.zeros((4, crossing_work.RECORD)), np.zeros(1, np.int64), np.zeros((3, 8))
numba.njit(step)(no_crossings(), *some)
print(compiled())
numba.njit(step)(CrossingThreads(np.array([[0, 1], [2, 3]])), *some)
print(compiled())
"""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    told = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert told.stdout.split() == ["0", "3"]
