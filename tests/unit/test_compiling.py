"""Whoever flies first is told that the kernels are being compiled."""

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
