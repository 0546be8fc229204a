import subprocess
import sys

import pytest

from bootstrap.places import ROOT
from tethernet_bringup.mission import arguments
from tethernet_bringup.mission.arguments import parse
from tethernet_core.system import MOST_UNITS, shipped_systems

SOURCES = ROOT / "ros2_ws" / "src"


def test_nothing_given_leaves_the_decisions_to_the_parameter_files():
    options = parse([])
    assert options.system is None
    assert options.debris is None
    assert options.seed is None
    assert options.pace is None
    assert options.output == "runs"
    assert options.discovery == "localhost"
    assert options.external_mu == []
    assert not options.no_sim
    assert options.notices == []


def test_every_flag_is_read():
    words = (
        "--mus 4 --debris 8.9 6.2 -44.0 --attitude 0 0 0 1 --tumble 0.1 -2e-2 0 --seed 7 --policy nominal "
        "--pace lockstep --output out --external-mu 3 1 3 --params p.yaml --domain-id 42 --discovery subnet "
        "--external-timeout 5 --hold 60 --tow 20.5"
    )
    options = parse(words.split())
    assert options.system == "zenit_4mu"
    assert options.debris == (8.9, 6.2, -44.0)
    assert options.attitude == (0.0, 0.0, 0.0, 1.0)
    assert options.tumble == (0.1, -0.02, 0.0)
    assert (options.seed, options.policy, options.pace, options.output) == (7, "nominal", "lockstep", "out")
    assert options.external_mu == [1, 3]
    assert (options.hold, options.tow) == (60.0, 20.5)
    assert (options.params, options.domain_id, options.discovery, options.external_timeout) == (
        "p.yaml", 42, "subnet", 5.0,
    )  # fmt: skip


def test_attitude_is_normalised_and_said_so():
    options = parse(["--attitude", "0", "0", "2", "0"])
    assert options.attitude == (0.0, 0.0, 1.0, 0.0)
    assert "norm 2" in options.notices[0]


def test_domain_comes_from_the_environment(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "17")
    assert parse([]).domain_id == 17
    assert parse(["--domain-id", "3"]).domain_id == 3
    monkeypatch.delenv("ROS_DOMAIN_ID")
    assert parse([]).domain_id == 0


@pytest.mark.parametrize(
    ("words", "given", "allowed"),
    [
        ("--mus 5", "--mus 5", "4 or 8, or --system"),
        ("--mus eight", "--mus: eight", "a whole number from 0"),
        ("--debris 0 nan -50", "nan", "finite"),
        ("--debris 0 0 -inf", "-inf", "finite"),
        ("--debris 0 0", "--debris", "expected 3 arguments"),
        ("--debris a b c", "--debris: a", "finite numbers"),
        ("--attitude 0 0 0 0", "--attitude 0 0 0 0", "norm 1"),
        ("--attitude 0 0 1e-9 0", "--attitude", "norm 1"),
        ("--tumble nan 0 0", "--tumble", "finite"),
        ("--seed -1", "--seed: -1", "a whole number from 0 to 9223372036854775807"),
        ("--seed 1.5", "--seed: 1.5", "whole number"),
        ("--pace fast", "--pace: fast", "realtime or lockstep"),
        ("--discovery world", "--discovery: world", "localhost or subnet"),
        ("--domain-id 500", "--domain-id: 500", "0 to 232"),
        ("--system zenit_9mu", "--system zenit_9mu: no such system (did you mean zenit_", "passive_5m"),
        ("--system no/such.yaml", "--system no/such.yaml", "path of a description"),
        ("--system hexagonal_6mu --mus 8", "--mus 8 with --system hexagonal_6mu", "--system zenit_8mu"),
        ("--system=", "--system", "nothing given"),
        ("--external-mu 25", "--external-mu: 25", "1 to 24"),
        ("--external-mu", "--external-mu", "expected at least one argument"),
        ("--external-timeout -3", "--external-timeout: -3", "0 s or more"),
        ("--no-sim --pace lockstep", "--pace lockstep", "--pace realtime"),
        ("--params=", "--params", "nothing given"),
        ("--foo", "--foo", "no such option"),
        ("--externalmu 3", "--externalmu", "did you mean --external-mu?"),
        ("--hold long", "--hold: long", "finite numbers"),
        ("--hold 60 --tow nan", "--tow: nan", "finite numbers"),
    ],
)
def test_bad_usage_names_what_was_given_and_what_is_allowed(capsys, words, given, allowed):
    with pytest.raises(SystemExit) as ended:
        parse(words.split())
    assert ended.value.code == 2
    message = capsys.readouterr().err
    assert given in message
    assert allowed in message


def test_a_bad_domain_in_the_environment_is_bad_usage(monkeypatch, capsys):
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    with pytest.raises(SystemExit) as ended:
        parse([])
    assert ended.value.code == 2
    assert "ROS_DOMAIN_ID many" in capsys.readouterr().err


def test_help_tells_the_exit_statuses(capsys):
    with pytest.raises(SystemExit) as ended:
        parse(["--help"])
    assert ended.value.code == 0
    told = capsys.readouterr().out
    assert "3 flown but not captured" in told
    assert "python run_mission.py --mus 8 --hold 60 --tow 20" in told


@pytest.mark.parametrize(
    ("module", "words"),
    [
        ("tethernet_bringup.mission.arguments", ["--mus", "5"]),
        ("tethernet_bringup.view.arguments", [".", "--view", "screen"]),
        ("tethernet_bringup.analysis.arguments", [".", "--format", "txt"]),
    ],
)
def test_bad_usage_is_refused_before_anything_is_installed(module, words):
    """The sources run with nothing but the standard library: no site-packages at all."""
    sources = [str(SOURCES / package) for package in ("tethernet_core", "tethernet_bringup")]
    read = f"from {module} import parse; parse({words})"
    code = f"import sys; sys.path += {sources}\n{read}"
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=False, timeout=30
    )
    assert done.returncode == 2
    assert ("allowed: " in done.stderr or "choose from" in done.stderr) and "Traceback" not in done.stderr


def test_mus_is_short_for_the_system_of_that_name():
    assert parse(["--mus", "8"]).system == parse(["--mus", "8", "--system", "zenit_8mu"]).system == "zenit_8mu"


def test_the_names_known_before_the_set_up_are_those_of_the_package():
    assert arguments.shipped_systems() == shipped_systems()
    assert arguments.MOST_UNITS == MOST_UNITS
