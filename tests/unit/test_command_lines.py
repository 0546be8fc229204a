"""Command lines and parameter files that cannot be meant: exit status 2 and which it is, before anything starts."""

from __future__ import annotations

import pytest

from tethernet_bringup.mission import command_line as cli
from tethernet_core.parameters import LARGEST_FILE_BYTES

HEAD = "/**:\n  ros__parameters:\n"
LONG = "a" * 300

WORDS = {
    "a policy's name of 300 letters": (["--policy", LONG], "allowed: nominal, rl, or the path"),
    "a policy's path of 300 letters": (["--policy", f"/{LONG}"], "File name too long"),
    "a path of 6000 letters": (["--policy", "/a" * 3000], "there can be no file"),
    "a policy that is a folder": (["--policy", "/tmp"], "there is no file /tmp"),
    "a policy that is a device": (["--policy", "/dev/zero"], "there is no file /dev/zero"),
    "a policy's name that moves the cursor": (["--policy", "\x1b[2J"], r"--policy \x1b[2J: no policy named"),
    "a policy's name in no encoding": (["--policy", "\udcff"], r"--policy \udcff: no policy named"),
    "a parameter file's name of 300 letters": (["--params", LONG], "File name too long"),
    "a parameter file that never ends": (["--params", "/dev/zero"], "more than 256 KiB"),
    "a parameter file that is a folder": (["--params", "/tmp"], "Is a directory"),
    "an empty parameter file": (["--params", "/dev/null"], "expected 'NODE:"),
    "an output folder's name of 300 letters": (["--output", LONG], "File name too long; allowed"),
    "a whole number of 5000 digits": (["--seed", "9" * 5000], "allowed: a whole number from 0 to"),
    "a word of 5000 letters": (["--mus", "x" * 5000], "allowed: a whole number"),
    "a pace of 5000 letters": (["--pace", "x" * 5000], "allowed: realtime or lockstep"),
    "a domain of 5000 digits": (["--domain-id", "1" * 5000], "allowed: a whole number from 0 to 232"),
    "an unknown flag of 5000 letters": (["--" + "x" * 5000], "no such option"),
    "a number beyond all floats": (["--debris", "1e400", "0", "-50"], "1e400: allowed: finite numbers"),
}

FILES = {
    "nested too deeply to parse": ("[" * 20_000, "nested in more than 20 levels"),
    "a value nested too deeply": (f"{HEAD}    policy: {'[' * 3000}{']' * 3000}\n", "nested in more than 20 levels"),
    "maps nested too deeply": ("{a: " * 3000 + "1" + "}" * 3000, "nested in more than 20 levels"),
    "too large": (HEAD + "".join(f"    k{i}: {i}\n" for i in range(40_000)), "more than 256 KiB"),
    "one huge value": (f"{HEAD}    policy: {'a' * 1_000_000}\n", "more than 256 KiB"),
    "a long value": (f"{HEAD}    policy: {'a' * 100_000}\n", "no policy named"),
    "aliases that stand for gigabytes": (
        "a: &a [x,x,x,x,x,x,x,x]\nb: &b [*a,*a,*a,*a,*a,*a]\nc: [*b,*b,*b,*b,*b]\n", "aliases are not allowed"
    ),
    "a NUL in a name": (f'{HEAD}    policy: "/a\\0b"\n', r"there is no file /a\x00b"),
    "no text": (b"\xff\xfe\x00\x01" * 500, "cannot read parameter file"),
    "another encoding": (f"{HEAD}    seed: 3\n".encode("utf-16"), "cannot read parameter file"),
    "a list": ("- 1\n", "got list"),
    "a call": ("!!python/object/apply:os.system ['touch executed']\n", "is not YAML"),
    "two documents": (f"{HEAD}    seed: 3\n---\n{HEAD}    seed: 4\n", "is not YAML"),
    "a parameter twice": (f"{HEAD}    seed: 3\n    seed: 4\n", "seed is given twice"),
    "a list as a key": ("? [a]\n: 3\n", "is not YAML"),
    "a number as a node": ("3:\n  ros__parameters:\n    seed: 3\n", "no node '3'"),
    "a number as a parameter": ("sim:\n  ros__parameters:\n    3: 3\n", "has no parameter 3"),
    "a date": (f"{HEAD}    seed: 2020-01-01\n", "not a whole number"),
    "a date that is none": (f"{HEAD}    seed: 2020-13-45\n", "is not YAML"),
    "nothing": (f"{HEAD}    seed:\n", "not a whole number"),
    "a map": (f"{HEAD}    seed: {{a: 1}}\n", "not a whole number"),
    "a number of 5000 digits": (f"{HEAD}    seed: {'9' * 5000}\n", "is not YAML"),
    "a number beyond 64 bits": (f"{HEAD}    seed: 9999999999999999999\n", "out of range"),
    "a number beyond all floats": (f"{HEAD}    give_up_s: 1{'0' * 400}\n", "not finite"),
    "a predictor's path of 300 letters": (f"{HEAD}    predictor: /{LONG}\n", "File name too long"),
    "an unknown type to record": (f'{HEAD}    extra_topics: "/a no_msgs/msg/Thing"\n', "cannot record /a"),
    "a type outside of its folder": (f'{HEAD}    extra_topics: "/a std_msgs/msg/../String"\n', "cannot be read"),
    "a module for a type": (f'{HEAD}    extra_topics: "/a os/msg/path"\n', "cannot be read; allowed"),
    "no topic's name": (f'{HEAD}    extra_topics: "/a// std_msgs/msg/String"\n', "cannot be read; allowed"),
    "a topic's name of 300 letters": (f'{HEAD}    extra_topics: "/{LONG} std_msgs/msg/String"\n', "cannot be read"),
    "no topic at all": (f'{HEAD}    extra_topics: "weather"\n', "cannot be read; allowed"),
    "a topic that is recorded already": (f'{HEAD}    extra_topics: "/tf tf2_msgs/msg/TFMessage"\n', "recorded already"),
    "a topic twice": (
        f'{HEAD}    extra_topics: "/a std_msgs/msg/String, /a std_msgs/msg/String"\n', "/a is recorded already"
    ),
}  # fmt: skip


