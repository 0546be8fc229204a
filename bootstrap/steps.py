"""The steps of a set-up: what each depends on, and how it is done. Each may be repeated at any time."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from . import fingerprint, ros2cli, runtime
from .clashes import clashes, own_packages
from .errors import SetupError
from .lock import MARK
from .places import MESSAGE_PACKAGES, PYTHON_PACKAGES, Places
from .report import Report
from .tools import run_tool, tool_environment

INSTALL = ("install", "--no-build-isolation", "--only-binary", ":all:", "--no-binary", "empy", "--progress-bar", "off")
"""Wheels only: nothing is compiled behind the user's back. empy (pure Python, needed by rosidl) has none."""

NETWORK_ADVICE = (
    "pip must reach a package index: look at the network, a proxy (HTTPS_PROXY) and `pip config list`, then start "
    "again; what is downloaded already is kept in pip's cache."
)
BUILD_ADVICE = "Look at the log; after the cause is removed just start again. `make clean` makes everything anew."


@dataclass(frozen=True)
class Step:
    """One step of a set-up."""

    name: str
    title: str
    fingerprint: Callable[[Places], str]
    """What the step depends on: the step is done again when this changes."""
    run: Callable[[Places, Report], None]
    installs: bool = False
    """Installs packages: begun and not ended, or changed, it leaves an environment of which nobody knows what is in it,
    and which is then made anew."""
    compiles: bool = False
    """Needs cmake and a compiler."""
    check: Callable[[Places], None] = lambda places: None
    """Raises a SetupError where the step cannot succeed; called before anything is touched."""
    at_hand: Callable[[Places], bool] = lambda places: False
    """Whether the step can be done from what lies beside the environment. An environment that has had it gets it again
    when it is made anew, though this time nobody asks for it."""


def _requirements(places: Places, *names: str) -> list[Path]:
    return [places.requirements / f"{name}.txt" for name in names]


def _make_venv(places: Places, report: Report) -> None:
    base = getattr(
        sys, "_base_executable", sys.executable
    )  # not another venv's python, whose end would be this one's too
    make = [base, "-m", "venv", *(["--system-site-packages"] if places.on_system_python else []), places.venv]
    package = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
    try:
        run_tool(make, places, advice="", on_line=report.update)
    except SetupError:
        # Debian ships Python without ensurepip; a pip for this Python does as well.
        advice = (
            f"This Python has neither venv with pip nor pip; install one, for example with `apt-get install {package}`."
        )
        run_tool([*make[:-1], "--without-pip", "--clear", places.venv], places, advice=advice)
        pip = [base, "-m", "pip", "--python", places.python]
        run_tool(
            [*pip, "install", "-r", *_requirements(places, "installer")], places, advice=f"{advice}\n{NETWORK_ADVICE}"
        )
        return
    _pip(places, report, "-r", *_requirements(places, "installer"))


def _pip(places: Places, report: Report, *arguments: str | Path) -> None:
    """Install with pip, counting the packages that it has looked up."""
    collected = 0

    def on_line(line: str) -> None:
        nonlocal collected
        if line.startswith("Collecting "):
            collected += 1
            report.update(f"{collected} packages looked up")
        else:
            report.update("unpacking" if line.startswith("Installing collected packages") else "")

    run_tool([places.python, "-m", "pip", *INSTALL, *arguments], places, advice=NETWORK_ADVICE, on_line=on_line)


def _install(*names: str) -> Callable[[Places, Report], None]:
    def run(places: Places, report: Report) -> None:
        files: list[str | Path] = [word for path in _requirements(places, *names) for word in ("-r", path)]
        # The lock does not hold on top of a system's Python, which brings packages of its own.
        lock: list[str | Path] = [] if places.on_system_python else ["-c", *_requirements(places, "constraints")]
        _pip(places, report, *files, *lock)
        if not places.on_system_python:
            _pip_check(places)

    return run


def _pip_check(places: Places) -> None:
    """Raises: SetupError: where a package of the set-up lacks what it needs."""
    command = [str(places.python), "-m", "pip", "check"]
    checked = subprocess.run(
        command, cwd=places.venv, env=tool_environment(places), capture_output=True, text=True, check=False
    )
    wrong = clashes(checked.stdout, own_packages(places.requirements.glob("*.txt")))
    if wrong or (checked.stderr and checked.returncode not in (0, 1)):
        said = "\n".join(wrong) or checked.stderr
        raise SetupError(
            f"{said}\nThe installed versions do not fit together: a package of the environment was replaced (`make "
            "clean` makes it anew), a mistake in requirements/, or a package has changed in the index."
        )


def _installed(*names: str) -> Callable[[Places], str]:
    return lambda places: fingerprint.of_contents(_requirements(places, *names, "constraints"))


