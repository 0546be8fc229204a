"""What the machine must have before a set-up begins: found out first, told all at once."""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from .errors import SetupError
from .places import Places
from .python_version import ALLOWED

SMALLEST_CMAKE = (3, 20)
SPACE_B = 1_500_000_000
"""The environment takes 1.0 GB, building the messages 0.1 GB."""

UNFIT_FOR_PATHS = ':;"$\\\n'
"""These have a meaning of their own in PATH-like variables, in cmake or in a shell."""


def check(places: Places, *, compiler: bool) -> str:
    """Check that a set-up can succeed here.

    Args:
        places: the environment to be made.
        compiler: whether messages will be built.

    Returns:
        What was found, in words.

    Raises:
        SetupError: all that is missing, each with what to do.
    """
    problems, found = [], [f"Python {platform.python_version()}"]
    if sys.version_info[:2] not in ALLOWED:
        allowed = " or ".join(f"{major}.{minor}" for major, minor in ALLOWED)
        problems.append(f"This is Python {platform.python_version()} ({sys.executable}); allowed: {allowed}.")
    if sys.platform != "linux" or platform.machine() != "x86_64":
        problems.append(
            f"This is {sys.platform} on {platform.machine()}; the wheels of ROS 2 Jazzy are for Linux on x86_64. "
            "Elsewhere use a container: docker/README.md."
        )
    unfit = sorted(set(UNFIT_FOR_PATHS) & set(str(places.venv)))
    if unfit:
        problems.append(
            f"The path {str(places.venv)!r} contains {' '.join(map(repr, unfit))}; move the repository elsewhere."
        )
    if compiler:
        problems += _compiler_problems(found)
    if compiler and not places.state.exists():  # later the environment's own Python counts
        problems += _header_problems()
    problems += _folder_problems(places)
    if problems:
        raise SetupError("\n".join(problems))
    return ", ".join(found)


def _compiler_problems(found: list[str]) -> list[str]:
    """What is missing for the build of the messages; what is there is added to ``found``."""
    problems = []
    for name, variable, package in (("cmake", "", "cmake"), ("gcc", "CC", "gcc"), ("g++", "CXX", "g++")):
        command = os.environ.get(variable) or name
        if shutil.which(command.split()[0]) is None:
            wanted = f"{variable}={command}" if os.environ.get(variable) else name
            problems.append(f"{wanted} is not found on PATH; install it, for example with `apt-get install {package}`.")
            continue
        version = _version(command)
        if name == "cmake" and version and version < SMALLEST_CMAKE:
            at_least = ".".join(map(str, SMALLEST_CMAKE))
            problems.append(f"cmake {'.'.join(map(str, version))} is too old; at least {at_least} is needed.")
        if name != "gcc":
            found.append(f"{name} {'.'.join(map(str, version))}".rstrip())
    return problems


def _header_problems() -> list[str]:
    header = Path(sysconfig.get_paths()["include"], "Python.h")
    if header.is_file():
        return []
    package = f"python{sys.version_info.major}.{sys.version_info.minor}-dev"
    return [
        f"{header} is missing: Python's headers are not installed; install them, for example with "
        f"`apt-get install {package}`."
    ]


def _version(command: str) -> tuple[int, ...]:
    """A program's version as it tells it, () where it does not."""
    try:
        output = subprocess.run(
            [*command.split(), "--version"], capture_output=True, text=True, timeout=20, check=False
        ).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ()
    match = re.search(r"(\d+)\.(\d+)(?:\.(\d+))?", output)
    return tuple(int(group) for group in match.groups() if group) if match else ()


def _folder_problems(places: Places) -> list[str]:
    """Whether the environment can be written, and whether there is room for it."""
    folder = places.venv.parent
    try:
        probe = folder / f"{places.venv.name}.probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        return [
            f"{folder} cannot be written ({error.strerror}); make it writable, or name a folder for the environment: "
            "TETHERNET_VENV=/some/folder."
        ]
    free = shutil.disk_usage(folder).free
    if not places.state.exists() and free < SPACE_B:
        return [f"Only {free / 1e9:.2f} GB are free in {folder}; the environment needs {SPACE_B / 1e9:.1f} GB."]
    return []