@pytest.fixture(autouse=True)
def nothing_starts(monkeypatch, tmp_path):
    def started(*_):
        pytest.fail("a mission was begun")

    monkeypatch.setattr(cli, "_fly", started)
    monkeypatch.chdir(tmp_path)


def refusal(capfd, *words) -> str:
    assert cli.main(words) == 2
    told = capfd.readouterr()
    assert told.out == ""
    assert len(told.err) < 3000, "what is wrong can be found in it"
    assert all(letter.isprintable() or letter == "\n" for letter in told.err)
    assert "Traceback" not in told.err
    return told.err


@pytest.mark.parametrize("case", WORDS)
def test_words_that_cannot_be_meant(capfd, tmp_path, case):
    words, reason = WORDS[case]
    assert reason in refusal(capfd, *words)
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("case", FILES)
def test_parameter_files_that_cannot_be_meant(capfd, tmp_path, case):
    content, reason = FILES[case]
    file = tmp_path / "given.yaml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert reason in refusal(capfd, "--params", str(file))
    assert [path.name for path in tmp_path.iterdir()] == ["given.yaml"]


def test_the_parameter_file_of_a_mission_is_far_below_the_largest_that_is_read(tmp_path):
    from tethernet_bringup.mission import arguments
    from tethernet_bringup.mission import parameters as mission_parameters

    text = mission_parameters.resolve(arguments.parse([])).yaml()
    assert len(text.encode()) * 8 < LARGEST_FILE_BYTES


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), RuntimeError("not foreseen")])
def test_a_mission_that_cannot_be_prepared_has_an_outcome_all_the_same(capfd, monkeypatch, tmp_path, error):
    import json

    def fail(*_):
        raise error

    monkeypatch.setattr(cli, "_fly", fail)
    assert cli.main(["--output", str(tmp_path)]) == 1
    [path] = tmp_path.glob("*/outcome.json")
    outcome = json.loads(path.read_text())
    assert (outcome["exit_status"], outcome["captured"]) == (1, False)
    assert str(error.args[-1]) in outcome["verdict"]
    told = capfd.readouterr()
    assert "run_mission.py: fault:" in told.err and str(error.args[-1]) in told.err
    assert "Traceback" not in told.out + told.err


def test_what_cannot_be_made_sense_of_costs_no_outcome(capfd, monkeypatch, tmp_path):
    import json

    from tests.unit.test_outcome import flown

    def fly(options, setup, folder, record, *_):
        vars(record).update(vars(flown()))
        record.state.phase = 99

    monkeypatch.setattr(cli, "_fly", fly)
    assert cli.main(["--output", str(tmp_path)]) == 1
    [path] = tmp_path.glob("*/outcome.json")
    outcome = json.loads(path.read_text())
    assert (outcome["exit_status"], outcome["captured"]) == (1, False)
    assert any("99 is not a valid Phase" in fault for fault in outcome["faults"])
    told = capfd.readouterr()
    assert "Traceback" not in told.out + told.err
    assert "Traceback" in next(tmp_path.glob("*/logs/run_mission.log")).read_text()


def test_an_outcome_that_cannot_be_written_is_the_reason_that_is_printed(capfd, monkeypatch, tmp_path):
    from tests.unit.test_outcome import flown

    def fly(options, setup, folder, record, *_):
        vars(record).update(vars(flown()))
        (folder.path / "outcome.json").mkdir()
        (folder.path / "outcome.json" / "in the way").touch()

    monkeypatch.setattr(cli, "_fly", fly)
    monkeypatch.setattr("tethernet_bringup.recorder.recording.problems", lambda _: [])
    monkeypatch.setattr("tethernet_bringup.recorder.recording.recorded_messages", lambda *_: {"/clock": 1})
    assert cli.main(["--output", str(tmp_path)]) == 1
    told = capfd.readouterr()
    assert "run_mission.py: fault: cannot write" in told.err
    assert "CAPTURED" not in told.out and "FAULT" in told.out


def test_an_output_folder_below_a_file_is_a_fault_and_no_bad_usage(capfd, tmp_path):
    (tmp_path / "file").touch()
    assert cli.main(["--output", str(tmp_path / "file" / "runs")]) == 1
    assert "Not a directory" in capfd.readouterr().err