def _site_packages(places: Places) -> Path:
    found = list(places.venv.glob("lib/python3.*/site-packages"))
    if len(found) != 1:
        raise SetupError(
            f"{places.venv} has {len(found)} site-packages folders instead of one; remove it and start again."
        )
    return found[0]


def _sources_fingerprint(places: Places) -> str:
    names = ("setup.py", "setup.cfg")
    return fingerprint.of_contents(places.sources / package / name for package in PYTHON_PACKAGES for name in names)


def _install_sources(places: Places, report: Report) -> None:
    """The project's own packages, in place: a change of a source file needs no set-up."""
    for package in PYTHON_PACKAGES:  # of an interrupted installation pip would not know how to uninstall it
        for left in (
            *_site_packages(places).glob(f"{package}-*.dist-info"),
            *_site_packages(places).glob(f"*{package}-*.pth"),
        ):
            _remove_commands(places, left)
            _remove(left)
    # "compat" writes plain .pth lines: faster to import through than setuptools' finder, in every process.
    options = ("--no-deps", "--no-build-isolation", "--use-pep517", "--config-settings", "editable_mode=compat")
    folders = [word for package in PYTHON_PACKAGES for word in ("-e", places.sources / package)]
    run_tool(
        [places.python, "-m", "pip", "install", *options, *folders],
        places,
        advice=BUILD_ADVICE,
        on_line=lambda _: report.update(""),
    )
    _pip_check(places)


def _remove_commands(places: Places, metadata: Path) -> None:
    """Those of an earlier installation: one that is there no more would end in a traceback.

    Args:
        places: the environment.
        metadata: the installation's ``.dist-info`` folder.
    """
    from importlib.metadata import Distribution  # not at every start

    for command in Distribution.at(metadata).entry_points.select(group="console_scripts"):
        (places.venv / "bin" / command.name).unlink(missing_ok=True)


def _message_files(places: Places) -> list[Path]:
    patterns = ("package.xml", "CMakeLists.txt", "msg/*.msg", "srv/*.srv")
    return [path for folder in places.message_sources for pattern in patterns for path in sorted(folder.glob(pattern))]


def _build_messages(places: Places, report: Report) -> None:
    """tethernet_msgs and, as no wheel has it, tf2_msgs: built into the environment, so that nothing needs sourcing."""
    _rewrite_cmake_paths(places)
    site_packages = _site_packages(places)
    for package in MESSAGE_PACKAGES:
        patterns = ("share/{}", "include/{}", "lib/lib{}__*", "share/ament_index/resource_index/*/{}")
        installed = [path for pattern in patterns for path in places.venv.glob(pattern.format(package))]
        installed += [*site_packages.glob(package), *site_packages.glob(f"{package}-*.egg-info")]
        for left in installed:
            _remove(left)
    _remove(places.build)

    def on_line(line: str) -> None:
        match = re.match(r"\[(\d+)/(\d+)\]", line)
        report.update(f"{match[1]} of {match[2]}" if match else "")

    environment = tool_environment(places)
    environment.update(AMENT_PREFIX_PATH=str(places.venv), CMAKE_PREFIX_PATH=str(places.venv))
    command: list[str | Path] = [
        places.venv / "bin" / "colcon", "--log-base", places.build / "log",
        "build", "--merge-install", "--install-base", places.venv, "--build-base", places.build,
        "--paths", *places.message_sources, "--event-handlers", "console_direct+", "console_cohesion-",
        "--cmake-args", "-G", "Ninja", f"-DPython3_EXECUTABLE={places.python}",
        "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF",
    ]  # fmt: skip
    run_tool(command, places, advice=BUILD_ADVICE, on_line=on_line, environment=environment)
    imports = "import rclpy, " + ", ".join(f"{package}.msg" for package in MESSAGE_PACKAGES)
    run_tool([places.python, "-c", imports], places, advice=BUILD_ADVICE)


def _rewrite_cmake_paths(places: Places) -> None:
    """The wheels' cmake files name two folders of the machine that built them; put this machine's in their place."""
    # The environment's Python is asked: it need not be the one that runs this.
    ask = "import numpy, sysconfig; print(sysconfig.get_paths()['include'], numpy.get_include(), sep='\\n')"
    include, numpy = run_tool([places.python, "-c", ask], places, advice=BUILD_ADVICE).splitlines()[-2:]
    for path in places.venv.glob("share/**/*.cmake"):
        text = path.read_text(errors="surrogateescape")
        new = re.sub(r"/opt/python/[^/;\"]+/lib/python[0-9.]+/site-packages/numpy/_core/include", lambda _: numpy, text)
        new = re.sub(r"/opt/python/[^/;\"]+/include/python[0-9.]+", lambda _: include, new)
        if new != text:
            path.write_text(new, errors="surrogateescape")


