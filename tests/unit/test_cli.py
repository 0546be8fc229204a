"""The command ``tethernet`` as a user finds it: overview, help, mistyped words, exit statuses, what it imports."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys

import pytest

from bootstrap.places import ROOT
from tests.command import COMMAND, SCRIPT, tethernet
from tethernet_bringup.cli import tree
from tethernet_core.errors import FaultError, InputError
from tethernet_core.subcommand import Subcommand

LEAVES = dict(tree.leaves())


def told(capsys, *words) -> tuple[int, str, str]:
    status = tethernet(*words)
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    return status, captured.out, captured.err


def test_the_command_alone_shows_the_overview(capsys):
    status, out, err = told(capsys)
    assert (status, err) == (0, "")
    for name in LEAVES:
        assert f" {name.split()[-1]} " in out
    assert "run_mission.py" in out
    assert told(capsys, "--help") == (0, out, "")


GROUPS = {name: member for name, member in tree.TREE.members.items() if isinstance(member, tree.Group)}


@pytest.mark.parametrize("name", [name for name, group in GROUPS.items() if group.alone is None])
def test_a_group_alone_is_bad_usage_and_shows_what_is_in_it(capsys, name):
    status, out, err = told(capsys, name)
    assert (status, out) == (2, "")
    assert f"usage: tethernet {name} COMMAND" in err and "a command is missing; allowed: " in err
    status, out, err = told(capsys, name, "--help")
    assert (status, err) == (0, "") and f"usage: tethernet {name} COMMAND" in out


@pytest.mark.parametrize("name", LEAVES)
def test_every_help_shows_examples_that_can_be_given(capsys, name):
    status, out, err = told(capsys, *name.split()[1:], "--help")
    assert (status, err) == (0, "")
    assert f"usage: {name} " in out and "exit status: 0 " in out
    subcommand = LEAVES[name].load()
    assert isinstance(subcommand, Subcommand)
    assert subcommand.examples
    for words in subcommand.examples:
        assert f"  {name} {words}".rstrip() in out
        assert all(len(line) <= 120 for line in out.splitlines())
        subcommand.parser(name).parse_args(shlex.split(words))


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["trian"], "trian: no such command (did you mean train?); allowed: fly, evaluate"),
        (["train", "polcy"], "polcy: no such command (did you mean policy?); allowed: policy, surrogate"),
        (["systems", "shw", "zenit_8mu"], "did you mean show?"),
        (["sweep"], "did you mean tethernet campaign sweep?"),
        (["evaluate_policies"], "did you mean evaluate?"),
        (["help"], "did you mean --help?"),
        (["xyzzy"], "xyzzy: no such command; allowed: fly"),
        (["\x1b[2J"], r"\x1b[2J: no such command"),
        (["--verbose"], "--verbose: no such option; allowed: --help"),
        (["campaign", "--mus", "8"], "--mus: no such option; allowed: --help, or a command: random"),
        (["fly", "--sytem", "zenit_8mu"], "--sytem: no such option (did you mean --system?)"),
        (["fly", "--syst", "zenit_8mu"], "--syst: no such option (did you mean --system?)"),
        (["fly", "--system", "zenit_8m"], "did you mean zenit_8mu?"),
        (["fly", "--system", "zenit_8mu", "--mus", "8"], "not allowed with argument --system"),
        (["fly", "--mus", "5"], "--mus 5: no shipped system for it; allowed: 4 (zenit_4mu), 8 (zenit_8mu)"),
        (["fly", "--mus", "-4"], "-4: allowed: a whole number from 0"),
        (["fly", "--debris", "0", "0", "-5x"], "-5x: allowed: -1e+06 to 1e+06 m"),
        (["fly", "--debris", "0", "0", "nan"], "nan: allowed"),
        (["fly", "--attitude", "0", "0", "0", "0"], "debris_attitude"),
        (["fly", "--lose", "9", "no_thrust", "3"], "allowed: mu from 1 to 8"),
        (["fly", "--lose", "one", "no_thrust", "3"], "one"),
        (["fly", "--policy", "best"], "no policy named 'best'"),
        (["fly", "--set", "kp=3"], "--set kp=3: allowed: PART.NAME=VALUE"),
        (["fly", "--json", "/nowhere/x.json"], "its folder does not exist"),
        (["fly", "\udcff"], r"\udcff"),
        (["systems", "draw", "zenit_8mu", "--output", "x.jpg"], "allowed: names that end in .png, .svg, .pdf"),
        (["data", "make", "--output", "x"], "one of the arguments --system --mus is required"),
        (["evaluate", "policies", "--mus", "4", "7"], "--mus 7: no shipped system for it"),
        (["check-driver", "--mu", "5", "--mus", "4"], "--mu 5: zenit_4mu has 4 units"),
        (["check-driver", "--mu", "3", "--wait", "0"], "0: allowed: more than 0 s"),
    ],
)
def test_words_that_cannot_be_meant_are_explained(capsys, tmp_path, monkeypatch, words, hint):
    monkeypatch.chdir(tmp_path)
    status, out, err = told(capsys, *words)
    assert (status, out) == (2, "")
    assert hint in err
    assert all(letter.isprintable() or letter == "\n" for letter in err)
    assert list(tmp_path.iterdir()) == []


def run_instead(monkeypatch, error: Exception):
    def run(options):
        raise error

    monkeypatch.setattr(tree.Leaf, "load", lambda _: Subcommand("Fails.", ("",), run))


@pytest.mark.parametrize(
    ("error", "status", "sentence"),
    [
        (InputError("not like this"), 2, "tethernet fly: error: not like this"),
        (FaultError("it is gone"), 1, "tethernet fly: fault: it is gone"),
        (ModuleNotFoundError("No module named 'torch'", name="torch"), 1, "python3 -m bootstrap learning installs it"),
        (ModuleNotFoundError("No module named 'tethernet_msgs'", name="tethernet_msgs.msg"), 1, "bootstrap mission"),
        (OSError(28, "No space left on device", "/full"), 1, "/full: No space left on device"),
        (OSError(36, "File name too long", "x"), 2, "File name too long"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (BrokenPipeError(), 141, ""),
    ],
)
def test_every_end_has_its_status_and_a_sentence(capsys, monkeypatch, error, status, sentence):
    run_instead(monkeypatch, error)
    ended, out, err = told(capsys, "fly")
    assert (ended, out) == (status, "")
    assert sentence in err and err.count("\n") == bool(sentence)


def test_a_mistake_of_the_program_is_not_hidden(monkeypatch):
    run_instead(monkeypatch, ValueError("of the program"))
    with pytest.raises(ValueError, match="of the program"):
        tethernet("fly")


def test_training_without_its_packages_says_what_installs_them_and_leaves_nothing(capsys, monkeypatch, tmp_path):
    for name in ("torch", "stable_baselines3", "cma"):
        monkeypatch.setitem(sys.modules, name, None)
    for words, missing in (("policy", "torch, stable_baselines3"), ("offsets", "cma")):
        output = tmp_path / "run"
        status, _, err = told(capsys, "train", words, "--mus", "4", "--source", "full", "--output", output)
        assert status == 1
        assert f"needs {missing}" in err and "python3 -m bootstrap learning installs" in err
        assert not output.exists()


def loaded(*words: str) -> set[str]:
    code = (
        "import json, sys; from tethernet_bringup.cli.main import main; "
        "main(json.loads(sys.argv[1])); print(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    )
    command = [sys.executable, "-P", "-c", code, json.dumps(words)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    return {name.partition(".")[0] for name in json.loads(done.stderr.splitlines()[-1])}


def test_nothing_is_imported_before_it_is_needed():
    heavy = {"numpy", "numba", "scipy", "matplotlib", "yaml", "rclpy", "torch", "tethernet_sim", "tethernet_learning"}
    assert loaded() & heavy == set()
    assert loaded("train", "--help") & heavy == set()
    assert loaded("systems", "list") & (heavy - {"numpy", "yaml"}) == set()


def test_the_console_script_and_the_module_are_the_same_command():
    command = [[str(SCRIPT), "systems", "list"], [*COMMAND, "systems", "list"]]
    script, module = (subprocess.run(c, capture_output=True, text=True, check=True, timeout=60) for c in command)
    assert script.stdout == module.stdout
    assert script.stderr == module.stderr == ""


def test_systems_are_listed_shown_checked_and_drawn(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _, out, _ = told(capsys, "systems", "list")
    lines = {line.split()[0]: line for line in out.splitlines()[1:]}
    assert {"zenit_4mu", "zenit_8mu"} <= lines.keys()
    assert "529 nodes" in lines["zenit_8mu"] and "cylinder, 9000 kg" in lines["zenit_8mu"]
    assert "docking, 8 pairs" in lines["zenit_8mu"] and "winch, 12 pairs" in lines["zenit_4mu"]

    _, shown, _ = told(capsys, "systems", "show", "zenit_4mu")
    assert "digest" in shown and "reach" in shown
    _, text, _ = told(capsys, "systems", "show", "zenit_4mu", "--yaml")
    (tmp_path / "own.yaml").write_text(text)
    assert told(capsys, "systems", "show", "own.yaml")[1] == shown

    assert told(capsys, "systems", "check", "own.yaml", "zenit_8mu")[0] == 0
    (tmp_path / "wrong.yaml").write_text(
        "based_on: zenit_8mu\nunit: {mass_kg: -1, box_m: [1]}\nchaser: {side_m: 0, colour: red}\n"
        "parameters: {optics: {}}\ndebris: {mass_kg: heavy}\n"
    )
    status, out, _ = told(capsys, "systems", "check", "own.yaml", "wrong.yaml")
    assert status == 1
    good, *mistakes = out.splitlines()
    assert "own.yaml: no mistakes" in good
    places = ["unit.mass_kg", "unit.box_m", "debris.mass_kg", "chaser.colour", "chaser.side_m", "parameters.optics"]
    assert [line.split()[2].rstrip(":") for line in mistakes] == places
    assert all("; allowed: " in line for line in mistakes)
    (tmp_path / "stiff.yaml").write_text(
        "based_on: zenit_8mu\nnet: {thread: {radius_m: 0.003}}\nparameters: {physics: {time_step_s: 0.0002}}\n"
    )
    status, out, _ = told(capsys, "systems", "check", "stiff.yaml")
    assert status == 1 and "time_step_s = 0.0002: unstable" in out and "allowed: at most 0.000111" in out
    status, _, err = told(capsys, "fly", "--system", "wrong.yaml")
    assert status == 2 and "unit.mass_kg = -1" in err and "(and 1 more)" in err

    assert told(capsys, "systems", "draw", "own.yaml", "--output", "own.png")[:2] == (0, "own.png\n")
    assert (tmp_path / "own.png").read_bytes().startswith(b"\x89PNG")
    assert told(capsys, "systems", "draw", "own.yaml", "--output", "none/own.png")[0] == 2


def test_one_mission_is_flown_printed_and_written(capsys, tmp_path):
    short = ["--set", "mission.trigger_distance_m=50", "mission.capture_duration_s=1"]
    file = tmp_path / "flown.json"
    words = ["fly", "--mus", "4", "--debris", "1", "0", "-41", "--seed", "7", "--lose", "2", "no_thrust", "0.5", *short]
    status, out, err = told(capsys, *words, "--json", file)
    assert (status, err) == (3, "")
    assert out.startswith("NOT CAPTURED")
    content = json.loads(file.read_text())
    assert content["scenario"]["debris_position"] == [1.0, 0.0, -41.0]
    assert content["scenario"]["failure"] == {"mu": 2, "kind": "no_thrust", "time_s": 0.5}
    assert content["outcome"]["captured"] is False
    assert f"{sum(content['outcome']['fuel_kg']):.4f} kg in all" in out


def commands_in_the_documentation() -> list[str]:
    """Every line of a code block, and every text in code marks, that gives the command."""
    files = [*ROOT.glob("*.md"), *ROOT.glob("*/README.md"), *ROOT.glob("ros2_ws/src/**/README.md")]
    found = set()
    for file in files:
        text = file.read_text().replace("\\\n", " ")
        for block in re.findall(r"```\w*\n(.*?)```", text, re.DOTALL):
            found |= set(re.findall(r"^(?:\$ )?(?:\.venv/bin/)?(tethernet .*?)(?: +#.*)?$", block, re.MULTILINE))
        found |= set(re.findall(r"`(?:\.venv/bin/)?(tethernet [^`]+)`", text))
    return sorted(found)


def test_the_documentation_gives_many_commands():
    assert len(commands_in_the_documentation()) > 20


@pytest.mark.parametrize("line", commands_in_the_documentation())
def test_commands_in_the_documentation_can_be_given(line):
    node, program, words = tree.find(shlex.split(line.replace("[", "").replace("]", ""))[1:])
    if isinstance(node, tree.Leaf) and words:
        node.load().parser(program).parse_args(words)
