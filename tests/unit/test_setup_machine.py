"""What the set-up asks of the machine, and what it says when that is missing."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bootstrap import machine, python_version
from bootstrap.errors import SetupError
from bootstrap.places import ROOT, Places


@pytest.fixture
def places(tmp_path) -> Places:
    return Places(tmp_path, tmp_path / ".venv")


def test_a_fit_machine_is_told_in_words(places):
    if not all(map(shutil.which, ("cmake", "gcc", "g++"))):
        pytest.skip("no compiler here")
    found = machine.check(places, compiler=True)
    assert re.fullmatch(r"Python 3\.1[12]\.\d+\S*, cmake \d+\.\d+\.\d+, g\+\+ \d+\.\d+\.\d+", found)


def test_all_missing_tools_are_told_at_once(places, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(SetupError) as caught:
        machine.check(places, compiler=True)
    for tool in ("cmake", "gcc", "g++"):
        assert f"{tool} is not found on PATH; install it, for example with `apt-get install {tool}`" in str(
            caught.value
        )
    assert machine.check(places, compiler=False)  # an analysis needs none of them


def test_an_old_cmake_is_refused(places, monkeypatch):
    monkeypatch.setattr(machine, "_version", lambda command: (3, 10, 2))
    with pytest.raises(SetupError, match=r"cmake 3\.10\.2 is too old; at least 3\.20"):
        machine.check(places, compiler=True)


def test_a_wrong_python_is_told_with_what_is_allowed(places, monkeypatch):
    monkeypatch.setattr(machine.sys, "version_info", (3, 9, 1, "final", 0))
    with pytest.raises(SetupError, match=r"allowed: 3\.11 or 3\.12"):
        machine.check(places, compiler=False)


def test_missing_python_headers_are_told(places, monkeypatch):
    monkeypatch.setattr(machine.sysconfig, "get_paths", lambda: {"include": "/nowhere"})
    with pytest.raises(SetupError, match=r"/nowhere/Python\.h is missing.*-dev"):
        machine.check(places, compiler=True)


def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(SetupError, match=r"cannot be written.*TETHERNET_VENV"):
        machine.check(Places(tmp_path, tmp_path / "file" / ".venv"), compiler=False)


def test_a_full_disk_is_told(places, monkeypatch):
    monkeypatch.setattr(machine.shutil, "disk_usage", lambda folder: shutil._ntuple_diskusage(10**10, 10**10, 10**8))
    with pytest.raises(SetupError, match=r"Only 0\.10 GB are free"):
        machine.check(places, compiler=False)


def test_a_path_that_tools_would_split_is_refused(tmp_path):
    folder = tmp_path / "a:b"
    folder.mkdir()
    with pytest.raises(SetupError, match="move the repository"):
        machine.check(Places(folder, folder / ".venv"), compiler=False)


@pytest.mark.parametrize(
    "path",
    [
        "run_mission.py",
        "analyse_mission.py",
        "bootstrap/__init__.py",
        "bootstrap/first.py",
        "bootstrap/python_version.py",
    ],
)
def test_what_runs_before_the_version_is_known_is_plain_enough_for_old_pythons(path):
    tree = ast.parse((ROOT / path).read_text(), feature_version=(3, 4))
    allowed_first = {"future", "os", "subprocess", "sys"}
    for node in tree.body:  # not what is inside a function
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        assert set(names) <= allowed_first, names
    strings = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)]
    assert not strings, "f-strings are unknown to Python 2.7"


def test_another_python_on_the_path_is_gone_on_with(monkeypatch, tmp_path, capfd):
    chosen = []
    monkeypatch.setattr(python_version.sys, "version_info", (3, 9, 1, "final", 0))
    monkeypatch.setattr(python_version, "CANDIDATES", ("/nowhere/python", sys.executable))
    monkeypatch.setattr(
        python_version.os, "execvp", lambda program, words: chosen.append((program, words)) or sys.exit(99)
    )
    with pytest.raises(SystemExit) as ended:
        python_version.require_allowed(["run_mission.py", "--mus", "8"])
    assert ended.value.code == 99
    assert chosen == [(sys.executable, [sys.executable, "run_mission.py", "--mus", "8"])]
    assert "Python 3.9.1" in capfd.readouterr().err


def test_no_allowed_python_at_all_is_told_with_what_was_found_and_what_is_allowed(monkeypatch):
    monkeypatch.setattr(python_version.sys, "version_info", (3, 14, 0, "final", 0))
    monkeypatch.setattr(python_version, "CANDIDATES", ("/nowhere/python",))
    with pytest.raises(SystemExit) as ended:
        python_version.require_allowed(["run_mission.py"])
    assert "This is Python 3.14.0" in ended.value.code and "allowed: Python 3.11 or 3.12" in ended.value.code


def old_pythons() -> list[str]:
    names = ("python2.7", "python3.6", "python3.8", "python3.10", "python3.13", "python3.14")
    return [path for path in map(shutil.which, names) if path and python_version.version_of(path)]


@pytest.mark.parametrize("python", old_pythons())
def test_a_start_with_another_python_of_this_machine_goes_on_with_an_allowed_one(python):
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    ended = subprocess.run(
        [python, ROOT / "run_mission.py", "--mus", "5"],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
        timeout=60,
    )
    assert ended.returncode == 2, ended.stderr
    assert "cannot run this; going on with" in ended.stderr