def _kernel_files(places: Places) -> list[Path]:
    """The modules that may hold kernels, as the environment's Python finds them."""
    packages = ("tethernet_core", "tethernet_control", "tethernet_planner", "tethernet_sim")
    folders = [places.sources / package / package for package in packages]
    if places.on_system_python:
        specs = [importlib.util.find_spec(package) for package in packages]
        folders = [Path(folder) for spec in specs if spec for folder in spec.submodule_search_locations or ()]
    return [path for folder in folders for path in sorted(folder.rglob("*.py"))]


def _compile_kernels(*systems: str) -> Callable[[Places, Report], None]:
    """Fill numba's cache, so that the first mission starts as fast as every other.

    Args:
        systems: that are flown for it; none: those that the module thinks of itself.
    """

    def fill(places: Places, report: Report) -> None:
        if places.warm_up.exists():
            given = dict(os.environ) | {MARK: str(places.venv)}
            environment = given if places.on_system_python else runtime.environment(places, tool_environment(places))
            command: list[str | Path] = [places.python, "-P", "-m", "tethernet_sim.warm_up", *systems]
            run_tool(command, places, advice=BUILD_ADVICE, on_line=report.update, environment=environment)

    return fill


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


VENV = Step(
    "venv",
    "Making the environment",
    lambda p: fingerprint.of_contents(_requirements(p, "installer")),
    _make_venv,
    installs=True,
)
PACKAGES = Step(
    "packages", "Installing ROS 2 Jazzy and libraries from pinned wheels",
    _installed("run", "build"), _install("run", "build"), installs=True,
)  # fmt: skip
ROS_PACKAGES = Step(
    "packages", "Installing the libraries that ROS 2 does not bring",
    _installed("ros-jazzy"), _install("ros-jazzy"), installs=True,
)  # fmt: skip
TEST = Step("test", "Installing test tools and linter", _installed("test"), _install("test"), installs=True)
BENCH = Step(
    "bench", "Installing what the benchmarks compare with", _installed("bench"), _install("bench"), installs=True
)
LEARNING = Step(
    "learning", "Installing what training needs", _installed("learning"), _install("learning"), installs=True
)
CLUSTER = Step("cluster", "Installing what a cluster needs", _installed("cluster"), _install("cluster"), installs=True)
VIEW = Step("view", "Installing what shows missions", _installed("view"), _install("view"), installs=True)
SOURCES = Step("sources", "Installing the project's own packages, in place", _sources_fingerprint, _install_sources)
MESSAGES = Step(
    "messages",
    "Building the messages",
    lambda p: fingerprint.of_contents(_message_files(p)),
    _build_messages,
    compiles=True,
)
KERNELS = Step(
    "kernels", "Compiling the physics kernels", lambda p: fingerprint.of_times(_kernel_files(p)), _compile_kernels()
)
GENERAL_KERNELS = Step(
    "general-kernels",
    "Compiling the physics kernels for debris of any shape",
    lambda p: fingerprint.of_times(_kernel_files(p)),
    _compile_kernels("envisat_8mu"),
)
"""A mission that needs them compiles them; the tests need them in any case."""
ROS2CLI = Step(
    "ros2cli",
    "Installing the stock ros2 command",
    ros2cli.of_sources,
    ros2cli.install,
    check=ros2cli.check,
    at_hand=lambda p: bool(ros2cli.wheels(p)),
)
KEPT = (ROS2CLI,)
"""Asked for once, and not lost when the environment is made anew for other reasons."""

MISSION = (VENV, PACKAGES, SOURCES, MESSAGES, KERNELS)
PROFILES: dict[str, tuple[Step, ...]] = {
    "mission": MISSION,
    "analysis": (VENV, PACKAGES, SOURCES),
    "lint": (VENV, PACKAGES, TEST),
    "test": (*MISSION, GENERAL_KERNELS, TEST, BENCH),
    "bench": (*MISSION, BENCH),
    "learning": (*MISSION, LEARNING),
    "cluster": (*MISSION, CLUSTER),
    "ros2cli": (*MISSION, ROS2CLI),
    "view": (*MISSION, VIEW),
}
"""What each use of the environment needs. The tests compare with what the benchmarks compare with, too."""

ROS_MISSION = (VENV, ROS_PACKAGES, KERNELS)
ROS_PROFILES: dict[str, tuple[Step, ...]] = {
    "mission": ROS_MISSION,
    "analysis": (VENV, ROS_PACKAGES),
    "lint": (VENV, TEST),
    "test": (*ROS_MISSION, GENERAL_KERNELS, TEST, BENCH),
    "bench": (*ROS_MISSION, BENCH),
    "learning": (*ROS_MISSION, LEARNING),
    "cluster": (*ROS_MISSION, CLUSTER),
    "ros2cli": ROS_MISSION,
}
"""The same on top of a machine's own ROS 2, where colcon has built messages and packages and `ros2` is there. What
shows missions needs NumPy 2, which ROS 2 Jazzy does not have.
"""
