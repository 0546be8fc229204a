"""The way of a ROS machine: a clean copy of the workspace, built by colcon, started by ``ros2 run``.

ROS 2 and colcon come from the environment of wheels here; on a machine with ROS 2 they come from /opt/ros/jazzy.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bootstrap.places import PYTHON_PACKAGES, ROOT

pytestmark = [pytest.mark.slow, pytest.mark.ros, pytest.mark.timeout(1200)]

EXECUTABLES = {
    "tethernet_bringup": {"analyse_mission", "recorder", "run_mission", "tethernet", "view_mission", "viewer"},
    "tethernet_control": {"controller"},
    "tethernet_planner": {"assessor", "planner"},
    "tethernet_sim": {"sim"},
}
IGNORED = shutil.ignore_patterns("__pycache__", "*.egg-info", ".numba_cache")


class Workspace:
    """A built copy of ros2_ws/src."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.install = folder / "install"
        prefix = sys.prefix
        self._variables = {"PATH": f"{prefix}/bin:{os.environ['PATH']}", "HOME": os.environ["HOME"]}
        self._variables |= {"AMENT_PREFIX_PATH": prefix, "CMAKE_PREFIX_PATH": prefix}

    def colcon(self, *words: str) -> str:
        """Run colcon in the workspace, with ROS 2 on the search paths as sourcing does it."""
        return self._run([f"{sys.prefix}/bin/colcon", "--log-base", "log", *words])

    def sourced(self, *words: str | Path, **variables: str) -> str:
        """Run a command in a shell that has sourced the workspace."""
        line = f". {shlex.quote(str(self.install / 'setup.sh'))} && exec {shlex.join(map(str, words))}"
        return self._run(["sh", "-c", line], **variables)

    def share(self, package: str) -> Path:
        return self.install / package / "share" / package

    def executable(self, package: str, name: str) -> Path:
        return self.install / package / "lib" / package / name

    def _run(self, command: list[str], **variables: str) -> str:
        ended = subprocess.run(
            command, cwd=self.folder, env=self._variables | variables, capture_output=True, text=True, check=False
        )
        assert ended.returncode == 0, (ended.stdout + ended.stderr)[-6000:]
        return ended.stdout


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    if not Path(sys.prefix, "bin", "colcon").exists():
        pytest.skip("this Python is not that of the set-up: it brings no colcon")
    folder = tmp_path_factory.mktemp("ros2_ws")
    shutil.copytree(ROOT / "ros2_ws" / "src", folder / "src", ignore=IGNORED)
    built = Workspace(folder)
    python = f"-DPython3_EXECUTABLE={sys.executable}"
    summary = built.colcon("build", "--cmake-args", "-G", "Ninja", python)
    assert re.search(rf"{len(PYTHON_PACKAGES) + 1} packages finished", summary), summary
    return built


def test_every_file_of_a_package_is_installed(workspace):
    """Of a package that pip installs in place a forgotten file is never missed."""
    for package in PYTHON_PACKAGES:
        source = workspace.folder / "src" / package / package
        target = next((workspace.install / package).glob(f"lib/python3.*/site-packages/{package}"))
        files = {str(path.relative_to(source)) for path in source.rglob("*") if path.is_file()}
        there = {str(path.relative_to(target)) for path in target.rglob("*") if path.is_file()}
        assert {file for file in files - there if "__pycache__" not in file} == set(), package


def test_configuration_lies_in_share(workspace):
    for package in PYTHON_PACKAGES:
        source = workspace.folder / "src" / package / package
        files = [*source.rglob("config/*.yaml"), *source.glob("systems/*.yaml")]
        for file in files:
            installed = workspace.share(package) / file.parent.name / file.name
            assert installed.read_bytes() == file.read_bytes()
        assert (workspace.share(package) / "package.xml").is_file()


def test_executables_are_where_ros2_run_looks(workspace):
    for package in PYTHON_PACKAGES:
        folder = workspace.install / package / "lib" / package
        found = {path.name for path in folder.iterdir()} if folder.exists() else set()
        assert found == EXECUTABLES.get(package, set())
        assert all(os.access(folder / name, os.X_OK) for name in found)


def test_the_stock_command_lists_and_runs_them(workspace):
    ros2 = Path(sys.prefix, "bin", "ros2")
    if not ros2.exists():
        pytest.skip("NOT TESTED: ros2 run and ros2 pkg; `make ros2cli` installs them")
    lines = workspace.sourced(ros2, "pkg", "executables").splitlines()
    listed = {tuple(line.split()) for line in lines if line.startswith("tethernet_")}
    assert listed == {(package, name) for package, names in EXECUTABLES.items() for name in names}
    prefix = workspace.sourced(ros2, "pkg", "prefix", "--share", "tethernet_sim").strip()
    assert prefix == str(workspace.share("tethernet_sim"))
    shown = workspace.sourced(ros2, "run", "tethernet_bringup", "tethernet", "systems", "list")
    assert re.search(r"^zenit_8mu ", shown, re.MULTILINE)


def test_the_first_mission_waits_for_the_kernels_and_captures(workspace, domain_id, tmp_path):
    run_mission = workspace.executable("tethernet_bringup", "run_mission")
    words = ["--mus", "8", "--pace", "lockstep", "--output", tmp_path, "--domain-id", str(domain_id)]
    said = workspace.sourced(run_mission, *words)
    assert "compiling the physics kernels" in said
    assert "CAPTURED" in said
    assert "site-packages" in workspace.sourced(sys.executable, "-c", "import tethernet_core as c; print(c.__file__)")


def test_colcon_test_finds_tests_in_every_package(workspace):
    workspace.colcon("test", "--packages-select", *PYTHON_PACKAGES, "--return-code-on-test-failure")
    results = workspace.colcon("test-result", "--all", "--test-result-base", "build")
    found = set(re.findall(r"^build/(\w+)/\S+: [1-9]\d* tests?, 0 errors, 0 failures", results, re.MULTILINE))
    assert found == set(PYTHON_PACKAGES), results
