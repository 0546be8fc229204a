"""The stock ``ros2`` command for the environment of wheels: fetched by git, as no package index has it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

from . import fingerprint
from .errors import SetupError
from .places import Places
from .report import Report
from .tools import run_tool, tool_environment

GIT_TIMEOUT_S = 30.0
SOURCES_FILE = "ros2cli-sources.txt"
OTHERWISE = (
    "Without it: a machine with ROS 2 Jazzy, or the container of docker/README.md, has the same command; where a "
    "mirror is at hand, `git config --global url.MIRROR.insteadOf {repository}` leads git there."
)
ADVICE = "What was installed before is as it was. Start `make ros2cli` again; git and pip must reach their servers."


def repositories(places: Places) -> list[str]:
    """The addresses that the sources are fetched from, each once."""
    text = (places.requirements / SOURCES_FILE).read_text(encoding="utf-8")
    return list(dict.fromkeys(re.findall(r"git\+(\S+?)@", text)))


def of_sources(places: Places) -> str:
    """Fingerprint of what is installed."""
    names = ("ros2cli.txt", SOURCES_FILE, "constraints.txt")
    return fingerprint.of_contents([*(places.requirements / name for name in names), places.ros2cli / "setup.py"])


def wheels(places: Places) -> list[Path]:
    """The wheels beside the environment, built from today's sources; none where they have to be fetched."""
    try:
        built_of = (places.ros2cli_wheels / "built_of").read_text(encoding="ascii")
    except OSError:
        return []
    return sorted(places.ros2cli_wheels.glob("*.whl")) if built_of == _wanted(places) else []


def check(places: Places) -> None:
    """Check that the sources can be fetched, before anything is touched.

    Raises:
        SetupError: git is missing, or does not reach a repository: in one sentence, and what else there is.
    """
    if wheels(places):
        return
    addresses = repositories(places)
    if shutil.which("git") is None:
        raise SetupError(
            "git is not found on PATH, and the ros2 command is fetched by git, as no package index has it; install "
            f"git, for example with `apt-get install git`.\n{OTHERWISE.format(repository=addresses[0])}"
        )
    for address in addresses:
        reason = _unreachable(address)
        if reason:
            raise SetupError(
                f"git does not reach {address} ({reason}), and no package index has the ros2 command; "
                f"{places.venv} is as it was.\n{OTHERWISE.format(repository=address)}"
            )


def install(places: Places, report: Report) -> None:
    """Build the wheels beside the environment where they are not there, then install them and what they import."""
    if not wheels(places):
        _build(places, report)
    pip: list[str | Path] = [places.python, "-m", "pip", "install", "--progress-bar", "off"]
    asked, lock = places.requirements / "ros2cli.txt", places.requirements / "constraints.txt"
    run_tool([*pip, "--only-binary", ":all:", "-r", asked, "-c", lock], places, advice=ADVICE, on_line=_alive(report))
    offline = [*pip, "--no-deps", "--no-index"]
    run_tool([*offline, "--force-reinstall", *wheels(places)], places, advice=ADVICE, on_line=_alive(report))
    # Last: its command `ros2` takes the place of the one from the wheels, which it calls.
    in_place = ["--no-build-isolation", "--use-pep517", "--config-settings", "editable_mode=compat", "-e"]
    run_tool([*offline, *in_place, places.ros2cli], places, advice=ADVICE, on_line=_alive(report))


def _build(places: Places, report: Report) -> None:
    folder = places.ros2cli_wheels
    partial = folder.with_name(f"{folder.name}.{os.getpid()}")
    build: list[str | Path] = [places.python, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation"]
    sources = places.requirements / SOURCES_FILE
    environment = tool_environment(places) | {"GIT_TERMINAL_PROMPT": "0"}
    try:
        command = [*build, "--progress-bar", "off", "-w", partial, "-r", sources]
        run_tool(command, places, advice=ADVICE, on_line=_alive(report), environment=environment)
        (partial / "built_of").write_text(_wanted(places), encoding="ascii")
        shutil.rmtree(folder, ignore_errors=True)
        partial.rename(folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _wanted(places: Places) -> str:
    return fingerprint.of_contents([places.requirements / SOURCES_FILE])


def _unreachable(address: str) -> str:
    """Why git does not reach a repository, "" where it does."""
    environment = dict(os.environ) | {"GIT_TERMINAL_PROMPT": "0", "LC_ALL": "C"}
    command = ["git", "ls-remote", "--exit-code", address, "HEAD"]
    try:
        asked = subprocess.run(
            command, capture_output=True, text=True, timeout=GIT_TIMEOUT_S, check=False, env=environment
        )
    except subprocess.TimeoutExpired:
        return f"no answer within {GIT_TIMEOUT_S:g} s"
    if asked.returncode == 0:
        return ""
    said = re.search(r"^(?:fatal|error): (?:unable to access '.*?': )?(.*?)\.?$", asked.stderr, re.MULTILINE)
    return said[1] if said else f"exit status {asked.returncode}"


def _alive(report: Report) -> Callable[[str], None]:
    return lambda _: report.update("")
